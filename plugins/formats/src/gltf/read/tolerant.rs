//! JSON as exporters write it, made into what `gltf-json` accepts.
//!
//! The reduced JSON holds only what meshes, skins, morph targets and clips need, so no file is refused for its looks.

use serde_json::{Map, Value, json};

use super::tree;

/// Parses the JSON of a glTF; the bare words `NaN` and `Infinity`, which JSON does not know, become null.
///
/// Beside the JSON there are the keys that stand twice in one object, of which the last counts.
///
/// # Errors
///
/// The parser's message.
pub fn parse(bytes: &[u8]) -> Result<(Value, Vec<String>), String> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii();
    let padding = bytes.iter().rev().take_while(|&&byte| byte == 0).count();
    let text = String::from_utf8_lossy(&bytes[..bytes.len() - padding]);
    tree::parse(&text).or_else(|problem| {
        // A second failure is told as the first: its line and column are those of the file.
        tree::parse(&without_bare_words(&text)).map_err(|_| problem.to_string())
    })
}

/// The text with null for `NaN`, `Infinity` and `-Infinity` outside strings.
fn without_bare_words(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let (mut in_string, mut escaped) = (false, false);
    let mut rest = text;
    while let Some(next) = rest.chars().next() {
        let word =
            ["NaN", "-NaN", "Infinity", "-Infinity"].into_iter().find(|word| !in_string && rest.starts_with(word));
        if let Some(word) = word {
            out.push_str("null");
            rest = &rest[word.len()..];
            continue;
        }
        match next {
            _ if escaped => escaped = false,
            '\\' => escaped = in_string,
            '"' => in_string = !in_string,
            _ => {}
        }
        out.push(next);
        rest = &rest[next.len_utf8()..];
    }
    out
}

/// The form of a value that the readers need.
enum Form {
    /// A whole number from 0; negative ones stand for none in some files.
    Number,
    /// A string; some files have a number.
    Text,
    /// True or false.
    Truth,
    /// A list of whole numbers.
    Numbers,
    /// Whole numbers by name.
    Named,
    Object(&'static [(&'static str, Form)]),
    /// A list of objects whose places count, so that none is dropped.
    List(&'static [(&'static str, Form)]),
    /// As it is.
    Any,
}

use Form::{Any, List, Named, Number, Numbers, Object, Text, Truth};

const SPARSE: &[(&str, Form)] = &[
    ("count", Number),
    ("indices", Object(&[("bufferView", Number), ("byteOffset", Number), ("componentType", Number)])),
    ("values", Object(&[("bufferView", Number), ("byteOffset", Number)])),
];

const ROOT: &[(&str, Form)] = &[
    (
        "accessors",
        List(&[
            ("bufferView", Number),
            ("byteOffset", Number),
            ("componentType", Number),
            ("count", Number),
            ("extensions", Any),
            ("name", Text),
            ("normalized", Truth),
            ("sparse", Object(SPARSE)),
            ("type", Text),
        ]),
    ),
    (
        "animations",
        List(&[
            (
                "channels",
                List(&[
                    ("sampler", Number),
                    ("target", Object(&[("node", Number), ("path", Text), ("extensions", Any)])),
                ]),
            ),
            ("name", Text),
            ("samplers", List(&[("input", Number), ("interpolation", Text), ("output", Number)])),
        ]),
    ),
    ("asset", Object(&[("version", Text)])),
    ("buffers", List(&[("byteLength", Number), ("extensions", Any), ("uri", Text)])),
    (
        "bufferViews",
        List(&[
            ("buffer", Number),
            ("byteLength", Number),
            ("byteOffset", Number),
            ("byteStride", Number),
            ("extensions", Any),
        ]),
    ),
    ("extensionsRequired", Any),
    ("materials", List(&[("name", Text)])),
    (
        "meshes",
        List(&[
            ("name", Text),
            (
                "primitives",
                List(&[
                    ("attributes", Named),
                    ("extensions", Any),
                    ("indices", Number),
                    ("material", Number),
                    ("mode", Number),
                    ("targets", List(&[("POSITION", Number)])),
                ]),
            ),
        ]),
    ),
    ("nodes", List(&[("children", Numbers), ("extensions", Any), ("mesh", Number), ("name", Text), ("skin", Number)])),
    ("scene", Number),
    ("scenes", List(&[("name", Text), ("nodes", Numbers)])),
    ("skins", List(&[("inverseBindMatrices", Number), ("joints", Numbers), ("name", Text)])),
];

/// What is left of a JSON for `gltf-json`.
#[derive(Debug)]
pub struct Reduced {
    /// The JSON.
    pub json: Value,
    /// The animations that had channels of other things than nodes, by number.
    pub pointing: Vec<usize>,
}

/// Reduces `json` to what meshes need, in the form that `gltf-json` accepts; lists keep the places of their entries.
pub fn reduce(json: &Value) -> Reduced {
    let mut reduced = object(json, ROOT);
    let asset = reduced.entry("asset").or_insert_with(|| json!({}));
    if let Some(asset) = asset.as_object_mut() {
        asset.entry("version").or_insert_with(|| "".into());
    }
    let pointing = drop_pointers(&mut reduced);
    fill(&mut reduced, "animations", &[("channels", json!([])), ("samplers", json!([]))]);
    fill(&mut reduced, "meshes", &[("primitives", json!([]))]);
    fill(&mut reduced, "scenes", &[("nodes", json!([]))]);
    fill(&mut reduced, "skins", &[("joints", json!([]))]);
    for mesh in list_mut(&mut reduced, "meshes") {
        for primitive in mesh["primitives"].as_array_mut().into_iter().flatten().filter_map(Value::as_object_mut) {
            primitive.entry("attributes").or_insert_with(|| json!({}));
        }
    }
    Reduced { json: reduced.into(), pointing }
}

fn object(value: &Value, keys: &[(&str, Form)]) -> Map<String, Value> {
    let entry = |(key, form): &(&str, Form)| Some(((*key).to_owned(), shaped(value.get(key)?, form)?));
    keys.iter().filter_map(entry).collect()
}

/// `value` in its form; `None` if it is null or stands for none.
fn shaped(value: &Value, form: &Form) -> Option<Value> {
    match (form, value) {
        (_, Value::Null) => None,
        (Number, Value::Number(_)) => whole(value),
        (Text, Value::Number(number)) => Some(number.to_string().into()),
        (Text, other) => other.is_string().then(|| other.clone()),
        (Truth, other) => other.is_boolean().then(|| other.clone()),
        (Numbers, Value::Array(values)) => Some(values.iter().filter_map(whole).collect()),
        (Named, Value::Object(entries)) => {
            Some(Value::Object(entries.iter().filter_map(|(key, value)| Some((key.clone(), whole(value)?))).collect()))
        }
        (Object(keys), Value::Object(_)) => Some(object(value, keys).into()),
        (List(keys), Value::Array(values)) => {
            Some(values.iter().map(|value| Value::Object(object(value, keys))).collect())
        }
        // The wrong kind of value is left to `gltf-json`, whose message names its path.
        (_, other) => Some(other.clone()),
    }
}

/// A number as an integer if it is one; negative ones stand for none, as do nulls.
fn whole(value: &Value) -> Option<Value> {
    match value.as_f64() {
        Some(number) if number < 0.0 => None,
        // Beyond this, floats are no longer exact integers.
        Some(number) if value.is_f64() && number.fract() == 0.0 && number < 9e15 => Some((number as u64).into()),
        _ if value.is_null() => None,
        _ => Some(value.clone()),
    }
}

/// Takes out the channels that move no node; the animations that had some.
fn drop_pointers(root: &mut Map<String, Value>) -> Vec<usize> {
    let mut pointing = Vec::new();
    for (index, animation) in list_mut(root, "animations").enumerate() {
        let Some(channels) = animation.get_mut("channels").and_then(Value::as_array_mut) else { continue };
        let before = channels.len();
        channels.retain(|channel| channel.pointer("/target/node").is_some() && channel.get("sampler").is_some());
        if channels.len() < before {
            pointing.push(index);
        }
        for channel in channels {
            let target = channel["target"].as_object_mut().expect("a channel with a node has a target");
            target.remove("extensions");
            target.entry("path").or_insert_with(|| "".into());
        }
    }
    pointing
}

/// Puts in what the entries of a list lack.
fn fill(root: &mut Map<String, Value>, list: &str, entries: &[(&str, Value)]) {
    for object in list_mut(root, list).filter_map(Value::as_object_mut) {
        for (key, value) in entries {
            object.entry(*key).or_insert_with(|| value.clone());
        }
    }
}

fn list_mut<'a>(root: &'a mut Map<String, Value>, key: &str) -> impl Iterator<Item = &'a mut Value> {
    root.get_mut(key).and_then(Value::as_array_mut).into_iter().flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bare_words_outside_strings_become_null() {
        let text = br#"{ "a": [NaN, -Infinity, Infinity, 1], "NaN": "NaN \" Infinity", "b": "\\" }"#;
        let parsed = parse(text).unwrap().0;
        assert_eq!(parsed, json!({ "a": [null, null, null, 1], "NaN": "NaN \" Infinity", "b": "\\" }));
        assert_eq!(parse(b"{ NaN").unwrap_err(), "key must be a string at line 1 column 3");
    }

    #[test]
    fn bytes_around_the_json_do_not_matter() {
        assert_eq!(parse(b"\xef\xbb\xbf {} \0\0").unwrap().0, json!({}));
        assert_eq!(parse(b"{ \"name\": \"M\xfcller\" }").unwrap().0, json!({ "name": "M\u{fffd}ller" }));
    }

    #[test]
    fn nulls_floats_and_missing_lists_are_mended() {
        let json = json!({
            "asset": { "version": 2.0 },
            "accessors": [{ "count": 12.0, "componentType": 5126.0, "type": "VEC3", "min": [null], "sparse": null }],
            "meshes": [null, { "primitives": [{ "attributes": { "POSITION": 0.0, "NORMAL": null }, "material": -1 }] }],
            "nodes": [{ "children": [1.0, null], "extras": { "huge": 1e300 }, "name": null }],
            "scenes": [{}],
            "textures": "anything",
        });
        let expected = json!({
            "accessors": [{ "componentType": 5126, "count": 12, "type": "VEC3" }],
            "asset": { "version": "2.0" },
            "meshes": [{ "primitives": [] }, { "primitives": [{ "attributes": { "POSITION": 0 } }] }],
            "nodes": [{ "children": [1] }],
            "scenes": [{ "nodes": [] }],
        });
        assert_eq!(reduce(&json).json, expected);
    }

    #[test]
    fn channels_that_move_no_node_are_left_out() {
        let pointer =
            json!({ "sampler": 0, "target": { "path": "pointer", "extensions": { "KHR_animation_pointer": {} } } });
        let node = json!({ "sampler": 0, "target": { "path": "scale", "node": 1 } });
        let json = json!({ "animations": [{ "channels": [node] }, { "channels": [pointer, node] }] });
        let reduced = reduce(&json);
        assert_eq!(reduced.pointing, [1]);
        assert_eq!(reduced.json["animations"][1]["channels"], json!([node]));
    }
}
