//! The schema of one stage's settings.

use mimesh_core::Plugin;
use schemars::{SchemaGenerator, generate::SchemaSettings};
use serde_json::Value;

/// The JSON Schema of a stage's settings, with what it refers to under `$defs`.
pub fn settings_schema(plugin: &Plugin) -> Value {
    let mut generator = SchemaSettings::draft2020_12().into_generator();
    let mut schema = plugin.schema(&mut generator);
    let definitions = generator.take_definitions(true);
    if !definitions.is_empty() {
        schema.insert("$defs".into(), Value::Object(definitions));
    }
    schema.to_value()
}

/// The JSON Schema of a stage's settings, without references where that is possible.
pub fn inlined_settings_schema(plugin: &Plugin) -> Value {
    let settings = SchemaSettings::draft2020_12().with(|settings| settings.inline_subschemas = true);
    plugin.schema(&mut settings.into_generator()).to_value()
}

/// The description of a stage, its doc comment.
pub fn description(plugin: &Plugin) -> String {
    let schema = plugin.schema(&mut SchemaGenerator::default());
    schema.get("description").and_then(Value::as_str).unwrap_or_default().to_owned()
}
