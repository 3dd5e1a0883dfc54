//! Checking metrics and gates.

use std::collections::BTreeMap;

use mimesh_core::{
    plugin,
    stage::{Marker, Metric, MetricContext, TransferPair},
};
use mimesh_document::{At, Step, path, suggest::did_you_mean};
use serde_json::Value;

use super::findings::{Findings, Scope};
use crate::{
    input::{GroundTruth, RestMesh},
    metrics::{self, Gate, Unknown, binding_error},
};

/// The metrics to measure with: the default ones and those that the pipeline names, which replace the default of their type; none
/// if it names an empty sequence.
pub(super) fn metrics(
    scope: Scope<'_>,
    found: &mut Findings,
    named: Option<Vec<Box<dyn Metric>>>,
    truth: &GroundTruth,
) -> Vec<Box<dyn Metric>> {
    let default = plugin::instances::<dyn Metric>().into_iter().map(|(_, metric)| metric);
    let default = default.filter(|metric| metric.by_default());
    let Some(mut named) = named else { return default.collect() };
    if named.is_empty() {
        return named;
    }
    let mut seen = Vec::new();
    for (at, metric) in entries(scope, &named) {
        let name = metric.typetag_name();
        if metric.needs_ground_truth() && lacks_truth(scope, truth) {
            let hint = "name the known results: `truth: truth/{pose}.obj`; or remove it";
            found.wrong(scope, &at, At::Value, format!("the metric `{name}` without `truth`"), hint);
        }
        if seen.contains(&name) {
            let hint = "put all its settings into one entry";
            found.wrong(scope, &at, At::Value, format!("the metric `{name}` a second time"), hint);
        }
        seen.push(name);
    }
    let names: Vec<&str> = named.iter().map(|metric| metric.typetag_name()).collect();
    let mut all: Vec<Box<dyn Metric>> = default.filter(|metric| !names.contains(&metric.typetag_name())).collect();
    all.append(&mut named);
    all
}

/// The entries of the document's `metrics` with their paths, each with the one of `metrics` that has its type; entries that could
/// not be read have none, and are left out.
fn entries<'m>(scope: Scope<'_>, metrics: &'m [Box<dyn Metric>]) -> Vec<(Vec<Step>, &'m dyn Metric)> {
    let entries = scope.document.value.get("metrics").and_then(Value::as_array).into_iter().flatten();
    let entry = |(i, settings): (usize, &Value)| {
        let metric = metrics.iter().find(|metric| settings["type"] == metric.typetag_name())?;
        Some((vec![Step::Key("metrics".into()), Step::Index(i)], metric.as_ref()))
    };
    entries.enumerate().filter_map(entry).collect()
}

/// Whether there are no known results, and none that have a diagnostic of their own.
fn lacks_truth(scope: Scope<'_>, truth: &GroundTruth) -> bool {
    let made = scope.document.value.get("target").is_some_and(|target| target.get("generator").is_some());
    truth.is_none() && scope.document.value.get("truth").is_none() && !made
}

/// Gates of a pipeline.
const MAX_GATES: usize = 1000;

/// The gates on what is measured.
pub(super) fn gates(
    scope: Scope<'_>,
    found: &mut Findings,
    declared: &BTreeMap<String, f64>,
    metrics: &[Box<dyn Metric>],
    truth: &GroundTruth,
) -> Vec<Gate> {
    if declared.len() > MAX_GATES {
        let message = format!("{} gates, expected {MAX_GATES} at most", declared.len());
        found.wrong(scope, &path(["gates"]), At::Value, message, "metrics have fewer statistics");
        return vec![];
    }
    let (gates, unknown) = metrics::gates(declared, metrics);
    for Unknown { key, known } in unknown {
        let hint = unknown_gate(&key, &known);
        found.wrong(scope, &path(["gates", &key]), At::Key, format!("unknown gate `{key}`"), hint);
    }
    for gate in &gates {
        let at = path(["gates", &gate.key]);
        let metric = metrics.iter().find(|metric| metric.typetag_name() == gate.metric);
        if !(gate.limit.is_finite() && gate.limit >= 0.0) {
            let message = format!("`{}`: expected a number of at least 0, found {}", gate.key, gate.limit);
            found.wrong(scope, &at, At::Value, message, "a statistic's absolute value may be no more than its gate");
        } else if metric.is_some_and(|metric| metric.needs_ground_truth()) && lacks_truth(scope, truth) {
            let hint = "name the known results: `truth: truth/{pose}.obj`; or remove the gate";
            found.wrong(scope, &at, At::Key, format!("the gate `{}` without `truth`", gate.key), hint);
        }
    }
    gates
}

/// The way out for a gate `key` that is none of `known`.
fn unknown_gate(key: &str, known: &[String]) -> String {
    const MAX_EXAMPLES: usize = 8;
    if let Some(suggestion) = did_you_mean(key, known) {
        return suggestion;
    }
    let unmeasured = plugin::instances::<dyn Metric>().into_iter().find(|(name, _)| key.starts_with(*name));
    match unmeasured {
        Some((name, _)) if known.iter().all(|known| known != name) => {
            format!("`{name}` is not measured; add `{{ type: {name} }}` to `metrics`")
        }
        _ => {
            let examples = known[..known.len().min(MAX_EXAMPLES)].join(", ");
            format!("gates are METRIC or METRIC_STATISTIC, e.g. {examples}")
        }
    }
}

/// Reports what the metrics that the pipeline names refuse of the meshes.
pub(super) fn check_bound(
    scope: Scope<'_>,
    found: &mut Findings,
    metrics: &[Box<dyn Metric>],
    source: &RestMesh,
    target: &RestMesh,
    markers: &[Marker],
) {
    let pair = TransferPair { source: &source.surface, target: target.seen_surface(), markers, proximity: None };
    let context =
        MetricContext { rest: &target.sequence.rest, surface: target.seen_surface(), pair: Some(pair), map: None };
    for (at, metric) in entries(scope, metrics) {
        if let Err(error) = metric.bind(context).map(drop)
            && !scope.is_reported(&error, &at)
        {
            let location = scope.document.location(&at, At::Value);
            found.diagnostics.push(binding_error(metric, error).at(location));
        }
    }
}
