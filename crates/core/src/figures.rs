//! Numbers that a stage reports about its work.

use serde::{Deserialize, Serialize};
use serde_json::Value;

/// The report of a stage about its result: named figures in a fixed order, and warnings for a person.
///
/// They go to the summary of a run and to `run.json`. Only a warning of landmarks counts beyond that: it makes the run doubtful.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Figures {
    /// Names in `snake_case` with a unit where there is one, and values.
    #[serde(flatten)]
    pub values: serde_json::Map<String, Value>,
    /// Sentences about what was skipped or looks wrong, each with a way out.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
}

impl Figures {
    /// Adds a figure; a second one of the same name replaces the first.
    pub fn set(&mut self, name: &str, value: impl Into<Value>) {
        self.values.insert(name.into(), value.into());
    }

    /// Adds a warning.
    pub fn warn(&mut self, message: impl Into<String>) {
        self.warnings.push(message.into());
    }

    /// The figure `name` as a number, if it is one.
    pub fn number(&self, name: &str) -> Option<f64> {
        self.values.get(name).and_then(Value::as_f64)
    }
}
