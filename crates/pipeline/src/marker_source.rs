//! Where the markers of a pipeline come from.

use std::borrow::Cow;

use mimesh_core::stage::Landmarks;
use mimesh_markers::MarkerFiles;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Serialize, Serializer};
use serde_json::{Value, json};

use crate::json::to_value;

/// The key beside the settings of a stage that names the user's own markers.
pub const CLICKS: &str = "clicks";

/// Files of markers, or the stage that proposes them.
#[derive(Debug, Serialize)]
#[serde(untagged)]
pub enum MarkerSource {
    /// The user's files.
    Files(MarkerFiles),
    /// A stage, which runs once.
    Stage(ProposedMarkers),
}

/// A stage that proposes markers, beside those that the user has clicked.
#[derive(Debug)]
pub struct ProposedMarkers {
    /// The stage.
    pub stage: Box<dyn Landmarks>,
    /// The user's files.
    pub clicks: Option<MarkerFiles>,
}

impl MarkerSource {
    /// The files, if these are all.
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
            Self::Stage(proposed) => Some(proposed.stage.as_ref()),
        }
    }

    /// The files of clicks beside a stage.
    pub fn clicks(&self) -> Option<&MarkerFiles> {
        match self {
            Self::Files(_) => None,
            Self::Stage(proposed) => proposed.clicks.as_ref(),
        }
    }
}

impl From<Box<dyn Landmarks>> for MarkerSource {
    fn from(stage: Box<dyn Landmarks>) -> Self {
        Self::Stage(ProposedMarkers { stage, clicks: None })
    }
}

impl Serialize for ProposedMarkers {
    /// The settings of the stage, with the clicks among them.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut value = to_value(&self.stage);
        if let Some(clicks) = &self.clicks {
            value[CLICKS] = to_value(clicks);
        }
        value.serialize(serializer)
    }
}

impl JsonSchema for MarkerSource {
    fn schema_name() -> Cow<'static, str> {
        "MarkerSource".into()
    }

    fn inline_schema() -> bool {
        true
    }

    /// The slot of a stage with a key more, in which files may stand too.
    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let slot = <dyn Landmarks>::json_schema(generator).to_value();
        let of_definition = || generator.definitions().get("Landmarks").and_then(|all| all.get("oneOf")).cloned();
        let stages = slot.get("oneOf").cloned().or_else(of_definition).unwrap_or_else(|| json!([]));
        let files = MarkerFiles::json_schema(generator).to_value()["oneOf"].take();
        let clicks = json!({ "description": "Markers that the user has clicked: a file, or one for each mesh.", "oneOf": files });
        let with_clicks = |mut stage: Value| {
            if let Some(properties) = stage.get_mut("properties").and_then(Value::as_object_mut) {
                properties.insert(CLICKS.into(), clicks.clone());
            }
            stage
        };
        let stages = stages.as_array().cloned().unwrap_or_default().into_iter().map(with_clicks);
        let all: Vec<Value> = files.as_array().cloned().unwrap_or_default().into_iter().chain(stages).collect();
        json_schema!({ "x-stage": "landmarks", "oneOf": all })
    }
}
