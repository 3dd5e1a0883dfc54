//! What metrics say of the target in a pose.

use mimesh_core::stage::{BoundMetric, MetricContext, MetricInput, Posed, TriangleMap};
use mimesh_pipeline::metrics::MetricSet;
use nalgebra::Point3;

use super::pair::{LiveMarkers, pair};
use crate::{
    project::{Project, Ready},
    worst::Worst,
};

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
        let pair = pair(self.ready, self.live);
        let rest = &self.ready.prepared.target.sequence.rest;
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
        self.field_of(self.bound_metric(name)?.as_ref())
    }

    /// The metric `name` of the pipeline, bound to the rest meshes; it serves all poses.
    pub fn bound_metric(&self, name: &str) -> Option<Box<dyn BoundMetric + 'a>> {
        let metric = self.ready.prepared.metrics.iter().find(|metric| metric.typetag_name() == name)?;
        metric.bind(self.context()).ok()
    }

    /// What `metric` shows of the target, if it can.
    pub fn field_of(&self, metric: &dyn BoundMetric) -> Option<Field> {
        let measured = self.measure(|input| metric.measure(input).ok())?;
        let values: Vec<f32> = measured.field.iter().map(|value| *value as f32).collect();
        let is_whole = values.len() == self.target.len();
        is_whole.then_some(Field { words: measured.field_unit, values, high: measured.field_high })
    }

    /// What is above its limit in this pose, number `index` of `project`, worst first.
    pub fn worst(&self, project: &Project, index: Option<usize>) -> Vec<Worst> {
        let prepared = &self.ready.prepared;
        let Ok(set) = MetricSet::bind(&prepared.metrics, self.context()) else { return vec![] };
        let set = set.with_gates(&prepared.gates);
        let Some(measured) = self.measure(|input| Some(set.measure(input))) else { return vec![] };
        let metrics = measured.metrics();
        let pose = index.and_then(|index| self.ready.place_of(project.poses.get(index)?));
        let of_rest =
            set.rest_verdict(&metrics).into_iter().flat_map(|verdict| verdict.reasons).map(|reason| (None, reason));
        let of_pose =
            set.verdict(&metrics).into_iter().flat_map(|verdict| verdict.reasons).map(|reason| (pose, reason));
        let list =
            of_rest.chain(of_pose).map(|(pose, reason)| Worst::new(pose, &reason, project, prepared, Some(&measured)));
        Worst::sorted(list.collect())
    }
}
