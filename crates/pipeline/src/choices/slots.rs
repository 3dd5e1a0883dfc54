//! The slots that may be left to the program.

use mimesh_core::plugin::{StageKind, slot};
use mimesh_document::Document;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde_json::Value;

/// The word that leaves a slot to the program, as leaving it out does.
pub const AUTO: &str = "auto";

/// Which slots a pipeline leaves to the program.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Open {
    /// `markers`.
    pub markers: bool,
    /// `proximity`.
    pub proximity: bool,
    /// `correspondence`.
    pub correspondence: bool,
    /// `transfer`.
    pub transfer: bool,
}

impl Open {
    /// The slots that `document` leaves out or gives as `auto`, without those that a misspelt key was probably `meant` for.
    pub fn of(document: &Document, meant: &[&str]) -> Self {
        let open = |key: &str| !meant.contains(&key) && is_open(document.value.get(key));
        Self {
            markers: open("markers"),
            proximity: open("proximity"),
            correspondence: open("correspondence"),
            transfer: open("transfer"),
        }
    }
}

/// Whether a slot with this value is left to the program; `null` stands for none.
pub fn is_open(value: Option<&Value>) -> bool {
    value.is_none_or(|value| value.as_str() == Some(AUTO))
}

/// The schema of a slot that takes a stage, the word `auto`, or nothing.
pub fn stage_or_auto<S: StageKind + JsonSchema + ?Sized>(generator: &mut SchemaGenerator) -> Schema {
    let stage = slot::<S>(generator);
    json_schema!({ "anyOf": [
        stage,
        { "const": AUTO, "description": "Chosen by the meshes, as where it is left out." },
        { "type": "null" }
    ] })
}
