//! The choices that a pipeline leaves to the program: slots that are left out, or `auto`.
//!
//! They are made once the meshes are read, and before anything is computed. What was chosen stands in the typed pipeline as if the user
//! had named it, so that plans, keys and reports know no difference.

mod overlap;
mod slots;
mod stages;

use serde::{Deserialize, Serialize};

use crate::text::pairs;

pub use self::slots::{Open, is_open, stage_or_auto};
pub(crate) use self::stages::{choose_markers, choose_proximity, choose_stages, in_order};

/// The word that leaves a slot to the program, as leaving it out does.
pub const AUTO: &str = "auto";

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
