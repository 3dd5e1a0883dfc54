//! Statistics above their limits, worst first, with where to look.

use std::cmp::Ordering;

use mimesh_pipeline::{
    Prepared,
    metrics::{Level, PoseMeasurements, Reason},
};
use serde::Serialize;

/// The most entries of a list.
const MAX_ENTRIES: usize = 200;

/// A statistic above its limit.
#[derive(Clone, Debug, Serialize)]
pub struct Worst {
    pose: Option<usize>,
    pose_name: Option<String>,
    metric: String,
    title: String,
    value: Option<f64>,
    unit: String,
    limit: f64,
    level: Level,
    about: Option<String>,
    vertex: Option<usize>,
}

impl Worst {
    /// The statistic that `reason` of `pose` is about; `measured` are the measurements of the pose, if they are at hand.
    pub fn new(pose: Option<usize>, reason: &Reason, prepared: &Prepared, measured: Option<&PoseMeasurements>) -> Self {
        let metric = prepared.metrics.iter().find(|metric| metric.typetag_name() == reason.metric);
        let statistics = metric.map(|metric| metric.statistics()).unwrap_or_default();
        let statistic = statistics.iter().find(|statistic| statistic.name == reason.statistic);
        Self {
            pose,
            pose_name: pose.and_then(|i| prepared.poses.get(i)).map(|pose| pose.name.clone()),
            metric: reason.metric.clone(),
            title: format!("{} {}", reason.metric, reason.statistic).replace('_', " "),
            value: reason.value,
            unit: statistic.map_or("", |statistic| statistic.unit).into(),
            limit: reason.limit,
            level: reason.level,
            about: reason.about.clone().or_else(|| reason.note.clone()),
            vertex: measured.and_then(|measured| worst_vertex(measured, &reason.metric)),
        }
    }

    /// The list with the worst first, and no longer than a page shows.
    pub fn sorted(mut list: Vec<Self>) -> Vec<Self> {
        list.sort_by(|a, b| (b.level, b.ratio()).partial_cmp(&(a.level, a.ratio())).unwrap_or(Ordering::Equal));
        list.truncate(MAX_ENTRIES);
        list
    }

    /// How many times its limit the value is.
    fn ratio(&self) -> f64 {
        self.value.map_or(f64::INFINITY, |value| value.abs() / self.limit.abs().max(1e-12))
    }
}

/// The vertex of the target's file at which a metric shows the largest number.
fn worst_vertex(measured: &PoseMeasurements, metric: &str) -> Option<usize> {
    let (_, measured) = measured.measured.iter().find(|(name, _)| name == metric)?;
    let known = measured.field.iter().enumerate().filter(|(_, value)| value.is_finite());
    known.max_by(|a, b| a.1.total_cmp(b.1)).map(|(vertex, _)| vertex)
}
