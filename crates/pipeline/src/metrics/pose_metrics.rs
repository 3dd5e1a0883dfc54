//! The measurements of a pose: in full while pictures are taken, and as reports and the cache keep them.

use mimesh_core::stage::Measured;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use crate::json::to_value;

/// The measurements of all metrics on one pose.
#[derive(Debug, Default)]
pub struct PoseMeasurements {
    /// Type and measurement of each metric that has statistics of this pose.
    pub measured: Vec<(String, Measured)>,
    /// Type and error of each metric that failed.
    pub failed: Vec<(String, String)>,
}

/// The part of [`PoseMeasurements`] that reports and verdicts are made from: all but the fields for pictures.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct PoseMetrics {
    /// The statistics by type of metric.
    pub statistics: Map<String, Value>,
    /// Metric, statistic and name of the thing that its value belongs to.
    pub about: Vec<(String, String, String)>,
    /// Type and error of each metric that failed; for a verdict also metrics whose ground truth could not be read.
    pub failed: Vec<(String, String)>,
    /// The statistics of the target at rest against the ground truth, as if nothing had been transferred.
    pub rest_baseline: Map<String, Value>,
}

impl PoseMeasurements {
    /// The statistics by type of metric.
    pub fn statistics(&self) -> Map<String, Value> {
        let value = |measured: &Measured| to_value(&measured.statistics);
        self.measured.iter().map(|(name, measured)| (name.clone(), value(measured))).collect()
    }

    /// The same without fields for pictures and without a baseline.
    pub fn metrics(&self) -> PoseMetrics {
        let mut about = Vec::new();
        for (metric, measured) in &self.measured {
            about
                .extend(measured.about.iter().map(|(name, thing)| (metric.clone(), (*name).to_owned(), thing.clone())));
        }
        PoseMetrics { statistics: self.statistics(), about, failed: self.failed.clone(), rest_baseline: Map::new() }
    }
}

impl PoseMetrics {
    /// The name of the thing that the value of a statistic belongs to, if it is one among many.
    pub fn about(&self, metric: &str, statistic: &str) -> Option<&str> {
        let found = self.about.iter().find(|(of, name, _)| of == metric && name == statistic);
        found.map(|(_, _, thing)| thing.as_str())
    }

    /// The value of a statistic; `None` if it was not measured.
    pub fn value(&self, metric: &str, statistic: &str) -> Option<f64> {
        self.statistics.get(metric)?.get(statistic)?.as_f64()
    }
}
