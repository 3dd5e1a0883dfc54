//! Statistics over all poses of a run, combined as their metrics declare.

use mimesh_core::{
    plugin,
    stage::{Aggregate, Metric, Statistic},
};
use serde_json::{Map, Value, json};

use super::{
    declared::{declared, unit},
    verdict::Reason,
};
use crate::report::{PoseReport, Report};

/// The statistic that stands for a metric in tables.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PrimaryStatistic {
    /// The type of the metric.
    pub metric: String,
    /// The statistic.
    pub statistic: String,
}

impl PrimaryStatistic {
    /// Its value in a pose; `None` if it was not measured.
    pub fn of(&self, pose: &PoseReport) -> Option<f64> {
        pose.metrics.number(&self.metric, &self.statistic)
    }

    /// The gate of a run for it, the smaller one if both its keys are set.
    pub fn gate(&self, report: &Report) -> Option<f64> {
        let Self { metric, statistic } = self;
        // The metric alone names the gate of the statistic that it declares first.
        let is_first = declared(metric).first().is_some_and(|first| first.name == statistic);
        let keys = [Some(format!("{metric}_{statistic}")), is_first.then(|| metric.clone())];
        let gates = keys.iter().flatten().filter_map(|key| report.gates.get(key)?.as_f64());
        gates.reduce(f64::min)
    }

    /// Its name in words with its unit: `point error mean, %`.
    pub fn words(&self) -> String {
        format!("{} {}{}", self.metric, self.statistic, self.unit_behind()).replace('_', " ")
    }

    /// Its unit behind its name: `, %`; empty where it is not known, or is the name itself.
    pub fn unit_behind(&self) -> String {
        match unit(&self.metric, &self.statistic) {
            "" => String::new(),
            unit if unit == self.statistic => String::new(),
            unit => format!(", {unit}"),
        }
    }

    /// Whether all poses share its value, since its metric looks at rest meshes, markers and the map alone.
    pub fn is_of_rest(&self) -> bool {
        plugin::instance::<dyn Metric>(&self.metric).is_some_and(|metric| metric.is_of_rest())
    }
}

/// The first declared statistic of each metric that measured `poses`, and all statistics that verdicts on poses give as reasons.
///
/// `point_error` comes first, since a known error says more than a suspicion.
pub fn primary_statistics(poses: &[PoseReport]) -> Vec<PrimaryStatistic> {
    let mut all: Vec<PrimaryStatistic> = Vec::new();
    for (pose, metric) in poses.iter().flat_map(|pose| pose.metrics.metrics().map(move |metric| (pose, metric))) {
        if all.iter().any(|one| one.metric == metric) {
            continue;
        }
        let first = || pose.metrics.first_number(metric).map(str::to_owned);
        let declared = declared(metric).first().map(|statistic| statistic.name.to_owned());
        if let Some(statistic) = declared.or_else(first) {
            all.push(PrimaryStatistic { metric: metric.to_owned(), statistic });
        }
    }
    let reasons = poses.iter().filter_map(|pose| pose.verdict.as_ref()).flat_map(|verdict| &verdict.reasons);
    // A reason may be about no metric, such as a known result that cannot be read.
    for Reason { metric, statistic, .. } in reasons.filter(|reason| !declared(&reason.metric).is_empty()) {
        let exceeded = PrimaryStatistic { metric: metric.clone(), statistic: statistic.clone() };
        if !all.contains(&exceeded) {
            let after = all.iter().rposition(|one| one.metric == exceeded.metric).map_or(all.len(), |at| at + 1);
            all.insert(after, exceeded);
        }
    }
    all.sort_by_key(|one| one.metric != "point_error");
    all
}

/// For each metric its statistics over poses: `average`, `worst` (the value of largest size) and `nothing` (the average if the
/// target had stayed at rest).
pub fn over_poses(poses: &[PoseReport]) -> Map<String, Value> {
    let mut result = Map::new();
    for metric in poses.iter().flat_map(|pose| pose.metrics.metrics()) {
        if result.contains_key(metric) {
            continue;
        }
        let statistics = declared(metric);
        let measured: Vec<Map<String, Value>> = poses.iter().filter_map(|pose| pose.metrics.get(metric)).collect();
        let baseline: Vec<Map<String, Value>> =
            poses.iter().filter_map(|pose| pose.rest_baseline.get(metric)).collect();
        let summary = json!({
            "average": combine(&measured, &statistics, average),
            "worst": combine(&measured, &statistics, |_, values| largest(values)),
            "nothing": combine(&baseline, &statistics, average),
        });
        result.insert(metric.to_owned(), summary);
    }
    result
}

/// Combines each statistic of `poses` (mappings of statistics to values) by `how`, which also gets the declared aggregate.
///
/// Statistics that are not declared are averaged; lists are combined number by number.
fn combine(poses: &[Map<String, Value>], declared: &[Statistic], how: impl Fn(Aggregate, &[f64]) -> f64) -> Value {
    let mut result = Map::new();
    for name in poses.iter().flat_map(|values| values.keys()) {
        let statistic = declared.iter().find(|statistic| statistic.name == name);
        let aggregate = statistic.map(|statistic| statistic.aggregate).unwrap_or_default();
        if aggregate == Aggregate::None || result.contains_key(name) {
            continue;
        }
        let values: Vec<&Value> = poses.iter().filter_map(|pose| pose.get(name)).collect();
        let numbers: Vec<f64> = values.iter().filter_map(|value| value.as_f64()).collect();
        if values.iter().all(|value| value.is_u64() && *value == values[0]) {
            // A count that all poses share stays a whole number.
            result.insert(name.clone(), values[0].clone());
        } else if !numbers.is_empty() {
            result.insert(name.clone(), how(aggregate, &numbers).into());
        } else if let Some(curve) = combine_curves(&values, |numbers| how(aggregate, numbers)) {
            result.insert(name.clone(), curve);
        }
    }
    Value::Object(result)
}

/// Combines lists of equally many numbers, one number after the other; `None` if `curves` are no such lists.
fn combine_curves(curves: &[&Value], how: impl Fn(&[f64]) -> f64) -> Option<Value> {
    let numbers = |curve: &&Value| curve.as_array()?.iter().map(Value::as_f64).collect::<Option<Vec<f64>>>();
    let curves: Vec<Vec<f64>> = curves.iter().filter_map(numbers).collect();
    let length = curves.first()?.len();
    let at = |k: usize| how(&curves.iter().filter_map(|curve| curve.get(k).copied()).collect::<Vec<f64>>());
    Some((0..length).map(at).collect::<Vec<f64>>().into())
}

/// The average of values (not empty) by their aggregate.
fn average(aggregate: Aggregate, values: &[f64]) -> f64 {
    let count = values.len() as f64;
    match aggregate {
        Aggregate::RootMeanSquare => (values.iter().map(|value| value * value).sum::<f64>() / count).sqrt(),
        Aggregate::Mean | Aggregate::None => values.iter().sum::<f64>() / count,
    }
}

/// The value of largest size, with its sign.
fn largest(values: &[f64]) -> f64 {
    values.iter().copied().fold(0.0, |most: f64, value| if value.abs() > most.abs() { value } else { most })
}
