//! The statistics of a pose. A run of ten thousand poses keeps all of them, so that they are small.

use std::sync::Arc;

use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::{Map, Number, Value};

/// For each metric its statistics, as the mapping `{metric: {statistic: value}}`.
///
/// The names, which are most of such a mapping, may be [shared](Self::share_names) by all poses.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Statistics {
    names: Arc<Names>,
    /// The values of all metrics, one after another.
    values: Box<[Entry]>,
}

/// Each metric with the names of its statistics, in their order.
type Names = Vec<(String, Vec<String>)>;

/// A value.
#[derive(Clone, Debug, PartialEq)]
enum Entry {
    Number(Number),
    /// A list or another value that is no number.
    Other(Box<Value>),
}

impl Entry {
    fn new(value: Value) -> Self {
        match value {
            Value::Number(number) => Self::Number(number),
            other => Self::Other(Box::new(other)),
        }
    }

    fn value(&self) -> Value {
        match self {
            Self::Number(number) => Value::Number(number.clone()),
            Self::Other(value) => Value::clone(value),
        }
    }

    fn as_f64(&self) -> Option<f64> {
        match self {
            Self::Number(number) => number.as_f64(),
            Self::Other(_) => None,
        }
    }
}

impl Statistics {
    /// Whether no metric has any.
    pub fn is_empty(&self) -> bool {
        self.names.is_empty()
    }

    /// The metrics, in their order.
    pub fn metrics(&self) -> impl Iterator<Item = &str> {
        self.names.iter().map(|(metric, _)| metric.as_str())
    }

    /// The statistics of a metric as a mapping; `None` if it has none.
    pub fn get(&self, metric: &str) -> Option<Map<String, Value>> {
        let (names, values) = self.of(metric)?;
        Some(names.iter().cloned().zip(values.iter().map(Entry::value)).collect())
    }

    /// Whether a statistic is there.
    pub fn contains(&self, metric: &str, statistic: &str) -> bool {
        self.entry(metric, statistic).is_some()
    }

    /// A statistic as a number; `None` if it is not there, or is no number.
    pub fn number(&self, metric: &str, statistic: &str) -> Option<f64> {
        self.entry(metric, statistic)?.as_f64()
    }

    /// The first statistic of a metric that is a number.
    pub fn first_number(&self, metric: &str) -> Option<&str> {
        let (names, values) = self.of(metric)?;
        let is_number = |(_, value): &(&String, &Entry)| matches!(value, Entry::Number(_));
        names.iter().zip(values).find(is_number).map(|(name, _)| name.as_str())
    }

    /// Takes the names from `other` where both have the same.
    pub fn share_names(&mut self, other: &Self) {
        if self.names == other.names {
            self.names = other.names.clone();
        }
    }

    fn of(&self, metric: &str) -> Option<(&[String], &[Entry])> {
        let mut start = 0;
        for (name, statistics) in &*self.names {
            let end = start + statistics.len();
            if name == metric {
                return Some((statistics, &self.values[start..end]));
            }
            start = end;
        }
        None
    }

    fn entry(&self, metric: &str, statistic: &str) -> Option<&Entry> {
        let (names, values) = self.of(metric)?;
        values.get(names.iter().position(|name| name == statistic)?)
    }
}

impl From<Map<String, Value>> for Statistics {
    /// Takes over such a mapping. What is no mapping of a metric has no statistics.
    fn from(mapping: Map<String, Value>) -> Self {
        let mut values = Vec::new();
        let mut names = Names::with_capacity(mapping.len());
        for (metric, statistics) in mapping {
            let statistics = if let Value::Object(statistics) = statistics { statistics } else { Map::new() };
            let (of_metric, entries): (Vec<_>, Vec<_>) =
                statistics.into_iter().map(|(name, value)| (name, Entry::new(value))).unzip();
            values.extend(entries);
            names.push((metric, of_metric));
        }
        Self { names: Arc::new(names), values: values.into() }
    }
}

impl Serialize for Statistics {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.metrics().map(|metric| (metric, self.get(metric))))
    }
}

impl<'de> Deserialize<'de> for Statistics {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Map::deserialize(deserializer).map(Self::from)
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn example(mean: f64) -> (Value, Statistics) {
        let mapping = json!({
            "point_error": { "mean": mean, "within": [1.0, 2.5], "worst": "a", "count": 7 },
            "volume": {},
            "jitter": { "mean": 1e300, "low": -3 },
        });
        (mapping.clone(), mapping.as_object().unwrap().clone().into())
    }

    #[test]
    fn a_mapping_comes_back_with_its_order() {
        let (mapping, statistics) = example(0.1);
        assert_eq!(serde_json::to_string(&statistics).unwrap(), mapping.to_string());
        assert_eq!(serde_json::from_value::<Statistics>(mapping.clone()).unwrap(), statistics);
        assert_eq!(json!(statistics.get("point_error")), mapping["point_error"]);
        assert_eq!(statistics.metrics().collect::<Vec<_>>(), ["point_error", "volume", "jitter"]);
    }

    #[test]
    fn statistics_are_found_by_metric_and_name() {
        let (_, statistics) = example(0.1);
        assert_eq!(statistics.number("jitter", "low"), Some(-3.0));
        assert_eq!(statistics.number("point_error", "worst"), None);
        assert_eq!(statistics.number("point_error", "low"), None);
        assert!(statistics.contains("point_error", "worst") && !statistics.contains("volume", "mean"));
        assert_eq!(statistics.first_number("point_error"), Some("mean"));
        assert_eq!((statistics.first_number("volume"), statistics.get("area_change")), (None, None));
    }

    #[test]
    fn poses_share_names_where_these_are_the_same() {
        let (first, mut second) = (example(0.1).1, example(0.2).1);
        second.share_names(&first);
        assert!(Arc::ptr_eq(&first.names, &second.names));
        assert_eq!(second, example(0.2).1);
        let mut other = Statistics::from(json!({ "volume": { "mean": 1.0 } }).as_object().unwrap().clone());
        other.share_names(&first);
        assert_eq!(other.number("volume", "mean"), Some(1.0));
    }
}
