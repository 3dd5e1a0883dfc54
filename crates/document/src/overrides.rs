//! Settings beside a file, `slot.key=value`: values that replace those of the file.

use serde_json::{Map, Value, json};

use crate::{
    diagnostic::{Diagnostic, Diagnostics, Kind, Location, SET_VALUE},
    document::Document,
    finite::{NOT_FINITE, is_about_finiteness},
    limits::MAX_PATH_STEPS,
    shapes::Shapes,
    source_tree::{SourceSpan, SpanEntry, SpanTree},
    step::Step,
    yaml::{type_first, yaml_value},
};

/// Replaces values of `document` by `settings`, in their order: `transfer.strength=0.5`, `output=[a.obj, b.glb]`.
///
/// Values are YAML. What the path lacks is made; settings told apart by `type` within others get their default type from
/// `shapes`. Values are checked with those of the file, when the document is parsed.
///
/// # Errors
///
/// A diagnostic for each setting that cannot be applied.
pub fn apply(document: &mut Document, settings: &[String], shapes: &dyn Shapes) -> Result<(), Diagnostics> {
    let mut diagnostics = Diagnostics::default();
    diagnostics.extend(settings.iter().filter_map(|setting| apply_one(document, setting, shapes).err()));
    diagnostics.into_result()
}

fn apply_one(document: &mut Document, setting: &str, shapes: &dyn Shapes) -> Result<(), Diagnostic> {
    let wrong = |message: String| Diagnostic::new(Kind::Usage, message).at(Location::Setting(setting.into()));
    let (path, value) = read(setting).map_err(|problem| {
        let diagnostic = wrong(problem.message.into());
        match problem.example {
            Some(example) => diagnostic.remedy(SET_VALUE, example, format!("e.g. `{example}`")),
            None => diagnostic.hint(problem.hint),
        }
    })?;
    let span = SourceSpan::Setting(setting.into());
    let node = SpanTree::leaf(span.clone(), document.root.folder.clone());
    let entry = SpanEntry { step: Step::Index(0), key: span, node };
    put(document, &path, value, entry, shapes).map_err(|problem| {
        let diagnostic = wrong(problem.message);
        match problem.list {
            Some(list) => {
                diagnostic.remedy(SET_VALUE, format!("{list}=[…]"), format!("set the whole sequence `{list}`"))
            }
            None => diagnostic,
        }
    })
}

/// Why a setting cannot be read.
pub struct Unreadable {
    /// What is wrong.
    pub message: &'static str,
    /// A setting that would do.
    example: Option<&'static str>,
    /// The way out where there is no example.
    hint: &'static str,
}

/// The path and the value of a setting.
///
/// # Errors
///
/// Why it cannot be read, and the way out.
pub fn read(setting: &str) -> Result<(Vec<Step>, Value), Unreadable> {
    let Some((keys, text)) = setting.split_once('=') else {
        return Err(Unreadable { message: "expected `key=value`", example: Some("transfer.type=gradient"), hint: "" });
    };
    let hint = "keys are joined by single dots, e.g. `source.rest`";
    let path = split(keys).ok_or(Unreadable { message: "empty key", example: None, hint })?;
    let value = yaml_value(text).map_err(|error| match error.to_string() {
        problem if is_about_finiteness(&problem) => {
            let hint = "write a number below 1e308, or `~` for none";
            Unreadable { message: NOT_FINITE, example: None, hint }
        }
        _ => {
            let hint = "put strings with `:` or `#` in quotes";
            Unreadable { message: "the value is not valid YAML", example: None, hint }
        }
    })?;
    Ok((path, value))
}

/// The path of `keys` joined by dots; `None` if a key is empty, or there are more than a pipeline has within each other.
///
/// The keys of `matrix` are such paths themselves, so all that follows `matrix.` is one key.
pub fn split(keys: &str) -> Option<Vec<Step>> {
    let keys = keys.trim();
    let path: Vec<Step> = match keys.strip_prefix("matrix.") {
        Some(key) => vec![Step::Key("matrix".into()), Step::Key(key.into())],
        None => keys.split('.').take(MAX_PATH_STEPS + 1).map(Step::parse).collect(),
    };
    (path.len() <= MAX_PATH_STEPS && !path.contains(&Step::Key(String::new()))).then_some(path)
}

/// Why nothing can be put there.
pub struct Problem {
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
pub fn put(
    document: &mut Document,
    path: &[Step],
    value: Value,
    from: SpanEntry,
    shapes: &dyn Shapes,
) -> Result<(), Problem> {
    let defaults: Vec<Option<String>> =
        (0..path.len()).map(|i| shapes.default_type(&document.value, &path[..=i])).collect();
    let mut location = &mut document.value;
    let mut node = &mut document.root;
    let made = |step: &Step| SpanEntry {
        step: step.clone(),
        key: from.key.clone(),
        node: SpanTree::leaf(from.node.span.clone(), from.node.folder.clone()),
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
                let message = format!("`{}` is no sequence, there is no item {index} (from 0)", so_far());
                return Err(problem(message, Some(so_far())));
            }
            (_, Value::Array(_)) => {
                let message = format!("`{}` is a sequence, expected a number from 0, found `{step}`", so_far());
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
                    && let Some(nested) = &defaults[i]
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

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::{document::At, shapes::NoShapes, step::path};

    fn set(text: &str, settings: &[&str]) -> Result<Document, String> {
        let mut document = Document::parse(Path::new("p.yaml"), text).unwrap();
        let settings: Vec<_> = settings.iter().map(|s| s.to_string()).collect();
        match apply(&mut document, &settings, &NoShapes) {
            Ok(()) => Ok(document),
            Err(diagnostics) => Err(diagnostics.list.iter().map(Diagnostic::to_string).collect::<Vec<_>>().join("\n")),
        }
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
        assert_eq!(document.location(&path(["transfer", "k"]), At::Value).to_string(), "transfer.k=1");
        assert_eq!(document.location(&path(["transfer", "type"]), At::Value).to_string(), "p.yaml:1:19");
    }

    #[test]
    fn what_a_value_is_set_into_has_its_place_at_the_option_too() {
        let document = set("transfer: { type: x }\nk: 1\n", &["tranfer.k=1", "metrics.0.type=y", "k.a=1"]).unwrap();
        assert_eq!(document.value["metrics"].to_string(), r#"[{"type":"y"}]"#);
        assert_eq!(document.location(&path(["tranfer"]), At::Key).to_string(), "tranfer.k=1");
        assert_eq!(document.location(&path(["metrics", "0", "k"]), At::Value).to_string(), "metrics.0.type=y");
        assert_eq!(document.location(&path(["transfer", "z"]), At::Value).to_string(), "p.yaml:1:11");
    }

    #[test]
    fn a_path_has_as_many_keys_as_a_pipeline_has_within_each_other() {
        assert!(split(&["a"; 64].join(".")).is_some_and(|path| path.len() == 64));
        assert!(split(&["a"; 65].join(".")).is_none() && split(&"a.".repeat(1 << 20)).is_none());
    }

    #[test]
    fn what_is_not_understood_names_the_option() {
        assert_eq!(
            set("a: [1]\nc: x\n", &["a", "a.5=1", "a.b=1", "c.0=1", "c=1e999", "c=[1"]).unwrap_err(),
            "a: expected `key=value`\n  hint: e.g. `transfer.type=gradient`\n\
             a.5=1: `a` has 1 item, there is no item 5 (from 0)\n\
             a.b=1: `a` is a sequence, expected a number from 0, found `b`\n\
             c.0=1: `c` is no sequence, there is no item 0 (from 0)\n  hint: set the whole sequence `c`\n\
             c=1e999: expected a finite number\n  hint: write a number below 1e308, or `~` for none\n\
             c=[1: the value is not valid YAML\n  hint: put strings with `:` or `#` in quotes"
        );
    }
}
