//! Gates: limits that a pipeline sets for statistics.

use std::collections::BTreeMap;

use mimesh_core::stage::{Metric, Statistic};

use super::verdict::{Level, Reason};

/// A limit that a pipeline sets: a pose fails if the size of its statistic is larger.
#[derive(Clone, Debug, PartialEq)]
pub struct Gate {
    /// The key in the pipeline.
    pub key: String,
    /// The type of the metric.
    pub metric: String,
    /// The statistic.
    pub statistic: String,
    /// The largest size that passes.
    pub limit: f64,
}

/// A key of `gates` that names no statistic.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unknown {
    /// The key in the pipeline.
    pub key: String,
    /// All keys that name a statistic.
    pub known: Vec<String>,
}

/// A key that gates may have, and the statistic that it names.
struct Key {
    key: String,
    metric: &'static str,
    statistic: &'static str,
}

impl Gate {
    /// The reason that this gate gives if its statistic could not be measured.
    pub fn unmeasured(&self) -> Reason {
        Reason {
            note: None,
            level: Level::Failed,
            metric: self.metric.clone(),
            statistic: self.statistic.clone(),
            about: None,
            value: None,
            limit: self.limit,
        }
    }
}

/// The gates in `given` (key and limit), and the keys that name no statistic of `metrics`.
///
/// A key is `METRIC_STATISTIC`, or `METRIC` for the primary statistic.
pub fn gates(given: &BTreeMap<String, f64>, metrics: &[Box<dyn Metric>]) -> (Vec<Gate>, Vec<Unknown>) {
    let keys: Vec<Key> = metrics.iter().flat_map(|metric| keys(metric.as_ref())).collect();
    let (mut gates, mut unknown) = (Vec::new(), Vec::new());
    for (key, &limit) in given {
        match keys.iter().find(|known| known.key == *key) {
            Some(Key { metric, statistic, .. }) => {
                let (metric, statistic) = ((*metric).to_owned(), (*statistic).to_owned());
                gates.push(Gate { key: key.clone(), metric, statistic, limit });
            }
            None => {
                let known = keys.iter().map(|known| known.key.clone()).collect();
                unknown.push(Unknown { key: key.clone(), known });
            }
        }
    }
    (gates, unknown)
}

/// The keys that gates of `metric` may have.
fn keys(metric: &dyn Metric) -> Vec<Key> {
    let (name, statistics) = (metric.typetag_name(), metric.statistics());
    let short = statistics.first().map(|primary| Key { key: name.into(), metric: name, statistic: primary.name });
    let full = |statistic: &Statistic| Key {
        key: format!("{name}_{}", statistic.name),
        metric: name,
        statistic: statistic.name,
    };
    short.into_iter().chain(statistics.iter().map(full)).collect()
}
