//! `--set slot.key=value`: values that replace those of the file.

use serde_json::{Map, Value, json};

use super::{
    Document, Step,
    document::{type_first, yaml_value},
    places::{Node, Part, Spot},
};
use crate::{
    core::plugin,
    diagnostic::Kind,
    diagnostic::{Diagnostic, Location},
};

/// Replaces values of `document` as `settings` say, in their order: `transfer.strength=0.5`, `output=[a.obj, b.glb]`.
///
/// Values are YAML; what the path lacks is made, stages within a stage with their default types. They are checked like those of the file, when the document is parsed.
///
/// # Errors
///
/// Settings that are not understood, each named.
pub fn apply(document: &mut Document, settings: &[String]) -> Result<(), Vec<Diagnostic>> {
    let mut diagnostics = Vec::new();
    for setting in settings {
        if let Err(diagnostic) = apply_one(document, setting) {
            diagnostics.push(diagnostic);
        }
    }
    if diagnostics.is_empty() { Ok(()) } else { Err(diagnostics) }
}

fn apply_one(document: &mut Document, setting: &str) -> Result<(), Diagnostic> {
    let option = format!("--set {setting}");
    let wrong = |message: String, hint: &str| {
        Diagnostic::new(Kind::Usage, message).at(Location::Option(option.clone())).hint(hint)
    };
    let (path, value) = read(setting).map_err(|(message, hint)| wrong(message, hint))?;
    let spot = Spot::Option(option.as_str().into());
    let node = Node::leaf(spot.clone(), document.root.folder.clone());
    put(document, &path, value, Part { step: Step::Index(0), key: spot, node }).map_err(|problem| {
        let hint = problem.list.map(|list| format!("set the whole list: `--set '{list}=[…]'`")).unwrap_or_default();
        wrong(problem.message, &hint)
    })
}

/// The path and the value of a setting.
///
/// # Errors
///
/// What is wrong with it, and the way out.
pub(super) fn read(setting: &str) -> Result<(Vec<Step>, Value), (String, &'static str)> {
    let Some((keys, text)) = setting.split_once('=') else {
        return Err(("expected `key=value`".into(), "e.g. `--set transfer.type=gradient`"));
    };
    let path = split(keys).ok_or(("empty key".into(), "keys are joined by single dots, e.g. `source.rest`"))?;
    let value =
        yaml_value(text).map_err(|_| ("the value is not valid YAML".into(), "put texts with `:` or `#` in quotes"))?;
    Ok((path, value))
}

/// The path that `keys` tell, joined by dots; none if one is empty. The keys of `matrix` are such paths themselves, so what
/// follows it is one key.
pub(super) fn split(keys: &str) -> Option<Vec<Step>> {
    let keys = keys.trim();
    let path: Vec<Step> = match keys.strip_prefix("matrix.") {
        Some(key) => vec![Step::Key("matrix".into()), Step::Key(key.into())],
        None => keys.split('.').map(Step::parse).collect(),
    };
    (!path.contains(&Step::Key(String::new()))).then_some(path)
}

/// Why nothing can be put there.
pub(super) struct Problem {
    /// What is wrong.
    pub message: String,
    /// The list that is to be given as a whole instead.
    pub list: Option<String>,
}

/// Puts `value` at `path`; it was written at `from`, and so is what has to be made around it.
///
/// # Errors
///
/// If the path does not fit the document.
pub(super) fn put(document: &mut Document, path: &[Step], value: Value, from: Part) -> Result<(), Problem> {
    let mut location = &mut document.value;
    let mut node = &mut document.root;
    let made = |step: &Step| Part {
        step: step.clone(),
        key: from.key.clone(),
        node: Node::leaf(from.node.spot.clone(), from.node.folder.clone()),
    };
    for (i, step) in path.iter().enumerate() {
        let so_far = || path[..i].iter().map(Step::to_string).collect::<Vec<_>>().join(".");
        let problem = |message: String, list: Option<String>| Problem { message, list };
        let absent = |value: &Value| match (step, value) {
            (Step::Index(index), Value::Array(_)) => value[*index].is_null(),
            (step, value) => value.get(step.to_string()).is_none_or(Value::is_null),
        };
        let made_here = absent(location) || i + 1 == path.len();
        match (step, &mut *location) {
            (Step::Index(index), Value::Array(list)) => {
                let count = list.len();
                if *index >= count {
                    let items = if count == 1 { "item" } else { "items" };
                    let message = format!("`{}` has {count} {items}, there is no item {index} (from 0)", so_far());
                    return Err(problem(message, None));
                }
            }
            // A list that is not there begins with its first item.
            (Step::Index(0), location @ Value::Null) if i > 0 => *location = Value::Array(vec![Value::Null]),
            (Step::Index(index), value) if i > 0 && value.get(index.to_string()).is_none() => {
                let message = format!("`{}` is no list, there is no item {index} (from 0)", so_far());
                return Err(problem(message, Some(so_far())));
            }
            (_, Value::Array(_)) => {
                let message = format!("`{}` is a list, expected a number from 0, found `{step}`", so_far());
                return Err(problem(message, None));
            }
            // What is no map is replaced by one, as if the file had said nothing.
            (step, other) => {
                if !other.is_object() {
                    *other = Value::Object(Map::new());
                    *node = made(step).node;
                }
                if i + 1 < path.len()
                    && other.get(step.to_string()).is_none_or(Value::is_null)
                    && let Some(nested) = default_of_nested(other, &step.to_string())
                {
                    other[step.to_string()] = json!({ "type": nested });
                }
            }
        }
        let step = if location.is_array() { step.clone() } else { Step::Key(step.to_string()) };
        if made_here {
            node.put(made(&step));
        }
        location = match &step {
            Step::Index(index) => &mut location[*index],
            Step::Key(key) => &mut location[key],
        };
        node = &mut node.part_mut(&step).node;
    }
    *location = value;
    *node = from.node;
    document.value = type_first(std::mem::take(&mut document.value));
    Ok(())
}

/// The type of the stage that `stage` takes for its slot `slot` where the file names none.
fn default_of_nested(stage: &Value, slot: &str) -> Option<String> {
    let name = stage.get("type")?.as_str()?;
    // An implementation of another stage may have the name as well, but hardly that slot.
    let mut named = plugin::all().into_iter().filter(|plugin| (plugin.name)() == name);
    named.find_map(|plugin| Some((plugin.settings)().get(slot)?.get("type")?.as_str()?.into()))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::pipeline::{At, document::path};

    fn set(text: &str, settings: &[&str]) -> Result<Document, String> {
        let mut document = Document::parse(Path::new("p.yaml"), text).unwrap();
        let settings: Vec<_> = settings.iter().map(|s| s.to_string()).collect();
        match apply(&mut document, &settings) {
            Ok(()) => Ok(document),
            Err(diagnostics) => Err(diagnostics.iter().map(Diagnostic::to_string).collect::<Vec<_>>().join("\n")),
        }
    }

    #[test]
    #[cfg(feature = "bundled")]
    fn a_stage_within_a_stage_keeps_its_default_type() {
        let document = set("transfer: { type: biharmonic }\n", &["transfer.deformer.lambda=5"]).unwrap();
        let expected = r#"{"transfer":{"type":"biharmonic","deformer":{"type":"arap_skinning","lambda":5}}}"#;
        assert_eq!(document.value.to_string(), expected);
    }

    #[test]
    fn values_are_yaml_and_missing_maps_are_made() {
        let settings = ["transfer.type=x", "transfer.k=0.5", "output=[a, b]", "output.1=c", "q='1'"];
        let document = set("a: 1\noutput: z\n", &settings).unwrap();
        assert_eq!(document.value.to_string(), r#"{"a":1,"output":["a","c"],"transfer":{"type":"x","k":0.5},"q":"1"}"#);
    }

    #[test]
    fn a_set_value_has_its_place_at_the_option() {
        let document = set("transfer: { type: x }\n", &["transfer.k=1"]).unwrap();
        assert_eq!(document.location(&path(["transfer", "k"]), At::Value).to_string(), "--set transfer.k=1");
        assert_eq!(document.location(&path(["transfer", "type"]), At::Value).to_string(), "p.yaml:1:19");
    }

    #[test]
    fn what_a_value_is_set_into_has_its_place_at_the_option_too() {
        let document = set("transfer: { type: x }\nk: 1\n", &["tranfer.k=1", "metrics.0.type=y", "k.a=1"]).unwrap();
        assert_eq!(document.value["metrics"].to_string(), r#"[{"type":"y"}]"#);
        assert_eq!(document.location(&path(["tranfer"]), At::Key).to_string(), "--set tranfer.k=1");
        assert_eq!(document.location(&path(["metrics", "0", "k"]), At::Value).to_string(), "--set metrics.0.type=y");
        assert_eq!(document.location(&path(["transfer", "z"]), At::Value).to_string(), "p.yaml:1:11");
    }

    #[test]
    fn what_is_not_understood_names_the_option() {
        assert_eq!(
            set("a: [1]\nc: x\n", &["a", "a.5=1", "a.b=1", "c.0=1"]).unwrap_err(),
            "--set a: expected `key=value`\n  hint: e.g. `--set transfer.type=gradient`\n\
             --set a.5=1: `a` has 1 item, there is no item 5 (from 0)\n\
             --set a.b=1: `a` is a list, expected a number from 0, found `b`\n\
             --set c.0=1: `c` is no list, there is no item 0 (from 0)\n  hint: set the whole list: `--set 'c=[…]'`"
        );
    }
}
