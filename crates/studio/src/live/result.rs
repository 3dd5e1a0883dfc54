//! The target by the pipeline's own transfer, bound again as markers change.

use std::sync::{Arc, Mutex, PoisonError, TryLockError};

use mimesh_core::{
    mesh::PosesAre,
    stage::{BindInput, BoundTransfer, TriangleMap, Work},
};
use mimesh_markers::IntoDiagnostic;
use mimesh_pipeline::{input::read_evenly_spaced, shapes::ShapeEditor};
use nalgebra::Point3;
use serde_json::{Value, json};

use super::{
    frames::Frames,
    look::PoseRef,
    measure::Looked,
    pair::{LiveMarkers, pair},
};
use crate::{
    cancel::Cancel,
    container,
    error::{ApiError, Code, Result},
    project::{Project, Ready},
};

/// The pipeline's own transfer, bound to the markers that were asked for last.
#[derive(Debug, Default)]
pub struct ResultEngine {
    bound: Mutex<Option<Arc<BoundResult>>>,
}

/// A transfer that is bound.
#[derive(Debug)]
pub struct BoundResult {
    project: u64,
    live: LiveMarkers,
    ready: Arc<Ready>,
    /// What of the pipeline the result depends on.
    stages: Value,
    map: Option<Arc<TriangleMap>>,
    transfer: Arc<dyn BoundTransfer>,
    /// Frames that were computed ahead.
    pub frames: Frames,
}

impl ResultEngine {
    /// The transfer of the pipeline between the meshes of `project` by `live`; stages report to `report`, and stop if `cancel` says so.
    ///
    /// # Errors
    ///
    /// [`Code::NotFound`] while the pipeline has mistakes, and what stages refuse.
    pub fn bound(
        &self,
        project: &Project,
        live: &LiveMarkers,
        cancel: &Cancel,
        report: &(dyn Fn(&str, f64) + Sync),
    ) -> Result<Arc<BoundResult>> {
        let ready = can_have_result(project)?;
        let mut bound = self.bound.lock().unwrap_or_else(PoisonError::into_inner);
        let before = bound.take_if(|bound| bound.project == project.number && bound.live.markers == live.markers);
        let new = match before {
            Some(same) if Arc::ptr_eq(&same.ready, &ready) => same,
            // Another output, metric or gate changes no result.
            Some(other) if other.stages == stages_of(&ready) => Arc::new(other.measured_by(ready)),
            _ => {
                *bound = None;
                cancel.check();
                Arc::new(bind(project.number, ready, live, cancel, report)?)
            }
        };
        *bound = Some(new.clone());
        Ok(new)
    }

    /// The transfer that is bound to `live`, if it is there at once.
    pub fn at_hand(&self, project: &Project, live: &LiveMarkers) -> Option<Arc<BoundResult>> {
        let bound = match self.bound.try_lock() {
            Ok(bound) => bound.clone()?,
            Err(TryLockError::Poisoned(bound)) => bound.into_inner().clone()?,
            Err(TryLockError::WouldBlock) => return None,
        };
        let ready = project.ready()?;
        let is_present =
            bound.project == project.number && bound.live.markers == live.markers && Arc::ptr_eq(&bound.ready, &ready);
        is_present.then_some(bound)
    }
}

/// What of the pipeline its result depends on, beside meshes and markers.
fn stages_of(ready: &Ready) -> Value {
    let pipeline = &ready.prepared.pipeline;
    let formats = ready.prepared.document.value.get("formats");
    json!([formats, pipeline.source, pipeline.target, pipeline.correspondence, pipeline.transfer, pipeline.proximity])
}

/// The pipeline, if it can give a result.
///
/// # Errors
///
/// [`Code::NotFound`] while the pipeline has mistakes, and if it has no transfer.
pub fn can_have_result(project: &Project) -> Result<Arc<Ready>> {
    let ready = project.ready().ok_or_else(|| match project.pipeline.is_checking() {
        true => ApiError::new(Code::NotFound, "the pipeline is being checked"),
        false => ApiError::new(Code::NotFound, "the pipeline has mistakes").hint("look at the pipeline under Stages"),
    })?;
    if ready.prepared.pipeline.transfer.is_none() {
        return Err(ApiError::new(Code::NotFound, "the pipeline has no transfer"));
    }
    Ok(ready)
}

fn bind(
    project: u64,
    ready: Arc<Ready>,
    live: &LiveMarkers,
    cancel: &Cancel,
    report: &(dyn Fn(&str, f64) + Sync),
) -> Result<BoundResult> {
    let prepared = &ready.prepared;
    let Some(transfer) = &prepared.pipeline.transfer else {
        return Err(ApiError::new(Code::NotFound, "the pipeline has no transfer"));
    };
    let refused = |stage: &str| {
        let stage = stage.to_owned();
        move |error: mimesh_core::Error| ApiError::from(error.into_diagnostic().doing(stage))
    };
    let pair = pair(&ready, live);
    let watched = |stage: String| {
        move |share: f64| {
            cancel.check();
            report(&stage, share);
        }
    };
    let map = match &prepared.pipeline.correspondence {
        Some(stage) => {
            let name = format!("correspondence ({})", stage.typetag_name());
            report(&name, 0.0);
            let watch = watched(name.clone());
            let map = stage.correspond_watched(pair, Work::new(&watch)).map_err(refused(&name))?;
            map.check(pair).map_err(refused(&name))?;
            Some(map)
        }
        None => None,
    };
    cancel.check();
    let name = format!("transfer ({})", transfer.typetag_name());
    report(&name, 0.0);
    let poses = read_evenly_spaced(&prepared.source, &prepared.formats, &prepared.poses, transfer.poses_wanted());
    let poses = poses.map_err(refused(&name))?;
    cancel.check();
    let watch = watched(name.clone());
    let input = BindInput { pair, map: map.as_ref(), poses: &poses, work: Work::new(&watch) };
    let bound = transfer.bind(input).map_err(refused(&name))?;
    let (stages, map, transfer) = (stages_of(&ready), map.map(Arc::new), bound.into());
    Ok(BoundResult {
        project,
        live: live.clone(),
        stages,
        map,
        transfer,
        ready: ready.clone(),
        frames: Frames::default(),
    })
}

impl BoundResult {
    /// The same transfer, with results measured by other metrics and changed by other settings of shapes.
    fn measured_by(&self, ready: Arc<Ready>) -> Self {
        let Self { project, live, stages, map, transfer, frames, .. } = self;
        let (live, stages, map, transfer) = (live.clone(), stages.clone(), map.clone(), transfer.clone());
        // Shapes that are masked or strengthened otherwise look otherwise.
        let are_same = self.ready.prepared.shape_edits == ready.prepared.shape_edits;
        let frames = if are_same { frames.plain() } else { Frames::default() };
        Self { project: *project, live, ready, stages, map, transfer, frames }
    }

    /// The revision of the pipeline that it is of.
    pub fn pipeline(&self) -> u64 {
        self.ready.revision
    }

    /// What a run writes for `pose` of `project`, as the target's file, where the source's file is at `posed`.
    ///
    /// A blend of shapes is the blend of their results, as whoever has the file will blend them.
    ///
    /// # Errors
    ///
    /// What the transfer refuses, and poses that cannot be read.
    pub fn at(&self, project: &Project, pose: &PoseRef, posed: &[Point3<f64>]) -> Result<Vec<Point3<f64>>> {
        match pose {
            PoseRef::Index { index } => self.transferred(posed, self.place(project, *index)),
            PoseRef::Blend { blend } if project.poses_are == PosesAre::Shapes => self.blended(project, blend),
            PoseRef::Blend { .. } | PoseRef::Rest => self.transferred(posed, None),
        }
    }

    /// The place among the poses of the pipeline of the pose `index` of `project`; `None` if the pipeline leaves it out.
    fn place(&self, project: &Project, index: usize) -> Option<usize> {
        self.ready.place_of(project.poses.get(index)?)
    }

    /// The target at `posed`, changed as the pipeline says of its pose `place`.
    fn transferred(&self, posed: &[Point3<f64>], place: Option<usize>) -> Result<Vec<Point3<f64>>> {
        let refused = |error: mimesh_core::Error| ApiError::from(error.into_diagnostic());
        let prepared = &self.ready.prepared;
        let source = prepared.source.surface.from_mesh(posed).map_err(refused)?;
        let mut moved = self.transfer.transfer(&source).map_err(refused)?.positions;
        if let Some(place) = place {
            let editor = ShapeEditor::new(prepared, pair(&self.ready, &self.live));
            editor.edit(place, &source, &mut moved, || self.map.as_deref()).map_err(refused)?;
        }
        let moved = prepared.target.mirrored_positions(moved);
        prepared.target.surface.to_mesh(&moved).map_err(refused)
    }

    fn blended(&self, project: &Project, blend: &[(usize, f64)]) -> Result<Vec<Point3<f64>>> {
        let rest = &self.ready.prepared.target.sequence.rest.positions;
        let origin = project.meshes.origins[1];
        let mut sum = rest.clone();
        for &(index, weight) in blend.iter().filter(|(_, weight)| *weight != 0.0) {
            let shape = match self.frames.positions(index) {
                Some(shape) => container::absolute(&shape, origin),
                None => {
                    let shape = self.transferred(&project.pose(index)?, self.place(project, index))?;
                    self.frames.put(index, Arc::new(container::relative(&shape, origin)));
                    shape
                }
            };
            let moves = sum.iter_mut().zip(&shape).zip(rest);
            moves.for_each(|((sum, shape), rest)| *sum += (shape - rest) * weight);
        }
        Ok(sum)
    }
}

impl BoundResult {
    /// The target's file at `target`, to be measured; `source` is the source's file, `truth` the known result.
    pub fn looked<'a>(
        &'a self,
        source: &'a [Point3<f64>],
        target: &'a [Point3<f64>],
        truth: Option<&'a [Point3<f64>]>,
    ) -> Looked<'a> {
        Looked { ready: &self.ready, live: &self.live, map: self.map.as_deref(), source, target, truth }
    }
}
