//! Defaults that a slot declares for the stage in it (`x-defaults`), merged before the document is parsed.

use mimesh_document::{Document, Step};
use serde_json::Value;

use super::SchemaNode;

/// Adds to each stage of `document` what its slot declares for its type, unless the document says otherwise.
///
/// `x-defaults` maps types to settings: `{ biharmonic: { weights: { type: biharmonic } } }`. Added settings have the place of
/// the stage that they are added to.
pub fn merge_slot_defaults(document: &mut Document) {
    let mut additions = Vec::new();
    collect(SchemaNode::pipeline(), &document.value, &mut vec![], &mut additions);
    for (path, defaults) in additions {
        if let Some(settings) = document.get_mut(&path) {
            add_missing(settings, &defaults);
        }
    }
}

/// The defaults of every slot within `value`, with the path of the stage that they are for.
fn collect(node: SchemaNode<'_>, value: &Value, path: &mut Vec<Step>, additions: &mut Vec<(Vec<Step>, Value)>) {
    let name = value.get("type").and_then(Value::as_str);
    if let Some(defaults) = name.and_then(|name| node.extension("x-defaults")?.get(name)) {
        additions.push((path.clone(), defaults.clone()));
    }
    let steps: Vec<Step> = match value {
        Value::Object(map) => map.keys().map(|key| Step::Key(key.clone())).collect(),
        Value::Array(list) => (0..list.len()).map(Step::Index).collect(),
        _ => vec![],
    };
    for step in steps {
        let (Some(entry), Some(inner)) = (node.entry(&step, Some(value)), step.get(value)) else { continue };
        path.push(step);
        collect(entry, inner, path, additions);
        path.pop();
    }
}

/// Adds the keys of `defaults` that `settings` lacks; a stage that the document gives another type stays as it is.
fn add_missing(settings: &mut Value, defaults: &Value) {
    let (Some(settings), Some(defaults)) = (settings.as_object_mut(), defaults.as_object()) else { return };
    for (key, default) in defaults {
        match settings.get_mut(key) {
            None => _ = settings.insert(key.clone(), default.clone()),
            Some(own) if own.get("type").is_none() || own.get("type") == default.get("type") => {
                add_missing(own, default);
            }
            Some(_) => {}
        }
    }
}
