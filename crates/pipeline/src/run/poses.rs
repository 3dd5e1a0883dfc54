//! Poses of a run, read and transferred, ready to be measured.

use std::path::Path;

use mimesh_core::{
    Error, Result,
    mesh::check_finite,
    stage::{BoundTransfer, Transferred},
};
use mimesh_document::{Diagnostic, Location};
use mimesh_markers::IntoDiagnostic;
use nalgebra::Point3;
use rayon::prelude::*;
use tracing::{Span, debug_span};

use super::{
    measure::{Measurer, PosedPose},
    stages::Stages,
};
use crate::{
    cache::PosedTarget,
    input::{PoseFrom, PoseInput, Prepared, read_pose},
    shapes::ShapeEditor,
    shard::PoseOrder,
    staging::Transaction,
};

/// Sends the poses of a run through its stages.
pub(super) struct PoseRunner<'a> {
    /// The pipeline.
    pub prepared: &'a Prepared,
    /// The files that the run writes.
    pub transaction: &'a Transaction,
    /// The stages that run once.
    pub stages: &'a Stages<'a>,
    /// The measurements and the pictures.
    pub measurer: &'a Measurer<'a>,
    /// Changes shapes as the pipeline says.
    pub shapes: &'a ShapeEditor<'a>,
    /// Whether only files of one pose each are written.
    pub is_part: bool,
}

/// Something of a pose, or why there is none.
pub(super) type PoseResult<T> = std::result::Result<T, Diagnostic>;

/// The source in a pose.
pub(super) struct SourcePose {
    /// The vertices of its surface.
    pub surface: Vec<Point3<f64>>,
    /// Vertices on seams that are closed at rest and open here.
    opened: usize,
}

impl<'a> PoseRunner<'a> {
    /// The poses of the run in their order.
    pub fn order(&self) -> &'a PoseOrder {
        self.stages.order
    }

    /// The pose at `place` in the order, which was cached.
    pub fn reused(&self, place: usize, target: PosedTarget) -> PoseResult<PosedPose> {
        let pose = &self.prepared.poses[self.order().poses()[place]];
        // The source is only there to measure against; where it cannot be read, less is measured.
        let posed = if self.measurer.wants_source(place) { self.read(pose, &Span::current()).ok() } else { None };
        self.measurable(place, target, true, posed.map(|posed| posed.surface))
    }

    /// The poses at some places of the order, which stand alone.
    pub fn transferred(&self, places: &[usize], bound: &dyn BoundTransfer) -> Vec<PoseResult<PosedPose>> {
        let span = Span::current();
        let poses = self.order().poses();
        let read = |&place: &usize| self.read(&self.prepared.poses[poses[place]], &span);
        let sources: Vec<_> = places.par_iter().map(read).collect();
        let readable: Vec<&[Point3<f64>]> = sources.iter().flatten().map(|source| source.surface.as_slice()).collect();
        let mut transferred = self.transfer_span(readable.len()).in_scope(|| bound.transfer_all(&readable)).into_iter();
        let results: Vec<_> = sources
            .into_iter()
            .map(|source| source.map(|source| (source, transferred.next().expect("each pose has a result"))))
            .collect();
        let posed = |(&place, result): (&usize, PoseResult<(SourcePose, Result<Transferred>)>)| {
            let (source, transferred) = result?;
            debug_span!(parent: &span, "result").in_scope(|| self.posed(place, source, transferred))
        };
        places.par_iter().zip(results).map(posed).collect()
    }

    /// The result of the pose at `place`; it is cached at once, so that a run that is killed afterwards need not transfer it again.
    pub fn posed(&self, place: usize, source: SourcePose, transferred: Result<Transferred>) -> PoseResult<PosedPose> {
        let i = self.order().poses()[place];
        let target = self.target(i, &source, transferred).map_err(|error| {
            let name = self.stages.transfer.typetag_name();
            pose_error(&self.prepared.poses[i].name, None, Some(format!("transfer ({name})")), error)
        });
        let target = target?;
        if let Some(cache) = self.stages.pose_cache() {
            cache.put(i, &target);
        }
        self.measurable(place, target, false, Some(source.surface))
    }

    /// Caches frame `i` of the motion that begins at `begin`, the last before a part: the part before has the same frame, and how far they
    /// are apart shows what the warm frames were worth.
    pub fn keep_last_warm_frame(&self, i: usize, begin: usize, source: &SourcePose, transferred: Result<Transferred>) {
        if let (Some(cache), Ok(target)) = (self.stages.pose_cache(), self.target(i, source, transferred)) {
            cache.put_warm_frame(i, begin, &target);
        }
    }

    /// The target's mesh when the source is at `source`.
    fn target(&self, i: usize, source: &SourcePose, transferred: Result<Transferred>) -> Result<PosedTarget> {
        let Transferred { mut positions, mut figures } = transferred?;
        self.shapes.edit(i, &source.surface, &mut positions, || self.stages.cached_map())?;
        if source.opened > 0 {
            figures.warn(format!(
                "{} vertices of the source lie on a seam that is closed at rest and opens in this pose; it is taken for closed: name them by `opened_seams` in `source` if they are to open",
                source.opened
            ));
        }
        let target = &self.prepared.target;
        let positions = target.surface.to_mesh(&target.mirrored_positions(positions))?;
        check_finite(&positions).map_err(|error| {
            let hint =
                "the method cannot cope with this pose; look at it, and for degenerate triangles of the rest meshes";
            Error::data(format!("result: {error}"), hint)
        })?;
        Ok(PosedTarget { positions, figures })
    }

    /// A posed target with all that metrics ask for.
    fn measurable(
        &self,
        place: usize,
        target: PosedTarget,
        reused: bool,
        source: Option<Vec<Point3<f64>>>,
    ) -> PoseResult<PosedPose> {
        let rest = &self.prepared.target;
        let source = source.filter(|_| self.measurer.wants_source(place));
        let surface = if self.measurer.is_measuring(place) {
            let surface = rest.surface.from_mesh(&target.positions).map(|surface| rest.mirrored_positions(surface));
            let name = &self.prepared.poses[self.order().poses()[place]].name;
            surface.map_err(|error| pose_error(name, None, None, error))?
        } else {
            vec![]
        };
        Ok(PosedPose { target, surface, reused, source })
    }

    /// The span of a transfer of `count` poses.
    pub fn transfer_span(&self, count: usize) -> Span {
        debug_span!("transfer", "type" = self.stages.transfer.typetag_name(), count)
    }

    /// The source in a pose, for what `span` is about.
    pub fn read(&self, pose: &PoseInput, span: &Span) -> PoseResult<SourcePose> {
        let _reading = debug_span!(parent: span, "read", pose = &*pose.name).entered();
        let source = &self.prepared.source;
        let file = if let PoseFrom::File(file) = &pose.from { Some(file.as_path()) } else { None };
        let mesh = read_pose(source, &self.prepared.formats, &pose.from)
            .map_err(|error| pose_error(&pose.name, file, None, error))?;
        let on_surface = || {
            let opened = source.surface.opened_seams(&mesh, 1e-6_f64.max(3.0 * source.welding.tolerance))?;
            Ok((source.surface.from_mesh(&mesh)?, opened))
        };
        let (surface, opened) = on_surface().map_err(|error| pose_error(&pose.name, file, None, error))?;
        Ok(SourcePose { surface, opened })
    }
}

/// The diagnostic of an error about the pose `name`, at its file if it has one; `doing` is the action that failed.
pub fn pose_error(name: &str, file: Option<&Path>, doing: Option<String>, error: Error) -> Diagnostic {
    let diagnostic = error.into_diagnostic();
    let diagnostic = match doing {
        Some(doing) => diagnostic.doing(format!("{doing}: pose {name}")),
        None => diagnostic,
    };
    match (diagnostic.location.is_none(), file) {
        (true, Some(file)) => diagnostic.at(Location::File(file.into())),
        _ => diagnostic,
    }
}
