//! The target by the pipeline's own transfer, bound again as markers change.

use std::sync::{Arc, Mutex, PoisonError};

use mimesh_core::stage::{
    BindInput, BoundTransfer, MetricContext, MetricInput, Posed, TransferPair, TriangleMap, Work,
};
use mimesh_markers::IntoDiagnostic;
use mimesh_pipeline::input::read_evenly_spaced;
use nalgebra::Point3;

use super::pair::LiveMarkers;
use crate::{
    cancel::Cancel,
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
    map: Option<TriangleMap>,
    transfer: Box<dyn BoundTransfer>,
}

/// A colour of each vertex of the target's file.
#[derive(Clone, Debug)]
pub struct Field {
    /// What it shows and its unit.
    pub words: &'static str,
    /// The numbers; NaN where unknown.
    pub values: Vec<f32>,
    /// The end of the colour scale.
    pub high: f64,
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
        let ready = project.ready().ok_or_else(|| {
            ApiError::new(Code::NotFound, "the pipeline has mistakes, or is still being checked")
                .hint("look at the pipeline")
        })?;
        let mut bound = self.bound.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(bound) = &*bound
            && bound.project == project.number
            && bound.live.markers == live.markers
            && Arc::ptr_eq(&bound.ready, &ready)
        {
            return Ok(bound.clone());
        }
        *bound = None;
        cancel.check();
        let new = Arc::new(bind(project.number, ready, live, cancel, report)?);
        *bound = Some(new.clone());
        Ok(new)
    }
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
    let pair = TransferPair {
        source: &prepared.source.surface,
        target: prepared.target.seen_surface(),
        markers: &live.markers,
        proximity: prepared.proximity.as_ref().map(|proximity| &proximity.graph),
    };
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
    Ok(BoundResult { project, live: live.clone(), map, transfer: bound, ready: ready.clone() })
}

impl BoundResult {
    /// The target's file when the source's is at `posed`.
    ///
    /// # Errors
    ///
    /// What the transfer refuses.
    pub fn at(&self, posed: &[Point3<f64>]) -> Result<Vec<Point3<f64>>> {
        let refused = |error: mimesh_core::Error| ApiError::from(error.into_diagnostic());
        let prepared = &self.ready.prepared;
        let source = prepared.source.surface.from_mesh(posed).map_err(refused)?;
        let moved = self.transfer.transfer(&source).map_err(refused)?.positions;
        let moved = prepared.target.mirrored_positions(moved);
        prepared.target.surface.to_mesh(&moved).map_err(refused)
    }
}

/// What the metric `name` of the pipeline shows of the target at `result`, if it can: `posed` is the source's file, `truth` the known
/// result.
pub fn field(
    ready: &Ready,
    live: &LiveMarkers,
    map: Option<&TriangleMap>,
    name: &str,
    [posed, result]: [&[Point3<f64>]; 2],
    truth: Option<&[Point3<f64>]>,
) -> Option<Field> {
    let prepared = &ready.prepared;
    let metric = prepared.metrics.iter().find(|metric| metric.typetag_name() == name)?;
    let target = &prepared.target;
    let pair = TransferPair {
        source: &prepared.source.surface,
        target: &target.surface,
        markers: &live.markers,
        proximity: prepared.proximity.as_ref().map(|proximity| &proximity.graph),
    };
    let context = MetricContext { rest: &target.sequence.rest, surface: &target.surface, pair: Some(pair), map };
    let on_surface = target.surface.from_mesh(result).ok()?;
    let source = prepared.source.surface.from_mesh(posed).ok()?;
    let truth_on_surface = truth.and_then(|truth| target.surface.from_mesh(truth).ok());
    let ground_truth = truth.zip(truth_on_surface.as_deref()).map(|(mesh, surface)| Posed { mesh, surface });
    let input = MetricInput {
        ground_truth,
        source: Some(&source),
        ..MetricInput::alone(Posed { mesh: result, surface: &on_surface })
    };
    let measured = metric.bind(context).ok()?.measure(input).ok()?;
    let values: Vec<f32> = measured.field.iter().map(|value| *value as f32).collect();
    (values.len() == result.len()).then_some(Field { words: measured.field_unit, values, high: measured.field_high })
}

impl BoundResult {
    /// What a metric shows of the target at `result`; see [`field`].
    pub fn field(&self, name: &str, both: [&[Point3<f64>]; 2], truth: Option<&[Point3<f64>]>) -> Option<Field> {
        field(&self.ready, &self.live, self.map.as_ref(), name, both, truth)
    }
}
