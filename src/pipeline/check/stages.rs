use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

use super::{Check, Side, Truth};
use crate::{
    core::{
        plugin,
        stage::{Marker, Metric, MetricContext, TransferPair},
    },
    diagnostic::Diagnostic,
    diagnostic::Kind,
    pipeline::{
        At, Pipeline, Step,
        document::path,
        gates::{self, Gate, Unknown},
        judge,
        words::did_you_mean,
    },
};

impl Check<'_> {
    /// What the stages themselves have to say, and the files among their settings.
    pub(super) fn stages(
        &mut self,
        pipeline: &mut Pipeline,
        source: Option<&Side>,
        target: Option<&Side>,
        markers: Option<&[Marker]>,
    ) {
        if let Some(correspondence) = &mut pipeline.correspondence {
            self.stage_files("correspondence", correspondence.files());
            let needed = correspondence.markers_needed();
            if let Some(markers) = markers.filter(|markers| markers.len() < needed) {
                let has = match markers.len() {
                    0 => "there are none".into(),
                    count => format!("there are {count}"),
                };
                let message = format!("{} needs at least {needed} markers, {has}", correspondence.typetag_name());
                let hint = "a marker is a point of the source and the same point of the target: \
                            `markers: pairs.cons` (a count, then `source, target` vertices from 0)";
                let at = if pipeline.markers.is_some() { path(["markers"]) } else { path(["correspondence"]) };
                self.wrong(&at, At::Value, message, hint);
                return;
            }
        }
        let (Some(source), Some(target), Some(markers)) = (source, target, markers) else { return };
        let graph = match pipeline.proximity.as_ref().map(|proximity| proximity.proximity(&target.surface)) {
            Some(Err(error)) => {
                let name = pipeline.proximity.as_ref().map_or("", |proximity| proximity.typetag_name());
                return self.refused("proximity", name, error);
            }
            Some(Ok(graph)) => Some(graph),
            None => None,
        };
        let pair =
            TransferPair { source: &source.surface, target: &target.surface, markers, proximity: graph.as_ref() };
        if let Some(correspondence) = &pipeline.correspondence
            && let Err(error) = correspondence.check(pair)
        {
            self.refused("correspondence", correspondence.typetag_name(), error);
        }
        if let Some(transfer) = &pipeline.transfer
            && let Err(error) = transfer.check(pair)
        {
            self.refused("transfer", transfer.typetag_name(), error);
        }
    }

    /// What is measured: what is usual and what the pipeline names, which goes before the usual of its type; nothing if it names
    /// an empty list.
    pub(super) fn metrics(&mut self, given: Option<Vec<Box<dyn Metric>>>, truth: &Truth) -> Vec<Box<dyn Metric>> {
        let usual = plugin::instances::<dyn Metric>().into_iter().map(|(_, metric)| metric);
        let usual = usual.filter(|metric| metric.by_default());
        let Some(mut metrics) = given else { return usual.collect() };
        if metrics.is_empty() {
            return metrics;
        }
        let first = metrics.iter().position(|metric| metric.needs_truth());
        if let Some(i) = first.filter(|_| self.knows_no(truth)) {
            let hint = "say where the known results are: `truth: truth/{pose}.obj`; or remove it";
            let message = format!("the metric `{}` without `truth`", metrics[i].typetag_name());
            self.wrong(&path(["metrics", &i.to_string()]), At::Value, message, hint);
        }
        for i in 1..metrics.len() {
            if metrics[..i].iter().any(|other| other.typetag_name() == metrics[i].typetag_name()) {
                let message = format!("the metric `{}` a second time", metrics[i].typetag_name());
                self.wrong(
                    &path(["metrics", &i.to_string()]),
                    At::Value,
                    message,
                    "put all its settings into one entry",
                );
            }
        }
        let named: Vec<&str> = metrics.iter().map(|metric| metric.typetag_name()).collect();
        let mut all: Vec<Box<dyn Metric>> = usual.filter(|metric| !named.contains(&metric.typetag_name())).collect();
        all.append(&mut metrics);
        all
    }

    fn knows_no(&self, truth: &Truth) -> bool {
        let generator = self.document.value.get("target").is_some_and(|target| target.get("generator").is_some());
        matches!(truth, Truth::None) && self.document.value.get("truth").is_none() && !generator
    }

    /// The gates, of what is measured.
    pub(super) fn gates(
        &mut self,
        given: &BTreeMap<String, f64>,
        metrics: &[Box<dyn Metric>],
        truth: &Truth,
    ) -> Vec<Gate> {
        let (gates, unknown) = gates::gates(given, metrics);
        for Unknown { key, known } in unknown {
            let at = path(["gates", &key]);
            let elsewhere = plugin::instances::<dyn Metric>().into_iter().find(|(name, _)| key.starts_with(*name));
            let known: Vec<_> = known.iter().map(String::as_str).collect();
            let hint = match (did_you_mean(&key, &known), elsewhere) {
                (Some(meant), _) => meant,
                (None, Some((name, _))) if !known.contains(&name) => {
                    format!("`{name}` is not measured; add `{{ type: {name} }}` to `metrics`")
                }
                (None, _) => {
                    format!("gates are METRIC or METRIC_FIGURE, e.g. {}", known[..known.len().min(8)].join(", "))
                }
            };
            self.wrong(&at, At::Key, format!("unknown gate `{key}`"), hint);
        }
        for gate in &gates {
            let at = path(["gates", &gate.key]);
            let metric = metrics.iter().find(|metric| metric.typetag_name() == gate.metric);
            if !(gate.limit.is_finite() && gate.limit >= 0.0) {
                let message = format!("`{}`: expected a number of at least 0, found {}", gate.key, gate.limit);
                self.wrong(&at, At::Value, message, "the size of a figure may be no more than its gate");
            } else if metric.is_some_and(|metric| metric.needs_truth()) && self.knows_no(truth) {
                let hint = "say where the known results are: `truth: truth/{pose}.obj`; or remove the gate";
                self.wrong(&at, At::Key, format!("the gate `{}` without `truth`", gate.key), hint);
            }
        }
        gates
    }

    /// What the metrics that the pipeline names have to say of the meshes.
    pub(super) fn bound_metrics(
        &mut self,
        metrics: &[Box<dyn Metric>],
        source: &Side,
        target: &Side,
        markers: &[Marker],
    ) {
        let pair = TransferPair { source: &source.surface, target: &target.surface, markers, proximity: None };
        let subject =
            MetricContext { rest: &target.sequence.rest, surface: &target.surface, pair: Some(pair), map: None };
        let named = self.document.value.get("metrics").and_then(|list| list.as_array()).cloned().unwrap_or_default();
        for metric in metrics {
            let is_it = |settings: &serde_json::Value| settings["type"] == metric.typetag_name();
            let Some(i) = named.iter().position(is_it) else { continue };
            if let Err(error) = metric.bind(subject).map(drop)
                && !self.has_told(&error)
            {
                let at = self.document.location(&path(["metrics", &i.to_string()]), At::Value);
                self.diagnostics.push(judge::of_metric(metric.as_ref(), error).at(at));
            }
        }
    }

    fn refused(&mut self, stage: &'static str, name: &str, error: crate::core::Error) {
        if self.has_told(&error) {
            return;
        }
        let at = self.document.location(&path([stage]), At::Value);
        let diagnostic = Diagnostic::from(error).doing(format!("{stage} ({name})"));
        let status = if diagnostic.kind == Kind::Internal { Kind::BadData } else { diagnostic.kind };
        self.diagnostics.push(Diagnostic { kind: status, ..diagnostic.at(at) });
    }

    fn stage_files(&mut self, stage: &'static str, files: Vec<&mut PathBuf>) {
        for file in files {
            let settings = self.document.value.get(stage).and_then(|settings| settings.as_object());
            let said = settings.into_iter().flatten().find(|(_, value)| value.as_str().map(Path::new) == Some(file));
            let at: Vec<_> = path([stage]).into_iter().chain(said.map(|(key, _)| Step::Key(key.clone()))).collect();
            let before = self.diagnostics.len();
            self.empty_texts(&at);
            *file = self.path(&at, file);
            if self.diagnostics.len() == before {
                self.input(stage, file, &at);
            }
        }
    }
}
