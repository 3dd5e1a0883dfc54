use serde_json::{Map, Value, json};

use super::{Ended, list::description, terminal};
use crate::diagnostic::Kind;
use crate::text::pairs;
use crate::{
    core::{Plugin, plugin, stage::Metric},
    diagnostic::Diagnostic,
    pipeline::{
        choices, described_choices, range, settings_schema,
        words::{did_you_mean, unknown_type},
    },
    status::Status,
};

/// Shows an implementation of a stage: what it does, its settings, and how it looks in YAML.
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
    pub fn run(&self) -> Ended {
        let plugin = self.find()?;
        let schema = settings_schema(plugin);
        let defaults = (plugin.settings)();
        if self.json {
            terminal::print_json(&json!({
                "stage": plugin.stage, "type": (plugin.name)(), "description": description(plugin),
                "schema": schema, "defaults": defaults,
            }));
        } else {
            terminal::print(&page(plugin, &schema, &defaults));
        }
        Ok(Status::Done)
    }

    fn find(&self) -> crate::diagnostic::Result<&'static Plugin> {
        known_stage(&self.stage)?;
        let all = plugin::all();
        let found = all.into_iter().find(|plugin| plugin.stage == self.stage && (plugin.name)() == self.name);
        found.ok_or_else(|| {
            let told = unknown_type(&self.stage, &self.name);
            Diagnostic::new(Kind::Usage, told.message).hint(told.hint).into()
        })
    }
}

/// That there is a stage called `stage`.
pub fn known_stage(stage: &str) -> crate::diagnostic::Result<()> {
    let mut stages: Vec<_> = plugin::all().iter().map(|plugin| plugin.stage).collect();
    stages.dedup();
    if stages.contains(&stage) {
        return Ok(());
    }
    let known = || format!("stages: {}", stages.join(", "));
    let hint = did_you_mean(stage, &stages).unwrap_or_else(known);
    Err(Diagnostic::new(Kind::Usage, format!("unknown stage `{stage}`")).hint(hint).into())
}

fn page(plugin: &Plugin, schema: &Value, defaults: &Value) -> String {
    let name = (plugin.name)();
    let mut text = format!("{} {name}\n\n{}\n", plugin.stage, description(plugin).trim());
    text += &figures(plugin);
    let needed = schema.get("required").and_then(Value::as_array).into_iter().flatten();
    let needed: Vec<&str> = needed.filter_map(Value::as_str).collect();
    let settings = schema.get("properties").and_then(Value::as_object).cloned().unwrap_or_default();
    if settings.is_empty() {
        text += "\nIt has no settings.\n";
    } else {
        text += "\nSettings\n";
        let default = |key: &String| if needed.contains(&key.as_str()) { None } else { defaults.get(key) };
        let row = |(key, schema): (&String, &Value)| (key.clone(), setting(schema, default(key)));
        text += &pairs(&settings.iter().map(row).collect::<Vec<_>>());
    }
    text + "\nIn YAML, with all defaults\n" + &example(plugin.stage, name, &needed, defaults.as_object())
}

/// What a metric measures, in the order of gates; empty for other stages.
fn figures(plugin: &Plugin) -> String {
    let metric = Some(plugin).filter(|plugin| plugin.stage == "metric");
    let Some(metric) = metric.and_then(|plugin| plugin::instance::<dyn Metric>((plugin.name)())) else {
        return String::new();
    };
    let name = (plugin.name)();
    let limit = |figure: &&str| metric.limits().into_iter().find(|limit| limit.figure == *figure);
    let row = |(i, figure): (usize, &&str)| {
        let gate =
            if i == 0 { format!("gate `{name}` or `{name}_{figure}`") } else { format!("gate `{name}_{figure}`") };
        let limits = limit(figure).map(|limit| format!(", doubtful above {}, bad above {}", limit.doubtful, limit.bad));
        ((*figure).to_owned(), gate + &limits.unwrap_or_default())
    };
    let when = match (metric.by_default(), metric.needs_truth()) {
        (true, true) => "It is measured where the truth is known.",
        (true, false) => "It is measured of every run.",
        (false, _) => "It is measured where a pipeline names it.",
    };
    let rows: Vec<_> = metric.figures().iter().enumerate().map(row).collect();
    format!("\n{when}\n\nFigures\n{}", pairs(&rows))
}

/// Kind, range and default in the first line, then the doc comment and that of every choice; without a default it must
/// be given.
fn setting(schema: &Value, default: Option<&Value>) -> String {
    let mut head =
        vec![default.and_then(nested).map_or_else(|| kind(schema), |plugin| format!("a stage, {}", plugin.stage))];
    head.extend(range(schema));
    match default {
        Some(Value::Null) => {}
        Some(Value::String(word)) => head.push(format!("default {word}")),
        Some(stage) if nested(stage).is_some() => head.push(format!("default {}", in_yaml(stage))),
        Some(default) => head.push(format!("default {default}")),
        None => head.push("must be given".into()),
    }
    let mut lines = vec![head.join(", ")];
    lines.push(schema.get("description").and_then(Value::as_str).unwrap_or_default().into());
    let choices = described_choices(schema);
    lines.extend(
        choices.into_iter().filter(|(_, doc)| !doc.is_empty()).map(|(choice, doc)| format!("- {choice}: {doc}")),
    );
    lines.join("\n")
}

/// The implementation that a stage within a stage is.
fn nested(value: &Value) -> Option<&'static Plugin> {
    let name = value.get("type")?.as_str()?;
    let has_keys = |plugin: &&Plugin| {
        let defaults = (plugin.settings)();
        value.as_object().is_some_and(|map| map.keys().all(|key| key == "type" || defaults.get(key).is_some()))
    };
    plugin::all().into_iter().filter(|plugin| (plugin.name)() == name).find(has_keys)
}

/// A value as YAML has it in a line; of a stage within a stage only what differs from its defaults.
fn in_yaml(value: &Value) -> String {
    let (Some(plugin), Some(map)) = (nested(value), value.as_object()) else { return value.to_string() };
    let defaults = (plugin.settings)();
    let others = map.iter().filter(|(key, value)| *key != "type" && defaults.get(key) != Some(value));
    let others: String = others.map(|(key, value)| format!(", {key}: {}", in_yaml(value))).collect();
    format!("{{ type: {}{others} }}", (plugin.name)())
}

fn kind(schema: &Value) -> String {
    let word = |name: &str| match name {
        "number" => "a number",
        "integer" => "a whole number",
        "string" => "a text",
        "boolean" => "true or false",
        "array" => "a list",
        "object" => "a map",
        "null" => "nothing",
        _ => "a value",
    };
    let values: Vec<String> = choices(schema);
    if !values.is_empty() {
        return format!("one of {}", values.join(", "));
    }
    let limit = |key: &str| schema.get(key).and_then(Value::as_u64);
    let item = schema.get("items").and_then(|items| items.get("type")).and_then(Value::as_str);
    if let (Some(item @ ("number" | "integer")), Some(least), Some(most)) = (item, limit("minItems"), limit("maxItems"))
        && least == most
    {
        return format!("a list of {least} {}", if item == "number" { "numbers" } else { "whole numbers" });
    }
    match schema.get("type") {
        Some(Value::String(name)) => word(name).into(),
        Some(Value::Array(names)) => {
            let names = names.iter().filter_map(Value::as_str).filter(|name| *name != "null");
            names.map(word).collect::<Vec<_>>().join(" or ")
        }
        _ => "a value".into(),
    }
}

fn example(stage: &str, name: &str, needed: &[&str], defaults: Option<&Map<String, Value>>) -> String {
    let settings = defaults.into_iter().flatten().filter(|(_, value)| !value.is_null());
    let mut lines = vec![format!("type: {name}")];
    lines.extend(settings.map(|(key, value)| match value {
        _ if needed.contains(&key.as_str()) => format!("{key}: …"),
        // Words need no quotes in YAML; other texts keep theirs.
        Value::String(word) if !word.is_empty() && word.chars().all(|c| c.is_ascii_lowercase() || c == '_') => {
            format!("{key}: {word}")
        }
        _ => format!("{key}: {}", in_yaml(value)),
    }));
    match stage {
        "metric" | "format" => format!("  {stage}s:\n    - {}\n", lines.join("\n      ")),
        "generator" => format!("  source:\n    generator:\n      {}\n", lines.join("\n      ")),
        _ => format!("  {stage}:\n    {}\n", lines.join("\n    ")),
    }
}
