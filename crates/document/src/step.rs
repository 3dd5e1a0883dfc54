//! Paths through a document: keys of mappings and indices of sequences.

use std::fmt;

use serde_json::Value;

/// One step of a path through a document.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Step {
    /// Into a map.
    Key(String),
    /// Into a list, from 0.
    Index(usize),
}

/// A path of keys and list indices, from text: `["metrics", "0", "type"]`.
pub fn path<const N: usize>(keys: [&str; N]) -> Vec<Step> {
    keys.into_iter().map(Step::parse).collect()
}

impl Step {
    /// A step as text says it; digits are an index.
    pub fn parse(text: &str) -> Self {
        text.parse().map_or_else(|_| Self::Key(text.into()), Self::Index)
    }

    /// The value one step into `value`.
    pub fn get<'v>(&self, value: &'v Value) -> Option<&'v Value> {
        match self {
            Self::Key(key) => value.get(key),
            Self::Index(index) => value.get(index),
        }
    }

    /// The value one step into `value`, to change it.
    pub fn get_mut<'v>(&self, value: &'v mut Value) -> Option<&'v mut Value> {
        match self {
            Self::Key(key) => value.get_mut(key),
            Self::Index(index) => value.get_mut(index),
        }
    }
}

impl fmt::Display for Step {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Key(key) => f.write_str(key),
            Self::Index(index) => write!(f, "{index}"),
        }
    }
}
