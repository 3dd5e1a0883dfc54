//! The stages that are known, and those that Python adds.

use mimesh_core::{
    Plugin,
    plugin::{self, Alias},
};
use mimesh_pipeline::schema::{description, inlined_settings_schema};
use pyo3::prelude::*;
use serde_json::{Value, json};

use crate::error::{exception_of, misuse};

/// Types that calls of the package fill in, and nobody else.
const INTERNAL: [&str; 2] = ["in_memory", "python"];

/// Every stage that is known: its kind and type, its description, and schema and defaults of its settings, as JSON.
#[pyfunction]
pub fn registry() -> String {
    let public = plugin::all().into_iter().filter(|plugin| !INTERNAL.contains(&plugin.name()));
    Value::from(public.map(entry).collect::<Vec<_>>()).to_string()
}

fn entry(plugin: &Plugin) -> Value {
    json!({
        "kind": plugin.stage,
        "type": plugin.name(),
        "description": description(plugin),
        "schema": inlined_settings_schema(plugin),
        "defaults": plugin.settings(),
    })
}

/// Makes a stage that is written in Python known by its name.
#[pyfunction]
pub fn register_stage(py: Python<'_>, kind: &str, name: &str, schema: &str, defaults: &str) -> PyResult<()> {
    let read = |text: &str| serde_json::from_str::<Value>(text).map_err(|error| misuse(py, error.to_string(), ""));
    Alias::register(kind, name, "python", read(schema)?, read(defaults)?).map_err(|error| exception_of(py, error))
}
