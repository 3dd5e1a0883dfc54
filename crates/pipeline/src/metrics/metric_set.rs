//! The metrics of a run: bound to its meshes, measured on poses, and turned into verdicts by limits and gates.

use mimesh_core::{
    Error,
    stage::{BoundMetric, Metric, MetricContext, MetricInput, Statistic},
};
use mimesh_document::diagnostic::{Diagnostic, Result};
use mimesh_markers::IntoDiagnostic;

use super::{
    gates::Gate,
    pose_metrics::{PoseMeasurements, PoseMetrics},
    verdict::{Level, Reason, Verdict},
};

/// The metrics of a run and its gates.
pub struct MetricSet<'a> {
    members: Vec<Member<'a>>,
    gates: Vec<Gate>,
}

/// One metric of a set.
struct Member<'a> {
    name: String,
    needs_ground_truth: bool,
    is_of_rest: bool,
    statistics: Vec<Statistic>,
    /// `None` if its statistics are known from an earlier run.
    bound: Option<Box<dyn BoundMetric + 'a>>,
}

impl<'a> MetricSet<'a> {
    /// `metrics` bound to the meshes of `context`, without gates.
    ///
    /// # Errors
    ///
    /// The error of the metric that cannot be bound.
    pub fn bind(metrics: &[Box<dyn Metric>], context: MetricContext<'a>) -> Result<Self> {
        let mut set = Self::for_verdicts(metrics);
        for (member, metric) in set.members.iter_mut().zip(metrics) {
            member.bound = Some(metric.bind(context).map_err(|error| binding_error(metric.as_ref(), error))?);
        }
        Ok(set)
    }

    /// `metrics` that give verdicts on earlier measurements and measure nothing themselves.
    pub fn for_verdicts(metrics: &[Box<dyn Metric>]) -> Self {
        let members = metrics.iter().map(|metric| Member {
            name: metric.typetag_name().to_owned(),
            needs_ground_truth: metric.needs_ground_truth(),
            is_of_rest: metric.is_of_rest(),
            statistics: metric.statistics(),
            bound: None,
        });
        Self { members: members.collect(), gates: vec![] }
    }

    /// The same set with `gates`.
    pub fn with_gates(self, gates: &[Gate]) -> Self {
        Self { gates: gates.to_vec(), ..self }
    }

    /// Whether any metric may look at the source.
    pub fn needs_source(&self) -> bool {
        self.members.iter().any(|member| !member.needs_ground_truth)
    }

    /// The types of metrics that need a ground truth.
    pub fn names_with_ground_truth(&self) -> impl Iterator<Item = &str> {
        self.members.iter().filter(|member| member.needs_ground_truth).map(|member| member.name.as_str())
    }

    /// Measures a pose with all metrics; one that fails does not keep the others from measuring.
    pub fn measure(&self, input: MetricInput<'_>) -> PoseMeasurements {
        measure(self.members.iter(), input)
    }

    /// Measures a pose with the metrics that need a ground truth.
    pub fn measure_against_ground_truth(&self, input: MetricInput<'_>) -> PoseMeasurements {
        measure(self.members.iter().filter(|member| member.needs_ground_truth), input)
    }

    /// The largest size of a statistic of the pose over its bad limit: 1 where the pose becomes bad.
    pub fn limit_ratio(&self, metrics: &PoseMetrics) -> f64 {
        let mut largest = 0.0f64;
        for member in self.members.iter().filter(|member| !member.is_of_rest) {
            for Statistic { name, limits, .. } in &member.statistics {
                if let (Some(limits), Some(value)) = (limits, metrics.value(&member.name, name))
                    && limits.bad > 0.0
                {
                    largest = largest.max(value.abs() / limits.bad);
                }
            }
        }
        largest
    }

    /// The verdict on a pose, without the faults that all poses share; `None` if it was not measured.
    pub fn verdict(&self, metrics: &PoseMetrics) -> Option<Verdict> {
        self.verdict_by(metrics, |member| !member.is_of_rest)
    }

    /// The verdict on rest meshes, markers and map, from the measurements of any pose; `None` if they were not measured.
    pub fn rest_verdict(&self, metrics: &PoseMetrics) -> Option<Verdict> {
        self.verdict_by(metrics, |member| member.is_of_rest)
    }

    /// The verdict by some of the metrics; `None` if they have no statistics.
    fn verdict_by(&self, metrics: &PoseMetrics, judges: impl Fn(&Member<'_>) -> bool) -> Option<Verdict> {
        let members: Vec<&Member<'_>> = self.members.iter().filter(|member| judges(member)).collect();
        let is_judged = |metric: &str| members.iter().any(|member| member.name == metric);
        let gates: Vec<&Gate> = self.gates.iter().filter(|gate| is_judged(&gate.metric)).collect();
        let has_failed = |gate: &&Gate| metrics.failed.iter().any(|(metric, _)| *metric == gate.metric);
        let unmeasured: Vec<&Gate> = gates.iter().copied().filter(has_failed).collect();
        if !metrics.statistics.keys().any(|metric| is_judged(metric)) && unmeasured.is_empty() {
            return None;
        }
        let broken = gates.iter().filter_map(|gate| broken_gate(gate, metrics));
        let is_known = self.members.iter().any(|m| m.needs_ground_truth && metrics.statistics.contains_key(&m.name));
        let exceeded = members.iter().flat_map(|member| self.exceeded_limits(member, metrics, is_known));
        let mut reasons: Vec<Reason> =
            broken.chain(exceeded).chain(unmeasured.into_iter().map(Gate::unmeasured)).collect();
        reasons.sort_by(|a, b| b.level.cmp(&a.level).then(b.excess().total_cmp(&a.excess())));
        let level = reasons.first().map_or(Level::Good, |reason| reason.level);
        Some(Verdict { level, reasons })
    }

    /// The statistics of `member` above its own limits, except those that a gate of the pipeline is set for.
    ///
    /// Where the known result is measured (`is_known`), the suspicions of other metrics make nothing worse than doubtful.
    fn exceeded_limits(&self, member: &Member<'_>, metrics: &PoseMetrics, is_known: bool) -> Vec<Reason> {
        let may_be_bad = member.needs_ground_truth || !is_known;
        let has_gate = |name: &str| self.gates.iter().any(|gate| gate.metric == member.name && gate.statistic == name);
        let mut reasons = Vec::new();
        for Statistic { name, limits, .. } in &member.statistics {
            let Some(limits) = limits.filter(|_| !has_gate(name)) else { continue };
            let bad = above(Level::Bad, &member.name, name, limits.bad, metrics).filter(|_| may_be_bad);
            reasons.extend(bad.or_else(|| above(Level::Doubtful, &member.name, name, limits.doubtful, metrics)));
        }
        reasons
    }
}

/// The reason that `gate` gives if its statistic was measured and is above its limit.
fn broken_gate(gate: &Gate, metrics: &PoseMetrics) -> Option<Reason> {
    above(Level::Failed, &gate.metric, &gate.statistic, gate.limit, metrics)
}

/// The reason that a statistic gives if it was measured and its size is above `limit`.
fn above(level: Level, metric: &str, statistic: &str, limit: f64, metrics: &PoseMetrics) -> Option<Reason> {
    let value = metrics.value(metric, statistic).filter(|value| value.abs() > limit)?;
    let about = metrics.about(metric, statistic).map(str::to_owned);
    Some(Reason {
        level,
        metric: metric.into(),
        statistic: statistic.into(),
        about,
        value: Some(value),
        limit,
        note: None,
    })
}

fn measure<'m, 'a: 'm>(members: impl Iterator<Item = &'m Member<'a>>, input: MetricInput<'_>) -> PoseMeasurements {
    let mut measurements = PoseMeasurements::default();
    for member in members {
        let Some(bound) = &member.bound else { continue };
        match tracing::debug_span!("metric", "type" = &*member.name).in_scope(|| bound.measure(input)) {
            Ok(measured) if measured.statistics.values.is_empty() => {}
            Ok(measured) => measurements.measured.push((member.name.clone(), measured)),
            Err(error) => measurements.failed.push((member.name.clone(), error.to_string())),
        }
    }
    measurements
}

/// The error of a metric that cannot be bound, with its type.
pub fn binding_error(metric: &dyn Metric, error: Error) -> Diagnostic {
    error.into_diagnostic().doing(format!("metric ({})", metric.typetag_name()))
}
