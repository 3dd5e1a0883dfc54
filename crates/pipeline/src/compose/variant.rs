//! The runs of a file, told apart.

use serde_json::Value;

/// The target and the values that distinguish a run from the others of its file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Variant {
    /// Target and values in one, fit for the name of a file, e.g. `camel-lambda=0.1,sampling=points`; empty if the file
    /// declares a single run without a name.
    pub name: String,
    /// The name of the target, if it is one of `targets`.
    pub target: Option<String>,
    /// The name of the combination, if there is a matrix.
    pub matrix: Option<String>,
    /// The keys that the matrix varies and their values in this run.
    pub values: Vec<(String, Value)>,
    /// The words for the values in names.
    pub shown: Vec<String>,
}

impl Variant {
    /// Whether the file declares the run by a target or a matrix.
    pub fn is_declared(&self) -> bool {
        self.target.is_some() || !self.values.is_empty()
    }
}
