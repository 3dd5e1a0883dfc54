//! Numbers out of the range that the schema of a stage gives them, with the place of each.

use schemars::generate::SchemaSettings;
use serde_json::Value;

use super::{At, Document, Step, parse::stage_at};
use crate::{
    core::{Plugin, plugin},
    diagnostic::Diagnostic,
};

/// The numbers at and below `path` that lie outside their range, in stages told apart by `type`.
pub fn check(document: &Document, path: &[Step]) -> Vec<Diagnostic> {
    let mut diagnostics = Vec::new();
    if let Some(value) = path.iter().try_fold(&document.value, |value, step| step.get(value)) {
        visit(document, &mut path.to_vec(), value, &mut diagnostics);
    }
    diagnostics
}

fn visit(document: &Document, path: &mut Vec<Step>, value: &Value, diagnostics: &mut Vec<Diagnostic>) {
    match value {
        Value::Object(map) => {
            let stage = stage_at(path);
            let properties =
                map.get("type").and_then(Value::as_str).and_then(|name| properties(stage.as_deref(), name));
            for (key, value) in map {
                path.push(Step::Key(key.clone()));
                let range = properties.as_ref().and_then(|properties| properties.get(key));
                if let (Some(range), Some(number)) = (range, value.as_f64())
                    && let Some(expected) = violated(range, number)
                {
                    let message = format!("`{key}`: expected {expected}, found {value}");
                    diagnostics.push(document.diagnostic(path, At::Value, message));
                }
                visit(document, path, value, diagnostics);
                path.pop();
            }
        }
        Value::Array(list) => {
            for (i, value) in list.iter().enumerate() {
                path.push(Step::Index(i));
                visit(document, path, value, diagnostics);
                path.pop();
            }
        }
        _ => {}
    }
}

/// The schemas of the settings of an implementation; a stage nested in another is found by its type alone.
fn properties(stage: Option<&str>, name: &str) -> Option<Value> {
    let named = |plugin: &&Plugin| (plugin.name)() == name && stage.is_none_or(|stage| plugin.stage == stage);
    let plugin = plugin::all().into_iter().find(named)?;
    settings_schema(plugin).get("properties").cloned()
}

/// The range in words, if `number` is outside.
fn violated(schema: &Value, number: f64) -> Option<String> {
    let limit = |key: &str| schema.get(key).and_then(Value::as_f64);
    let (min, max) = (limit("minimum"), limit("maximum"));
    let (above, below) = (limit("exclusiveMinimum"), limit("exclusiveMaximum"));
    let inside = min.is_none_or(|min| number >= min)
        && max.is_none_or(|max| number <= max)
        && above.is_none_or(|above| number > above)
        && below.is_none_or(|below| number < below);
    (!inside).then(|| range(schema).unwrap_or_default())
}

/// The JSON Schema of an implementation's settings, without references to other places.
pub fn settings_schema(plugin: &Plugin) -> Value {
    let settings = SchemaSettings::draft2020_12().with(|settings| settings.inline_subschemas = true);
    (plugin.schema)(&mut settings.into_generator()).to_value()
}

/// What a schema lets a value be, if it is one of several.
pub fn choices(schema: &Value) -> Vec<String> {
    described_choices(schema).into_iter().map(|(choice, _)| choice).collect()
}

/// What a schema lets a value be, if it is one of several, each with its description (which may be empty): words, and
/// maps of one key as `{ key: … }`.
pub fn described_choices(schema: &Value) -> Vec<(String, String)> {
    let list = |key: &str| schema.get(key).and_then(Value::as_array).into_iter().flatten();
    let plain = list("enum").filter_map(Value::as_str).map(|word| (word.to_owned(), String::new()));
    let described = list("oneOf").filter_map(|one| {
        let word = one.get("const").and_then(Value::as_str).map(str::to_owned);
        let key = || Some(one.get("properties")?.as_object()?.keys().next()?.as_str());
        let choice = word.or_else(|| Some(format!("{{ {}: … }}", key()?)))?;
        let description = one.get("description").and_then(Value::as_str).unwrap_or_default();
        Some((choice, description.replace('\n', " ")))
    });
    plain.chain(described).collect()
}

/// The words that the value at `path` may be, if it is a setting that is one of several.
pub fn choices_at(document: &Document, path: &[Step]) -> Vec<String> {
    let Some((Step::Key(key), stage)) = path.split_last() else { return vec![] };
    let settings = stage.iter().try_fold(&document.value, |value, step| step.get(value));
    let name = settings.and_then(|settings| settings.get("type")).and_then(Value::as_str);
    let properties = name.and_then(|name| properties(stage_at(stage).as_deref(), name));
    properties.as_ref().and_then(|properties| properties.get(key)).map(choices).unwrap_or_default()
}

/// The range that a schema gives a number, in words, e.g. `0 to 1`.
pub fn range(schema: &Value) -> Option<String> {
    let limit = |key: &str| schema.get(key).and_then(Value::as_f64);
    let low = limit("minimum").map(|min| (min, "at least")).or(limit("exclusiveMinimum").map(|min| (min, "more than")));
    let high = limit("maximum").map(|max| (max, "at most")).or(limit("exclusiveMaximum").map(|max| (max, "less than")));
    match (low, high) {
        (Some((low, "at least")), Some((high, "at most"))) => Some(format!("{low} to {high}")),
        (Some((low, low_word)), Some((high, high_word))) => Some(format!("{low_word} {low} and {high_word} {high}")),
        (Some((limit, word)), None) | (None, Some((limit, word))) => Some(format!("{word} {limit}")),
        (None, None) => None,
    }
}
