//! `--set slot.key=value`: values that replace those of the file.

use serde_json::{Map, Value, json};

use super::{
    Document, Step,
    document::{type_first, yaml_value},
};
use crate::{
    core::plugin,
    mistake::{Mistake, Place},
    status::Status,
};

/// Replaces values of `document` as `settings` say, in their order: `transfer.strength=0.5`, `output=[a.obj, b.glb]`.
///
/// Values are YAML; what the path lacks is made, stages within a stage with their default types. They are checked like those of the file, when the document is parsed.
///
/// # Errors
///
/// Settings that are not understood, each named.
pub fn apply(document: &mut Document, settings: &[String]) -> Result<(), Vec<Mistake>> {
    let mut mistakes = Vec::new();
    for setting in settings {
        if let Err(mistake) = apply_one(document, setting) {
            mistakes.push(mistake);
        }
    }
    if mistakes.is_empty() { Ok(()) } else { Err(mistakes) }
}

fn apply_one(document: &mut Document, setting: &str) -> Result<(), Mistake> {
    let option = format!("--set {setting}");
    let wrong =
        |message: String, hint: &str| Mistake::new(Status::Usage, message).at(Place::Option(option.clone())).hint(hint);
    let Some((keys, text)) = setting.split_once('=') else {
        return Err(wrong("expected `key=value`".into(), "e.g. `--set transfer.type=gradient`"));
    };
    let path: Vec<Step> = keys.trim().split('.').map(Step::parse).collect();
    if path.iter().any(|step| *step == Step::Key(String::new())) {
        return Err(wrong("empty key".into(), "keys are joined by single dots, e.g. `source.rest`"));
    }
    let value = yaml_value(text)
        .map_err(|_| wrong("the value is not valid YAML".into(), "put texts with `:` or `#` in quotes"))?;
    let mut place = &mut document.value;
    for (i, step) in path.iter().enumerate() {
        let so_far = || path[..i].iter().map(Step::to_string).collect::<Vec<_>>().join(".");
        place = match (step, place) {
            (Step::Index(index), Value::Array(list)) => {
                let count = list.len();
                list.get_mut(*index).ok_or_else(|| {
                    let items = if count == 1 { "item" } else { "items" };
                    wrong(format!("`{}` has {count} {items}, there is no item {index} (from 0)", so_far()), "")
                })?
            }
            // A list that is not there begins with its first item.
            (Step::Index(0), place @ Value::Null) if i > 0 => {
                *place = Value::Array(vec![Value::Null]);
                &mut place[0]
            }
            (Step::Index(index), _) if i > 0 => {
                let hint = format!("set the whole list: `--set '{}=[…]'`", so_far());
                return Err(wrong(format!("`{}` is no list, there is no item {index} (from 0)", so_far()), &hint));
            }
            (_, Value::Array(_)) => {
                return Err(wrong(format!("`{}` is a list, expected a number from 0, found `{step}`", so_far()), ""));
            }
            // What is no map is replaced by one, as if the file had said nothing.
            (step, other) => {
                if !other.is_object() {
                    *other = Value::Object(Map::new());
                }
                if i + 1 < path.len()
                    && other.get(step.to_string()).is_none_or(Value::is_null)
                    && let Some(nested) = default_of_nested(other, &step.to_string())
                {
                    other[step.to_string()] = json!({ "type": nested });
                }
                &mut other[step.to_string()]
            }
        };
    }
    *place = value;
    document.value = type_first(std::mem::take(&mut document.value));
    document.overrides.push((path, option));
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
            Err(mistakes) => Err(mistakes.iter().map(Mistake::to_string).collect::<Vec<_>>().join("\n")),
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
        assert_eq!(document.place(&path(["transfer", "k"]), At::Value).to_string(), "--set transfer.k=1");
        assert_eq!(document.place(&path(["transfer", "type"]), At::Value).to_string(), "p.yaml:1:19");
    }

    #[test]
    fn what_a_value_is_set_into_has_its_place_at_the_option_too() {
        let document = set("transfer: { type: x }\nk: 1\n", &["tranfer.k=1", "metrics.0.type=y", "k.a=1"]).unwrap();
        assert_eq!(document.value["metrics"].to_string(), r#"[{"type":"y"}]"#);
        assert_eq!(document.place(&path(["tranfer"]), At::Key).to_string(), "--set tranfer.k=1");
        assert_eq!(document.place(&path(["metrics", "0", "k"]), At::Value).to_string(), "--set metrics.0.type=y");
        assert_eq!(document.place(&path(["transfer", "z"]), At::Value).to_string(), "p.yaml:1:11");
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
