//! Stages whose names are aliases: their settings are checked here, and become those of the stages that they stand for.

use std::borrow::Cow;

use mimesh_core::plugin::{Alias, alias, changes};
use mimesh_document::{
    At, Diagnostics, Document, Step,
    serde_errors::{Rephrased, rephrase},
};
use serde_json::Value;

use super::{SchemaNode, values::visit, words::choices};

/// The document with every alias at or within `path` spelled out as what it stands for; `root` is the schema of the whole document.
///
/// A value within an alias has another path there, and no place of its own.
pub fn expand_aliases<'d>(root: SchemaNode<'_>, document: &'d Document, path: &[Step]) -> Cow<'d, Document> {
    let mut places: Vec<(Vec<Step>, &Alias)> = vec![];
    find(root, document, path, &mut |_, alias, path| places.push((path.to_vec(), alias)));
    let mut expanded = Cow::Borrowed(document);
    // The inner ones first, since the outer ones move them.
    for (place, alias) in places.into_iter().rev() {
        if let Some(value) = expanded.to_mut().get_mut(&place)
            && let Some(settings) = value.as_object()
        {
            *value = alias.expand(settings);
        }
    }
    expanded
}

/// Adds a diagnostic for each key that an alias at or within `path` does not have, and each value of a wrong type.
pub fn check_aliases(root: SchemaNode<'_>, document: &Document, path: &[Step], diagnostics: &mut Diagnostics) {
    find(root, document, path, &mut |node, _, path| {
        let Some(settings) = document.get(path).and_then(Value::as_object) else { return };
        let properties = node.properties(document.get(path));
        for (key, value) in settings.iter().filter(|(key, _)| *key != "type") {
            let at: Vec<Step> = path.iter().cloned().chain([Step::Key(key.clone())]).collect();
            let (error, words) = match properties.iter().find(|(name, _)| name == key) {
                Some((_, node)) if node.stage().is_some() => continue,
                Some((_, node)) => match wrong_type(node.schema(), value) {
                    Some(error) => (error, choices(node.schema())),
                    None => continue,
                },
                None => {
                    let known = properties.iter().map(|(name, _)| *name).filter(|name| *name != "type");
                    let known: Vec<_> = known.map(|name| format!("`{name}`")).collect();
                    (format!("unknown field `{key}`, expected one of {}", known.join(", ")), vec![])
                }
            };
            let Rephrased { message, hint, about_key, .. } = rephrase(&error, key, None, &words);
            let point = if about_key { At::Key } else { At::Value };
            diagnostics.push(document.diagnostic(&at, point, message).hint(hint));
        }
    });
}

/// Calls `see` for every alias at or within `path`, the outer ones first.
fn find(
    root: SchemaNode<'_>,
    document: &Document,
    path: &[Step],
    see: &mut impl FnMut(SchemaNode<'_>, &'static Alias, &[Step]),
) {
    if changes() == 0 {
        return;
    }
    let (Some(value), Some(node)) = (document.get(path), root.at(&document.value, path)) else {
        return;
    };
    visit(node, value, &mut path.to_vec(), &mut |node, value, path| {
        let name = value.get("type").and_then(Value::as_str);
        if let Some(alias) = node.stage().zip(name).and_then(|(stage, name)| alias(stage, name)) {
            see(node, alias, path);
        }
    });
}

/// The message of serde for a value that is of none of the types of `schema`.
fn wrong_type(schema: &Value, value: &Value) -> Option<String> {
    let types: Vec<&str> = match schema.get("type")? {
        Value::Array(several) => several.iter().filter_map(Value::as_str).collect(),
        one => one.as_str().into_iter().collect(),
    };
    let fits = |name: &&str| match *name {
        "number" => value.is_number(),
        "integer" => value.as_f64().is_some_and(|number| number.fract() == 0.0),
        "string" => value.is_string(),
        "boolean" => value.is_boolean(),
        "array" => value.is_array(),
        "object" => value.is_object(),
        _ => value.is_null(),
    };
    let words = schema.get("enum").and_then(Value::as_array);
    if types.iter().any(|name| fits(name)) && words.is_none_or(|words| words.contains(value)) {
        return None;
    }
    let expected = match types.first().copied().unwrap_or_default() {
        "number" => "f64",
        "integer" => "i64",
        "string" => "a string",
        "boolean" => "a boolean",
        "array" => "a sequence",
        "object" => "a map",
        other => other,
    };
    let found = match value {
        Value::Null => "null".into(),
        Value::Bool(value) => format!("boolean `{value}`"),
        Value::Number(number) => format!("floating point `{number}`"),
        Value::String(text) => format!("string {text:?}"),
        Value::Array(_) => "sequence".into(),
        Value::Object(_) => "map".into(),
    };
    Some(format!("invalid type: {found}, expected {expected}"))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use serde_json::json;

    use super::*;
    use crate::parse::{Required, parse};

    /// A pipeline with this transfer, once `test_learned` is known; the first lines of what is wrong with it.
    fn parsed(transfer: &str) -> (Value, Vec<String>) {
        let schema = json!({
            "description": "One that is learned.",
            "properties": {
                "strength": { "description": "A number.", "type": "number", "minimum": 0.0 },
                "name": { "description": "A word.", "type": ["string", "null"], "enum": ["a", "b", null] },
            },
        });
        let defaults = json!({ "strength": 1.0, "name": null });
        Alias::register("transfer", "test_learned", "test_foreign", schema, defaults).unwrap();
        let text = format!(
            "source: {{ rest: a.obj, poses: b-*.obj }}\ntarget: {{ rest: c.obj }}\noutput: out/{{pose}}.obj\ntransfer: {transfer}\n"
        );
        let document = Document::parse(Path::new("p.yaml"), &text).unwrap();
        let mut diagnostics = Diagnostics::default();
        let parsed = parse(&document, Required::Run, &mut diagnostics);
        let told = diagnostics.list.iter().map(|one| one.to_string().lines().next().unwrap_or_default().to_owned());
        (serde_json::to_value(parsed.pipeline.transfer).unwrap(), told.collect())
    }

    #[test]
    fn an_alias_is_read_as_what_it_stands_for() {
        let (transfer, wrong) = parsed("{ type: test_learned, strength: 2.5, name: b }");
        assert_eq!(wrong, Vec::<String>::new());
        let settings = json!({ "strength": 2.5, "name": "b" });
        assert_eq!(transfer, json!({ "type": "test_foreign", "class": "test_learned", "settings": settings }));
    }

    #[test]
    fn what_is_wrong_with_its_settings_is_told_at_its_place() {
        let (_, wrong) = parsed("{ type: test_learned, strength: much, nam: a }");
        let expected =
            ["p.yaml:4:45: `strength`: expected a number, found the string \"much\"", "p.yaml:4:51: unknown key `nam`"];
        assert_eq!(wrong, expected);
        assert_eq!(parsed("{ type: test_learned, name: c }").1.len(), 1);
        let out_of_range = "p.yaml:4:45: `strength`: expected at least 0, found -1";
        assert_eq!(parsed("{ type: test_learned, strength: -1 }").1, [out_of_range]);
        assert_eq!(parsed("{ type: test_leaned }").1, ["p.yaml:4:19: unknown transfer `test_leaned`"]);
    }
}
