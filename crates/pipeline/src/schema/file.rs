//! The JSON Schema of a pipeline's file, for editors: the pipeline with the keys that make several runs of one file.

use std::collections::BTreeMap;

use schemars::{JsonSchema, generate::SchemaSettings};
use serde_json::{Map, Value, json};

use super::SchemaNode;
use crate::{
    one_or_many::OneOrMany,
    spec::{Pipeline, Target},
};

/// The keys that make several runs of one file, or one file of several; the others are those of a single run.
pub const COMPOSITION_KEYS: [&str; 4] = ["include", "variables", "targets", "matrix"];

/// Whether `key` belongs to the file as a whole: it cannot differ from run to run, as variables can.
pub fn is_of_whole_file(key: &str) -> bool {
    key != "variables" && COMPOSITION_KEYS.contains(&key)
}

/// The values of [`COMPOSITION_KEYS`].
#[derive(Debug, Default, JsonSchema)]
#[allow(dead_code, reason = "the schema is made of it; values are read with their places")]
pub struct Composition {
    /// Files that this one is merged over: a path or a sequence of paths, relative to this file.
    ///
    /// Mappings are merged key by key, and this file's own values win. Sequences are replaced, and so is a stage by one of another
    /// `type`.
    #[schemars(extend("examples" = ["base.yaml"]))]
    include: Option<OneOrMany>,
    /// Values by name, used as `${name}` in texts, or as a whole value of any type. `${env:NAME}` is a variable of the
    /// environment.
    #[schemars(extend("examples" = [{ "data": "../data", "lambda": 0.5 }]))]
    variables: Option<BTreeMap<String, Value>>,
    /// Several meshes that take the motion, by name, in place of `target`: each `rest` or `generator`, and any key of the pipeline
    /// that differs for it. Names of outputs tell them apart by `{target}`.
    targets: Option<BTreeMap<String, Value>>,
    /// Keys to vary and their values, e.g. `transfer.deformer.lambda: [0.1, 0.5, 5]`: a run for every combination, with a table at
    /// the end. Names of outputs tell them apart by `{matrix}`, or with targets by `{name}`.
    #[schemars(extend("examples" = [{ "transfer.deformer.lambda": [0.1, 0.5, 5] }]))]
    matrix: Option<BTreeMap<String, Vec<Value>>>,
}

/// The JSON Schema of a pipeline's file, made of the types that it is read into.
pub fn file_schema() -> Value {
    let generator = || SchemaSettings::draft2020_12().into_generator();
    let mut root = generator().into_root_schema_for::<Pipeline>().to_value();
    let composition = generator().into_root_schema_for::<Composition>().to_value();
    let target = generator().into_root_schema_for::<Target>().to_value();
    variables_too(&mut root);
    let mut own = properties(&composition);
    for slot in COMPOSITION_KEYS {
        own[slot]["type"] = json!(if slot == "include" { json!(["string", "array"]) } else { json!("object") });
        if let Some(schema) = own[slot].as_object_mut() {
            schema.retain(|key, _| !["anyOf", "default"].contains(&key.as_str()));
        }
    }
    own["include"]["items"] = json!({ "type": "string" });
    own["matrix"]["additionalProperties"] = json!({ "type": "array", "minItems": 1 });

    let stages = stage_slots();
    let mut slots = properties(&root);
    for slot in &stages {
        or(&mut slots[*slot], json!({ "$ref": "#/$defs/Settings" }));
    }
    let mut entry = properties(&target);
    entry.extend(
        slots.iter().filter(|(slot, _)| *slot != "target").map(|(slot, schema)| (slot.clone(), schema.clone())),
    );
    entry.insert("variables".into(), own["variables"].clone());
    own["targets"]["minProperties"] = json!(1);
    own["targets"]["additionalProperties"] = json!({ "$ref": "#/$defs/TargetEntry" });

    let mut all = Map::new();
    let mut slots = slots.into_iter();
    all.extend(own.shift_remove_entry("include"));
    all.extend(own.shift_remove_entry("variables"));
    all.extend(slots.by_ref().take(2));
    all.extend(own.shift_remove_entry("targets"));
    all.extend(slots);
    all.extend(own);
    // A file that includes another may leave out what that says.
    let typed = json!({ "if": { "type": "object" }, "then": { "required": ["type"] } });
    let stages: Map<String, Value> = stages.iter().map(|slot| (slot.to_string(), typed.clone())).collect();
    let mut required = root["required"].as_array().cloned().unwrap_or_default();
    required.retain(|slot| slot != "target");
    root["properties"] = Value::Object(all);
    if let Some(root) = root.as_object_mut() {
        root.shift_remove("required");
        root.insert("if".into(), json!({ "required": ["include"] }));
        let targets = json!([{ "required": ["target"] }, { "required": ["targets"] }]);
        let rest = json!({ "required": required, "oneOf": targets, "properties": stages });
        root.insert("else".into(), rest);
    }
    root["$defs"]["Variable"] = json!({
        "description": "The value of a variable, `${name}`.", "type": "string", "pattern": "^\\$\\{[^{}]+\\}$",
    });
    root["$defs"]["Settings"] = json!({
        "description": "Settings of a stage whose type is named elsewhere.", "type": "object",
        "properties": { "type": { "$ref": "#/$defs/Variable" } },
    });
    root["$defs"]["TargetEntry"] = json!({
        "description": "A mesh that takes the motion, and what differs for it.", "type": "object", "properties": entry,
        "additionalProperties": false,
    });
    root
}

/// The keys of a pipeline that hold one stage.
fn stage_slots() -> Vec<&'static str> {
    let slots = SchemaNode::pipeline().properties(None);
    slots.into_iter().filter(|(_, node)| node.stage().is_some()).map(|(key, _)| key).collect()
}

fn properties(schema: &Value) -> Map<String, Value> {
    schema.get("properties").and_then(Value::as_object).cloned().unwrap_or_default()
}

/// Lets every value that is no text be a variable too.
fn variables_too(schema: &mut Value) {
    match schema {
        Value::Object(map) => {
            for (key, value) in map.iter_mut() {
                // What stands for itself is no schema.
                if !["default", "examples", "const", "enum"].contains(&key.as_str()) {
                    variables_too(value);
                }
            }
            for (_, property) in map.get_mut("properties").and_then(Value::as_object_mut).into_iter().flatten() {
                variable_too(property);
            }
            if let Some(items) = map.get_mut("items") {
                variable_too(items);
            }
        }
        Value::Array(list) => list.iter_mut().for_each(variables_too),
        _ => {}
    }
}

fn variable_too(schema: &mut Value) {
    let is_text = match schema.get("type") {
        Some(Value::String(kind)) => kind == "string",
        Some(Value::Array(kinds)) => kinds.iter().any(|kind| kind == "string"),
        _ => false,
    };
    if schema.is_object() && schema.get("const").is_none() && !is_text {
        or(schema, json!({ "$ref": "#/$defs/Variable" }));
    }
}

/// Lets a value fit `other` as well; what editors show of it stays on top.
fn or(schema: &mut Value, other: Value) {
    let Some(map) = schema.as_object_mut() else { return };
    let inner: Vec<(String, Value)> = {
        let keys: Vec<String> = map
            .keys()
            .filter(|key| !["description", "default", "examples", "title"].contains(&key.as_str()))
            .cloned()
            .collect();
        keys.into_iter().filter_map(|key| map.shift_remove_entry(&key)).collect()
    };
    let mut choices = match &inner[..] {
        [(key, Value::Array(choices))] if key == "anyOf" => choices.clone(),
        _ => vec![Value::Object(inner.into_iter().collect())],
    };
    choices.push(other);
    map.insert("anyOf".into(), Value::Array(choices));
}
