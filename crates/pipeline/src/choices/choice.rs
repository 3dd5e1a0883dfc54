//! A choice with its reason, for reports and for people.

use serde::{Deserialize, Serialize};

use crate::text::pairs;

/// A choice that was made for the user.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct Choice {
    /// The slot, e.g. `correspondence`.
    pub stage: String,
    /// What was chosen: the type of a stage, or a few words.
    pub chosen: String,
    /// The reason, as a clause.
    pub why: String,
}

impl Choice {
    /// A choice with its reason.
    pub fn new(stage: impl Into<String>, chosen: impl Into<String>, why: impl Into<String>) -> Self {
        Self { stage: stage.into(), chosen: chosen.into(), why: why.into() }
    }

    /// The choice for people: `gradient: the target is one surface`.
    pub fn words(&self) -> String {
        format!("{}: {}", self.chosen, self.why)
    }
}

/// The choices for people, a line each.
pub fn rows(choices: &[Choice]) -> String {
    pairs(&choices.iter().map(|choice| (choice.stage.clone(), choice.words())).collect::<Vec<_>>())
}
