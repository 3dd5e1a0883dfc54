//! Placeholders in braces that need no quotes: `[out/{pose}.obj, ${all}]`.
//!
//! YAML takes `{` within a sequence for the beginning of a mapping. While a text passes through the YAML parser, a private
//! character stands for each brace of a placeholder, so that columns stay as they are.

use serde_json::Value;

/// What stands for the braces of `{pose}` while it passes through YAML: a private character for each, so that columns stay.
const GUARDS: [char; 2] = ['\u{e000}', '\u{e001}'];

/// `text` in which `{pose}` and `${name}` are no YAML maps, so that they need no quotes: `[out/{pose}.obj, ${all}]`.
pub fn guarded(text: &str) -> String {
    const PLACEHOLDERS: [&str; 4] = ["pose", "target", "matrix", "name"];
    let mut result = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(open) = rest.find('{') {
        let (before, from) = rest.split_at(open);
        result += before;
        let inside = from[1..].split_once('}').map(|(inside, _)| inside);
        let named = |c: char| c.is_alphanumeric() || "_-:.".contains(c);
        let stands = |inside: &str| match before.ends_with('$') {
            true => inside.chars().all(named),
            false => PLACEHOLDERS.contains(&inside),
        };
        match inside.filter(|inside| stands(inside)) {
            Some(inside) => {
                result.push(GUARDS[0]);
                result += inside;
                result.push(GUARDS[1]);
                rest = &from[inside.len() + 2..];
            }
            None => {
                result.push('{');
                rest = &from[1..];
            }
        }
    }
    result + rest
}

/// `text` with its braces as they were written.
pub fn restored(text: &str) -> String {
    text.replace(GUARDS[0], "{").replace(GUARDS[1], "}")
}

/// `value` with the braces of its texts as they were written.
pub fn unguarded(value: Value) -> Value {
    match value {
        Value::String(text) => Value::String(restored(&text)),
        Value::Array(list) => Value::Array(list.into_iter().map(unguarded).collect()),
        Value::Object(map) => {
            Value::Object(map.into_iter().map(|(key, value)| (restored(&key), unguarded(value))).collect())
        }
        other => other,
    }
}
