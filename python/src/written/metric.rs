//! Metrics.

use std::sync::Arc;

use mimesh_core::{
    Error, Figures, Result, register,
    stage::{Aggregate, BoundMetric, Limits, Measured, Metric, MetricContext, MetricInput, Statistic},
};
use pyo3::{prelude::*, types::PyDict};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize, Serializer};
use serde_json::{Map, Value};

use super::call::{Written, lasting, positions, surface};

register!(Metric: PythonMetric);

/// A metric that is written in Python; its own name says which.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct PythonMetric {
    /// The name under which its class is registered.
    pub class: String,
    /// The settings of the class.
    pub settings: Map<String, Value>,
}

/// As pipelines have it, under its own name.
impl Serialize for PythonMetric {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        self.settings.serialize(serializer)
    }
}

impl PythonMetric {
    fn written(&self) -> Written<'_> {
        Written { kind: "metric", class: &self.class, settings: &self.settings }
    }
}

/// A statistic as Python says it: its name, unit, meaning, title, aggregate and limits.
type Said = (String, String, String, String, String, Option<(f64, f64)>);

impl PythonMetric {
    /// The statistics that the class declares. Their words live as long as the program, and few are different.
    fn declared(&self) -> Result<Vec<Statistic>> {
        let said: Vec<Said> = self
            .written()
            .call(|py, stage| py.import("mimesh._surface")?.getattr("statistics_of")?.call1((stage,))?.extract())?;
        let statistic = |(name, unit, meaning, title, aggregate, limits): Said| Statistic {
            name: lasting(name),
            title: lasting(title),
            unit: lasting(unit),
            aggregate: match aggregate.as_str() {
                "rms" => Aggregate::RootMeanSquare,
                "none" => Aggregate::None,
                _ => Aggregate::Mean,
            },
            limits: limits.map(|(doubtful, bad)| Limits { doubtful, bad }),
            meaning: lasting(meaning),
        };
        Ok(said.into_iter().map(statistic).collect())
    }

    fn is(&self, name: &str) -> bool {
        self.written().call(|_, stage| stage.getattr(name)?.extract::<bool>()).unwrap_or(false)
    }
}

#[typetag::deserialize(name = "python")]
impl Metric for PythonMetric {
    fn typetag_name(&self) -> &'static str {
        self.written().name()
    }

    fn bind<'a>(&self, context: MetricContext<'a>) -> Result<Box<dyn BoundMetric + 'a>> {
        self.declared()?;
        Ok(Box::new(BoundPython { stage: self.clone(), context, needs_ground_truth: self.needs_ground_truth() }))
    }

    fn statistics(&self) -> Vec<Statistic> {
        // What is wrong with them is the error of binding.
        self.declared().unwrap_or_default()
    }

    fn needs_ground_truth(&self) -> bool {
        self.is("needs_ground_truth")
    }
}

struct BoundPython<'a> {
    stage: PythonMetric,
    context: MetricContext<'a>,
    needs_ground_truth: bool,
}

impl BoundMetric for BoundPython<'_> {
    fn measure(&self, input: MetricInput<'_>) -> Result<Measured> {
        self.context.check(&input)?;
        if self.needs_ground_truth && input.ground_truth.is_none() {
            return Ok(Measured::default());
        }
        let of = Arc::new(self.context.surface.clone());
        let values: Vec<(String, f64)> = self.stage.written().call(|py, stage| {
            let known = PyDict::new(py);
            if let Some(truth) = input.ground_truth {
                known.set_item("truth", positions(py, truth.surface)?)?;
            }
            let helper = py.import("mimesh._surface")?.getattr("measure")?;
            let posed = positions(py, input.result.surface)?;
            helper.call((stage, surface(py, &of)?, posed), Some(&known))?.extract()
        })?;
        let declared = self.stage.statistics();
        let mut statistics = Figures::default();
        for (name, value) in values {
            if !value.is_finite() || !declared.iter().any(|statistic| statistic.name == name) {
                let message = format!("metric `{}` gave `{name}` as {value}", self.stage.class);
                return Err(Error::data(message, "give finite numbers, each under a name of `statistics`"));
            }
            statistics.set(&name, value);
        }
        Ok(Measured { statistics, ..Measured::default() })
    }
}
