//! Judging poses: all metrics of a pipeline bound to its meshes, and verdicts from their limits and from gates.

use nalgebra::Point3;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::gates::Gate;
use crate::{
    core::{
        self, Error,
        mesh::{Mesh, Surface},
        plugin,
        stage::{BoundMetric, Limit, Measured, Metric, MetricContext, MetricInput},
    },
    diagnostic::{Diagnostic, Result},
    text::number,
};

/// The metrics of a run, ready to measure poses.
pub struct Judges<'a> {
    judges: Vec<Judge<'a>>,
    gates: Vec<Gate>,
}

struct Judge<'a> {
    name: String,
    needs_truth: bool,
    limits: Vec<Limit>,
    /// `None` if what it says is known already.
    bound: Option<Box<dyn BoundMetric + 'a>>,
}

/// What a figure can be.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Level {
    /// Nothing to see.
    #[default]
    Good,
    /// Worth a look.
    Doubtful,
    /// Something is wrong.
    Bad,
    /// A gate of the pipeline says no.
    #[serde(rename = "broken_gate")]
    Failed,
}

/// What is to be said of a pose.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
pub struct Verdict {
    /// The worst of its reasons.
    pub level: Level,
    /// Why it is not good, worst first.
    #[serde(default)]
    pub reasons: Vec<Reason>,
}

/// A figure above its limit.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Reason {
    /// How bad that is.
    pub level: Level,
    /// Type of the metric.
    pub metric: String,
    /// Its figure.
    pub figure: String,
    /// What it is about, where that is one among many, e.g. `marker 28`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub about: Option<String>,
    /// What was found; none if it could not be measured, which breaks a gate too.
    pub value: Option<f64>,
    /// What would pass.
    pub limit: f64,
}

impl Level {
    /// In a word or two.
    pub fn word(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Doubtful => "doubtful",
            Self::Bad => "bad",
            Self::Failed => "broken gate",
        }
    }
}

impl Reason {
    /// In words: `edge stretch p99 85.1, above 60`.
    pub fn words(&self) -> String {
        let what = format!("{} {}", self.metric, self.figure).replace('_', " ");
        let Some(value) = self.value else { return format!("{what} could not be measured") };
        let about = self.about.as_ref().map(|about| format!(" at {about}")).unwrap_or_default();
        format!("{what} {}{about}, above {}", number(value), number(self.limit))
    }

    /// How many times the limit was found; at least 1, and infinite where nothing was to be.
    pub fn excess(&self) -> f64 {
        match self.value {
            Some(value) if self.limit > 0.0 => value.abs() / self.limit,
            _ => f64::INFINITY,
        }
    }
}

/// What all metrics say of a pose.
#[derive(Debug, Default)]
pub struct Judgement {
    /// By type of metric; those that say nothing are left out.
    pub measured: Vec<(String, Measured)>,
    /// Metrics that failed, and why.
    pub failed: Vec<(String, String)>,
}

/// What is left of a judgement when pictures are taken: all that a report says of a pose, and all that verdicts are made of.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct Said {
    /// The figures by type of metric.
    pub figures: Map<String, Value>,
    /// What single figures are about: metric, figure, words.
    pub about: Vec<(String, String, String)>,
    /// Metrics that failed, and why; while a verdict is made, also those that want a truth that could not be read.
    pub failed: Vec<(String, String)>,
    /// The figures against the truth for the target at rest in place of the result.
    pub nothing: Map<String, Value>,
}

impl Judgement {
    /// The figures by type of metric.
    pub fn figures(&self) -> Map<String, Value> {
        let value = |measured: &Measured| serde_json::to_value(&measured.figures).unwrap_or_default();
        self.measured.iter().map(|(name, measured)| (name.clone(), value(measured))).collect()
    }

    /// Without what is for pictures only.
    pub fn said(&self) -> Said {
        let of = |(metric, measured): &(String, Measured)| {
            let about = measured.about.iter();
            about.map(|(figure, words)| (metric.clone(), (*figure).to_owned(), words.clone())).collect::<Vec<_>>()
        };
        let about = self.measured.iter().flat_map(of).collect();
        Said { figures: self.figures(), about, failed: self.failed.clone(), nothing: Map::new() }
    }
}

impl Said {
    fn about(&self, metric: &str, figure: &str) -> Option<String> {
        self.about.iter().find(|(of, name, _)| of == metric && name == figure).map(|(_, _, words)| words.clone())
    }

    fn number(&self, metric: &str, figure: &str) -> Option<f64> {
        self.figures.get(metric)?.get(figure)?.as_f64()
    }
}

impl<'a> Judges<'a> {
    /// Metrics bound to what they are to judge, without gates.
    ///
    /// # Errors
    ///
    /// Of the metric.
    pub fn bind(metrics: &[Box<dyn Metric>], subject: MetricContext<'a>) -> Result<Self> {
        let mut judges = Self::of_limits(metrics);
        for (judge, metric) in judges.judges.iter_mut().zip(metrics) {
            judge.bound = Some(metric.bind(subject).map_err(|error| of_metric(metric.as_ref(), error))?);
        }
        Ok(judges)
    }

    /// Those that only give verdicts on what has been measured before.
    pub fn of_limits(metrics: &[Box<dyn Metric>]) -> Self {
        let judge = |metric: &dyn Metric| Judge {
            name: metric.typetag_name().to_owned(),
            needs_truth: metric.needs_truth(),
            limits: metric.limits(),
            bound: None,
        };
        Self { judges: metrics.iter().map(|metric| judge(metric.as_ref())).collect(), gates: vec![] }
    }

    /// The same with gates.
    pub fn with_gates(self, gates: &[Gate]) -> Self {
        Self { gates: gates.to_vec(), ..self }
    }

    /// Whether any looks at what the source did.
    pub fn want_source(&self) -> bool {
        self.judges.iter().any(|judge| !judge.needs_truth)
    }

    /// What all say of `pose`; one that fails does not keep the others from speaking.
    pub fn measure(&self, pose: MetricInput<'_>) -> Judgement {
        self.ask(pose, |_| true)
    }

    /// What those say that measure against the known result.
    pub fn against_truth(&self, pose: MetricInput<'_>) -> Judgement {
        self.ask(pose, |judge| judge.needs_truth)
    }

    /// The metrics that want the known result.
    pub fn of_truth(&self) -> impl Iterator<Item = &str> {
        self.judges.iter().filter(|judge| judge.needs_truth).map(|judge| judge.name.as_str())
    }

    fn ask(&self, pose: MetricInput<'_>, who: impl Fn(&Judge<'_>) -> bool) -> Judgement {
        let mut judgement = Judgement::default();
        for judge in self.judges.iter().filter(|judge| who(judge)) {
            let Some(bound) = &judge.bound else { continue };
            match bound.measure(pose) {
                Ok(one) if one.figures.values.is_empty() => {}
                Ok(one) => judgement.measured.push((judge.name.clone(), one)),
                Err(error) => judgement.failed.push((judge.name.clone(), error.to_string())),
            }
        }
        judgement
    }

    /// How near the worst figure comes to being bad: 1 where it is.
    pub fn strain(&self, said: &Said) -> f64 {
        let of = |judge: &Judge<'_>, limit: &Limit| {
            let found = said.number(&judge.name, limit.figure)?.abs();
            (limit.bad > 0.0).then_some(found / limit.bad)
        };
        let all = self.judges.iter().flat_map(|judge| judge.limits.iter().filter_map(move |limit| of(judge, limit)));
        all.fold(0.0, f64::max)
    }

    /// What is to be said of a pose; `None` if nothing was measured.
    pub fn verdict(&self, said: &Said) -> Option<Verdict> {
        let fails = |gate: &&Gate| said.failed.iter().any(|(metric, _)| *metric == gate.metric);
        let unmeasured: Vec<&Gate> = self.gates.iter().filter(fails).collect();
        if said.figures.is_empty() && unmeasured.is_empty() {
            return None;
        }
        let mut reasons = Vec::new();
        let mut above = |level, metric: &str, figure: &str, limit: f64| {
            let Some(value) = said.number(metric, figure).filter(|value| value.abs() > limit) else { return };
            let about = said.about(metric, figure);
            let value = Some(value);
            reasons.push(Reason { level, metric: metric.into(), figure: figure.into(), about, value, limit });
        };
        let gated = |metric: &str, figure: &str| self.gates.iter().any(|g| g.metric == metric && g.figure == figure);
        for gate in &self.gates {
            above(Level::Failed, &gate.metric, &gate.figure, gate.limit);
        }
        for judge in &self.judges {
            // What a pipeline says of a figure goes before what the metric says.
            for limit in judge.limits.iter().filter(|limit| !gated(&judge.name, limit.figure)) {
                let found = said.number(&judge.name, limit.figure).unwrap_or(0.0).abs();
                if found > limit.bad {
                    above(Level::Bad, &judge.name, limit.figure, limit.bad);
                } else {
                    above(Level::Doubtful, &judge.name, limit.figure, limit.doubtful);
                }
            }
        }
        reasons.extend(unmeasured.into_iter().map(Gate::unmeasured));
        reasons.sort_by(|a, b| b.level.cmp(&a.level).then(b.excess().total_cmp(&a.excess())));
        let level = reasons.first().map_or(Level::Good, |reason| reason.level);
        Some(Verdict { level, reasons })
    }
}

/// How far each vertex of `result` is from `truth`, both poses of `rest`.
///
/// # Errors
///
/// Of the metric `point_error`, and that it is not linked into this program.
pub fn point_error(
    rest: &Mesh,
    surface: &Surface,
    result: &[Point3<f64>],
    truth: &[Point3<f64>],
) -> core::Result<Measured> {
    let Some(metric) = plugin::instance::<dyn Metric>("point_error") else {
        let hint = "link the crate mimesh-metrics, or build with the feature `bundled`";
        return Err(Error::data("the metric point_error is not linked into this program", hint));
    };
    metric.bind(MetricContext::alone(rest, surface))?.measure(MetricInput::against(result, truth))
}

/// An error of a metric that is bound, with its name.
pub fn of_metric(metric: &dyn Metric, error: Error) -> Diagnostic {
    Diagnostic::from(error).doing(format!("metric ({})", metric.typetag_name()))
}
