//! Poses of a run, read and transferred, ready to be measured.

use std::{ops::Range, path::Path};

use mimesh_core::{
    Error, Result,
    mesh::check_finite,
    stage::{BoundTransfer, Motion, Transferred},
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
}

/// Something of a pose, or why there is none.
pub(super) type PoseResult<T> = std::result::Result<T, Diagnostic>;

/// The source in a pose.
struct SourcePose {
    /// The vertices of its surface.
    surface: Vec<Point3<f64>>,
    /// Vertices on seams that are closed at rest and open here.
    opened: usize,
}

impl<'a> PoseRunner<'a> {
    /// A pose from the cache.
    pub(super) fn reused(&self, pose: &PoseInput, target: PosedTarget) -> PoseResult<PosedPose> {
        // The source is only there to measure against; where it cannot be read, less is measured.
        let posed = if self.measurer.wants_source() { self.read(pose, &Span::current()).ok() } else { None };
        self.measurable(pose, target, true, posed.map(|posed| posed.surface))
    }

    /// Poses that stand alone.
    pub(super) fn transferred(&self, poses: &[usize], bound: &dyn BoundTransfer) -> Vec<PoseResult<PosedPose>> {
        let span = Span::current();
        let read = |&i: &usize| self.read(&self.prepared.poses[i], &span);
        let sources: Vec<_> = poses.par_iter().map(read).collect();
        let readable: Vec<&[Point3<f64>]> = sources.iter().flatten().map(|source| source.surface.as_slice()).collect();
        let mut transferred = self.transfer_span(readable.len()).in_scope(|| bound.transfer_all(&readable)).into_iter();
        let results: Vec<_> = sources
            .into_iter()
            .map(|source| source.map(|source| (source, transferred.next().expect("each pose has a result"))))
            .collect();
        let posed = |(&i, result): (&usize, PoseResult<(SourcePose, Result<Transferred>)>)| {
            let (source, transferred) = result?;
            debug_span!(parent: &span, "result").in_scope(|| self.posed(i, source, transferred))
        };
        poses.par_iter().zip(results).map(posed).collect()
    }

    /// Frames of one motion: read side by side, but transferred one after the other.
    pub(super) fn frames(&self, frames: Range<usize>, motion: &mut dyn Motion) -> Vec<PoseResult<PosedPose>> {
        let poses = &self.prepared.poses;
        let span = Span::current();
        let read: Vec<_> = frames.clone().into_par_iter().map(|i| self.read(&poses[i], &span)).collect();
        let transferred: Vec<_> = frames
            .clone()
            .zip(read)
            .map(|(i, source)| {
                let source = source?;
                let transferred = self.transfer_span(1).in_scope(|| motion.frame(i, &source.surface));
                Ok((source, transferred))
            })
            .collect();
        let posed = |(i, result): (usize, PoseResult<(SourcePose, Result<Transferred>)>)| {
            let (source, transferred) = result?;
            debug_span!(parent: &span, "result").in_scope(|| self.posed(i, source, transferred))
        };
        frames.into_par_iter().zip(transferred).map(posed).collect()
    }

    /// Brings a motion to frame `end`; the results before it are there already.
    pub(super) fn replay(&self, end: usize, motion: &mut dyn Motion) {
        for (i, pose) in self.prepared.poses[..end].iter().enumerate() {
            if let Ok(source) = self.read(pose, &Span::current()) {
                // A frame that failed was reported when it came first.
                let _ = motion.frame(i, &source.surface);
            }
        }
    }

    /// The result of pose `i`; it is cached at once, so that a run that is killed afterwards need not transfer it again.
    fn posed(&self, i: usize, source: SourcePose, transferred: Result<Transferred>) -> PoseResult<PosedPose> {
        let pose = &self.prepared.poses[i];
        let target = self.target(i, &source, transferred).map_err(|error| {
            let name = self.stages.transfer.typetag_name();
            pose_error(&pose.name, None, Some(format!("transfer ({name})")), error)
        })?;
        if let Some(cache) = self.stages.pose_cache() {
            cache.put(i, &target);
        }
        self.measurable(pose, target, false, Some(source.surface))
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
        pose: &PoseInput,
        target: PosedTarget,
        reused: bool,
        source: Option<Vec<Point3<f64>>>,
    ) -> PoseResult<PosedPose> {
        let rest = &self.prepared.target;
        let source = source.filter(|_| self.measurer.wants_source());
        let surface = if self.measurer.is_measuring() {
            let surface = rest.surface.from_mesh(&target.positions).map(|surface| rest.mirrored_positions(surface));
            surface.map_err(|error| pose_error(&pose.name, None, None, error))?
        } else {
            vec![]
        };
        Ok(PosedPose { target, surface, reused, source })
    }

    /// The span of a transfer of `count` poses.
    fn transfer_span(&self, count: usize) -> Span {
        debug_span!("transfer", "type" = self.stages.transfer.typetag_name(), count)
    }

    /// The source in a pose, for what `span` is about.
    fn read(&self, pose: &PoseInput, span: &Span) -> PoseResult<SourcePose> {
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
