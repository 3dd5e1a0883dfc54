//! Where the markers of a pipeline come from.

use std::borrow::Cow;

use mimesh_core::stage::Landmarks;
use mimesh_markers::MarkerFiles;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Serialize;
use serde_json::{Value, json};

/// Files of markers, or the stage that proposes them.
#[derive(Debug, Serialize)]
#[serde(untagged)]
pub enum MarkerSource {
    /// The user's files.
    Files(MarkerFiles),
    /// A stage, which runs once.
    Stage(Box<dyn Landmarks>),
}

impl MarkerSource {
    /// The files, if there are any.
    pub fn files(&self) -> Option<&MarkerFiles> {
        match self {
            Self::Files(files) => Some(files),
            Self::Stage(_) => None,
        }
    }

    /// The stage, if there is one.
    pub fn stage(&self) -> Option<&dyn Landmarks> {
        match self {
            Self::Files(_) => None,
            Self::Stage(stage) => Some(stage.as_ref()),
        }
    }
}

impl JsonSchema for MarkerSource {
    fn schema_name() -> Cow<'static, str> {
        "MarkerSource".into()
    }

    fn inline_schema() -> bool {
        true
    }

    /// The slot of a stage, in which files may stand too.
    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let slot = <dyn Landmarks>::json_schema(generator).to_value();
        let of_definition = || generator.definitions().get("Landmarks").and_then(|all| all.get("oneOf")).cloned();
        let stages = slot.get("oneOf").cloned().or_else(of_definition).unwrap_or_else(|| json!([]));
        let files = MarkerFiles::json_schema(generator).to_value()["oneOf"].take();
        let all: Vec<Value> =
            [files, stages].into_iter().filter_map(|list| list.as_array().cloned()).flatten().collect();
        json_schema!({ "x-stage": "landmarks", "oneOf": all })
    }
}
