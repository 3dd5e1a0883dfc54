//! Colour maps that metrics give.

use mimesh_core::stage::{Metric, MetricContext, MetricInput, TransferPair};
use mimesh_pipeline::Prepared;
use serde::Serialize;

/// The colour map of how sure pairs are; no metric has this name.
pub const CONFIDENCE: &str = "pair_confidence";

/// Its name and unit.
pub const CONFIDENCE_WORDS: &str = "confidence, %";

/// A colour map.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ScalarView {
    /// The type of the metric that gives it.
    pub name: String,
    /// What it shows, for people.
    pub title: String,
    /// The unit of its numbers.
    pub unit: String,
    /// Whether it needs the known result.
    pub needs_truth: bool,
}

impl ScalarView {
    /// The colour map of confidence, and those that the metrics of `prepared` give: with a number for each vertex of the target.
    pub fn all(prepared: &Prepared) -> Vec<Self> {
        let target = &prepared.target;
        let pair = TransferPair {
            source: &prepared.source.surface,
            target: &target.surface,
            markers: prepared.markers(),
            proximity: prepared.proximity.as_ref().map(|proximity| &proximity.graph),
        };
        let context =
            MetricContext { rest: &target.sequence.rest, surface: &target.surface, pair: Some(pair), map: None };
        let of_metrics =
            prepared.metrics.iter().filter_map(|metric| Self::of(metric.as_ref(), context, !prepared.truth.is_none()));
        of_metrics.chain([Self::new(CONFIDENCE, CONFIDENCE_WORDS, false)]).collect()
    }

    fn of(metric: &dyn Metric, context: MetricContext<'_>, has_truth: bool) -> Option<Self> {
        let needs_truth = metric.needs_ground_truth();
        if needs_truth && !has_truth || metric.is_of_rest() || metric.needs_map() {
            return None;
        }
        let rest = context.at_rest();
        let input = MetricInput {
            ground_truth: needs_truth.then_some(rest),
            source: context.pair.map(|pair| &pair.source.positions[..]),
            ..MetricInput::alone(rest)
        };
        let measured = metric.bind(context).ok()?.measure(input).ok()?;
        if measured.field.is_empty() {
            return None;
        }
        Some(Self::new(metric.typetag_name(), measured.field_unit, needs_truth))
    }

    /// The colour map `name`, whose numbers `words` describe.
    pub fn new(name: &str, words: &str, needs_truth: bool) -> Self {
        Self { name: name.into(), title: title(name), unit: unit(words).into(), needs_truth }
    }
}

/// The name of a colour map, for people.
pub fn title(name: &str) -> String {
    name.replace('_', " ")
}

/// The unit at the end of the words for a field, as in `stretch, %`.
pub fn unit(words: &str) -> &str {
    words.rsplit_once(", ").map_or("", |(_, unit)| unit)
}
