//! What a program knows of the values in its documents.

use serde_json::Value;

use crate::step::Step;

/// What a program knows of the values that may stand in its documents, by their paths.
///
/// Messages and overrides ask it; `root` is the value of the whole document.
pub trait Shapes {
    /// The settings, told apart by `type`, that may stand at `path`; `None` if something else belongs there.
    fn variants(&self, root: &Value, path: &[Step]) -> Option<Variants>;

    /// The words that the value at `path` may be; empty if it is not one of several words.
    fn choices(&self, root: &Value, path: &[Step]) -> Vec<String>;

    /// The `type` of the settings at `path` where the document leaves them out.
    fn default_type(&self, root: &Value, path: &[Step]) -> Option<String>;

    /// The present name of `key`, which used to be a key of the mapping at `path`.
    fn renamed(&self, root: &Value, path: &[Step], key: &str) -> Option<String>;
}

/// Settings that are told apart by `type`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Variants {
    /// What all of them are, e.g. `transfer`.
    pub kind: String,
    /// The types that there are.
    pub types: Vec<String>,
}

/// Knowledge of no value: for documents without settings that are told apart by `type`.
#[derive(Clone, Copy, Debug)]
pub struct NoShapes;

impl Shapes for NoShapes {
    fn variants(&self, _: &Value, _: &[Step]) -> Option<Variants> {
        None
    }

    fn choices(&self, _: &Value, _: &[Step]) -> Vec<String> {
        vec![]
    }

    fn default_type(&self, _: &Value, _: &[Step]) -> Option<String> {
        None
    }

    fn renamed(&self, _: &Value, _: &[Step], _: &str) -> Option<String> {
        None
    }
}
