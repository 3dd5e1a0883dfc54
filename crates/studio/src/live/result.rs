//! The target by the pipeline's own transfer, bound again as markers change.

use std::sync::{Arc, Mutex, PoisonError};

use mimesh_core::stage::{
    BindInput, BoundTransfer, MetricContext, MetricInput, Posed, TransferPair, TriangleMap, Work,
};
use mimesh_markers::IntoDiagnostic;
use mimesh_pipeline::{input::read_evenly_spaced, metrics::MetricSet};
use nalgebra::Point3;

use super::pair::LiveMarkers;
use crate::{
    cancel::Cancel,
    error::{ApiError, Code, Result},
    project::{Project, Ready},
    worst::Worst,
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
        let ready = can_have_result(project)?;
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

/// The pipeline, if it can give a result.
///
/// # Errors
///
/// [`Code::NotFound`] while the pipeline has mistakes, and if it has no transfer.
pub fn can_have_result(project: &Project) -> Result<Arc<Ready>> {
    let ready = project.ready().ok_or_else(|| {
        ApiError::new(Code::NotFound, "the pipeline has mistakes, or is still being checked")
            .hint("look at the pipeline")
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

/// The target in a pose, to be measured.
#[derive(Clone, Copy, Debug)]
pub struct Looked<'a> {
    /// The pipeline.
    pub ready: &'a Ready,
    /// The markers.
    pub live: &'a LiveMarkers,
    /// The map, if there is one.
    pub map: Option<&'a TriangleMap>,
    /// The vertices of the source's file.
    pub source: &'a [Point3<f64>],
    /// The vertices of the target's file.
    pub target: &'a [Point3<f64>],
    /// The known result.
    pub truth: Option<&'a [Point3<f64>]>,
}

impl<'a> Looked<'a> {
    fn context(&self) -> MetricContext<'a> {
        let prepared = &self.ready.prepared;
        let pair = TransferPair {
            source: &prepared.source.surface,
            target: prepared.target.seen_surface(),
            markers: &self.live.markers,
            proximity: prepared.proximity.as_ref().map(|proximity| &proximity.graph),
        };
        let rest = &prepared.target.sequence.rest;
        MetricContext { rest, surface: pair.target, pair: Some(pair), map: self.map }
    }

    /// Gives the target to `measure` as metrics see it.
    fn measure<T>(&self, measure: impl FnOnce(MetricInput<'_>) -> Option<T>) -> Option<T> {
        let target = &self.ready.prepared.target;
        let seen = |file: &[Point3<f64>]| Some(target.mirrored_positions(target.surface.from_mesh(file).ok()?));
        let on_surface = seen(self.target)?;
        let source = self.ready.prepared.source.surface.from_mesh(self.source).ok()?;
        let truth_on_surface = self.truth.and_then(seen);
        let ground_truth = self.truth.zip(truth_on_surface.as_deref()).map(|(mesh, surface)| Posed { mesh, surface });
        let alone = MetricInput::alone(Posed { mesh: self.target, surface: &on_surface });
        measure(MetricInput { ground_truth, source: Some(&source), ..alone })
    }

    /// What the metric `name` of the pipeline shows of the target, if it can.
    pub fn field(&self, name: &str) -> Option<Field> {
        let metric = self.ready.prepared.metrics.iter().find(|metric| metric.typetag_name() == name)?;
        let bound = metric.bind(self.context()).ok()?;
        let measured = self.measure(|input| bound.measure(input).ok())?;
        let values: Vec<f32> = measured.field.iter().map(|value| *value as f32).collect();
        let is_whole = values.len() == self.target.len();
        is_whole.then_some(Field { words: measured.field_unit, values, high: measured.field_high })
    }

    /// What is above its limit in this pose, number `pose`, worst first.
    pub fn worst(&self, pose: Option<usize>) -> Vec<Worst> {
        let prepared = &self.ready.prepared;
        let Ok(set) = MetricSet::bind(&prepared.metrics, self.context()) else { return vec![] };
        let set = set.with_gates(&prepared.gates);
        let Some(measured) = self.measure(|input| Some(set.measure(input))) else { return vec![] };
        let metrics = measured.metrics();
        let of_rest =
            set.rest_verdict(&metrics).into_iter().flat_map(|verdict| verdict.reasons).map(|reason| (None, reason));
        let of_pose =
            set.verdict(&metrics).into_iter().flat_map(|verdict| verdict.reasons).map(|reason| (pose, reason));
        let list = of_rest.chain(of_pose).map(|(pose, reason)| Worst::new(pose, &reason, prepared, Some(&measured)));
        Worst::sorted(list.collect())
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
        Looked { ready: &self.ready, live: &self.live, map: self.map.as_ref(), source, target, truth }
    }
}
