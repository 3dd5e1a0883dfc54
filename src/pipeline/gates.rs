//! Gates: limits that a pipeline sets for figures.

use std::collections::BTreeMap;

use super::{
    judge::{Level, Reason},
    report::PoseReport,
};
use crate::core::stage::Metric;

/// A limit that a pipeline sets: a pose whose figure is larger, whatever its sign, fails.
#[derive(Clone, Debug, PartialEq)]
pub struct Gate {
    /// As it is written.
    pub key: String,
    /// Type of the metric.
    pub metric: String,
    /// Its figure.
    pub figure: String,
    /// The largest that passes.
    pub limit: f64,
}

impl Gate {
    /// Whether its figure was measured in any of `poses`, or is told to be missing in one.
    pub fn is_measured(&self, poses: &[PoseReport]) -> bool {
        let told = |reason: &Reason| reason.level == Level::Failed && reason.metric == self.metric;
        poses.iter().any(|pose| {
            pose.metrics.get(&self.metric).is_some_and(|figures| figures.get(&self.figure).is_some())
                || pose.verdict.as_ref().is_some_and(|verdict| verdict.reasons.iter().any(told))
        })
    }

    /// That its figure could not be measured.
    pub(super) fn unmeasured(&self) -> Reason {
        let Self { metric, figure, limit, .. } = self;
        let (metric, figure) = (metric.clone(), figure.clone());
        Reason { level: Level::Failed, metric, figure, about: None, value: None, limit: *limit }
    }
}

/// The gates that `given` declares for `metrics`: `METRIC_FIGURE`, or `METRIC` for the figure that says most.
///
/// # Errors
///
/// For each key that stands for none the key, and all that could be meant.
pub fn gates(given: &BTreeMap<String, f64>, metrics: &[Box<dyn Metric>]) -> (Vec<Gate>, Vec<Unknown>) {
    let mut known: Vec<(String, &'static str, &'static str)> = Vec::new();
    for metric in metrics {
        let (name, figures) = (metric.typetag_name(), metric.figures());
        known.extend(figures.first().map(|first| (name.to_owned(), name, *first)));
        known.extend(figures.iter().map(|figure| (format!("{name}_{figure}"), name, *figure)));
    }
    let (mut gates, mut unknown) = (Vec::new(), Vec::new());
    for (key, &limit) in given {
        match known.iter().find(|(name, ..)| name == key) {
            Some((_, metric, figure)) => {
                gates.push(Gate { key: key.clone(), metric: (*metric).into(), figure: (*figure).into(), limit });
            }
            None => {
                let known = known.iter().map(|(name, ..)| name.clone()).collect();
                unknown.push(Unknown { key: key.clone(), known });
            }
        }
    }
    (gates, unknown)
}

/// A gate of no figure.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unknown {
    /// As it is written.
    pub key: String,
    /// What could stand there.
    pub known: Vec<String>,
}
