//! `mimesh show`: the settings of one implementation of a stage.

use mimesh_core::{
    Plugin, plugin,
    stage::{Metric, Statistic},
};
use mimesh_pipeline::{
    schema::{SchemaNode, choices, described_choices, description, inlined_settings_schema, range, settings_schema},
    text::pairs,
};
use serde_json::{Map, Value, json};

use crate::cli::{CommandResult, registry, status::Status, terminal};

/// Shows an implementation of a stage: its purpose, its settings, and an example in YAML.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  mimesh show transfer gradient")]
pub struct Show {
    /// The stage, e.g. transfer
    stage: String,
    /// The type, e.g. gradient
    #[arg(value_name = "TYPE")]
    name: String,
    /// Print description, JSON Schema and defaults as JSON
    #[arg(long)]
    json: bool,
}

impl Show {
    /// Runs the command.
    pub fn run(&self) -> CommandResult {
        let plugin = registry::find(&self.stage, &self.name)?;
        let defaults = plugin.settings();
        if self.json {
            terminal::print_json(&json!({
                "stage": plugin.stage, "type": plugin.name(), "description": description(plugin),
                "schema": inlined_settings_schema(plugin), "defaults": defaults,
            }));
        } else {
            terminal::print(&page(plugin, &settings_schema(plugin), &defaults));
        }
        Ok(Status::Done)
    }
}

/// The description, the settings and the example of an implementation.
fn page(plugin: &Plugin, schema: &Value, defaults: &Value) -> String {
    let name = plugin.name();
    let mut text = format!("{} {name}\n\n{}\n", plugin.stage, description(plugin).trim());
    text += &statistics(plugin);
    let required = required(schema);
    let mut rows = Vec::new();
    for (key, node) in SchemaNode::of_root(schema).properties(None) {
        let default = if required.contains(&key) { None } else { defaults.get(key) };
        add_rows(&mut rows, key.into(), node, default);
    }
    if rows.is_empty() {
        text += "\nIt has no settings.\n";
    } else {
        text += "\nSettings\n";
        text += &pairs(&rows);
    }
    text + "\nIn YAML, with all defaults\n"
        + &example(plugin, SchemaNode::of_root(schema), &required, defaults.as_object())
}

/// The settings that have no default.
fn required(schema: &Value) -> Vec<&str> {
    let names = schema.get("required").and_then(Value::as_array).into_iter().flatten();
    names.filter_map(Value::as_str).collect()
}

/// The statistics of a metric with units, gates and limits, and when it is measured; empty for other stages.
fn statistics(plugin: &Plugin) -> String {
    let metric = Some(plugin).filter(|plugin| plugin.stage == "metric");
    let Some(metric) = metric.and_then(|plugin| plugin::instance::<dyn Metric>(plugin.name())) else {
        return String::new();
    };
    let name = plugin.name();
    let row = |(i, statistic): (usize, &Statistic)| {
        let Statistic { name: key, title, unit, limits, meaning, .. } = statistic;
        let title = if title.is_empty() { String::new() } else { format!("\nin verdicts: {title}") };
        let gate = if i == 0 { format!("gate `{name}` or `{name}_{key}`") } else { format!("gate `{name}_{key}`") };
        let limits = limits.map(|limits| format!(", doubtful above {}, bad above {}", limits.doubtful, limits.bad));
        ((*key).to_owned(), format!("{meaning}\nunit {unit}, {gate}{}{title}", limits.unwrap_or_default()))
    };
    let when = match (metric.by_default(), metric.needs_ground_truth()) {
        (true, true) => "It is measured where the truth is known.",
        (true, false) => "It is measured in every run.",
        (false, _) => "It is measured where a pipeline names it.",
    };
    let rows: Vec<_> = metric.statistics().iter().enumerate().map(row).collect();
    format!("\n{when}\n\nStatistics\n{}", pairs(&rows))
}

/// Adds the row of a setting, then the rows of the settings within it with dotted names.
fn add_rows(rows: &mut Vec<(String, String)>, key: String, node: SchemaNode<'_>, default: Option<&Value>) {
    let inner = if node.stage().is_none() { node.properties(None) } else { vec![] };
    rows.push((key.clone(), setting(node, default, inner.is_empty())));
    for (name, node) in inner {
        add_rows(rows, format!("{key}.{name}"), node, default.and_then(|default| default.get(name)));
    }
}

/// A setting in lines: type, range and default first, then its description and those of its choices.
///
/// A setting without a default must be given.
fn setting(node: SchemaNode<'_>, default: Option<&Value>, is_leaf: bool) -> String {
    let mut head = vec![match node.stage() {
        Some(stage) => format!("a stage, {stage}"),
        None => kind(node.schema()),
    }];
    head.extend(range(node.schema()));
    match default {
        Some(Value::Null) => {}
        Some(Value::String(text)) => head.push(format!("default {text}")),
        Some(default) if node.stage().is_some() => head.push(format!("default {}", in_yaml(node, default))),
        Some(default) if is_leaf => head.push(format!("default {default}")),
        Some(_) => {}
        None => head.push("must be given".into()),
    }
    let mut lines = vec![head.join(", "), node.description().to_owned()];
    for (name, defaults) in node.extension("x-defaults").and_then(Value::as_object).into_iter().flatten() {
        lines.push(format!("- the default of {name} here is {}", yaml_mapping(defaults)));
    }
    let choices = if node.stage().is_none() { described_choices(node.schema()) } else { vec![] };
    lines.extend(
        choices.into_iter().filter(|(_, doc)| !doc.is_empty()).map(|(choice, doc)| format!("- {choice}: {doc}")),
    );
    lines.join("\n")
}

/// A value in a line of YAML. A stage has only those settings that differ from its defaults.
fn in_yaml(node: SchemaNode<'_>, value: &Value) -> String {
    let name = value.get("type").and_then(Value::as_str);
    let (Some(stage), Some(name), Some(entries)) = (node.stage(), name, value.as_object()) else {
        return value.to_string();
    };
    let plugin = plugin::all().into_iter().find(|plugin| plugin.stage == stage && plugin.name() == name);
    let defaults = plugin.map(|plugin| plugin.settings()).unwrap_or_default();
    let settings = node.variant(name).map(|settings| settings.properties(None)).unwrap_or_default();
    let mut text = format!("{{ type: {name}");
    for (key, value) in entries.iter().filter(|(key, value)| *key != "type" && defaults.get(key) != Some(value)) {
        let inner = settings.iter().find(|(name, _)| name == key);
        let shown = inner.map_or_else(|| value.to_string(), |(_, node)| in_yaml(*node, value));
        text += &format!(", {key}: {shown}");
    }
    text + " }"
}

/// A mapping in a line of YAML.
fn yaml_mapping(value: &Value) -> String {
    match value {
        Value::Object(entries) => {
            let entries: Vec<_> =
                entries.iter().map(|(key, value)| format!("{key}: {}", yaml_mapping(value))).collect();
            format!("{{ {} }}", entries.join(", "))
        }
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

/// The type of a setting in words.
fn kind(schema: &Value) -> String {
    let values: Vec<String> = choices(schema);
    if !values.is_empty() {
        return format!("one of {}", values.join(", "));
    }
    let limit = |key: &str| schema.get(key).and_then(Value::as_u64);
    let item = schema.get("items").and_then(|items| items.get("type")).and_then(Value::as_str);
    if let (Some(item @ ("number" | "integer")), Some(min), Some(max)) = (item, limit("minItems"), limit("maxItems"))
        && min == max
    {
        return format!("a sequence of {min} {}", if item == "number" { "numbers" } else { "whole numbers" });
    }
    match schema.get("type") {
        Some(Value::String(name)) => kind_word(name).into(),
        Some(Value::Array(names)) => {
            let names = names.iter().filter_map(Value::as_str).filter(|name| *name != "null");
            names.map(kind_word).collect::<Vec<_>>().join(" or ")
        }
        _ => "a value".into(),
    }
}

/// A type of JSON Schema in words.
fn kind_word(name: &str) -> &'static str {
    match name {
        "number" => "a number",
        "integer" => "a whole number",
        "string" => "a string",
        "boolean" => "true or false",
        "array" => "a sequence",
        "object" => "a mapping",
        "null" => "nothing",
        _ => "a value",
    }
}

/// An example of the stage in a pipeline, with all its defaults.
fn example(plugin: &Plugin, node: SchemaNode<'_>, required: &[&str], defaults: Option<&Map<String, Value>>) -> String {
    let settings = node.properties(None);
    let mut lines = vec![format!("type: {}", plugin.name())];
    for (key, value) in defaults.into_iter().flatten().filter(|(_, value)| !value.is_null()) {
        let inner = settings.iter().find(|(name, _)| name == key);
        lines.push(match value {
            _ if required.contains(&key.as_str()) => format!("{key}: …"),
            // A plain word needs no quotes in YAML; other strings keep theirs.
            Value::String(text) if !text.is_empty() && text.chars().all(|c| c.is_ascii_lowercase() || c == '_') => {
                format!("{key}: {text}")
            }
            _ => format!("{key}: {}", inner.map_or_else(|| value.to_string(), |(_, node)| in_yaml(*node, value))),
        });
    }
    match plugin.stage {
        stage @ ("metric" | "format") => format!("  {stage}s:\n    - {}\n", lines.join("\n      ")),
        "generator" => format!("  source:\n    generator:\n      {}\n", lines.join("\n      ")),
        stage => format!("  {stage}:\n    {}\n", lines.join("\n    ")),
    }
}
