//! Names of runs from what differs between them, fit for the names of files.

use serde_json::Value;

use crate::placeholder::{MAX_NAME, is_refused, is_reserved};

/// Longer texts are cut in names.
const MAX_LENGTH: usize = 40;

/// Why `name` cannot be a part of a file's name as it stands.
pub(super) fn refused(name: &str) -> Option<String> {
    if name.is_empty() {
        return Some("it is empty".into());
    }
    if name.starts_with('.') {
        return Some("it begins with a dot".into());
    }
    if is_reserved(name) {
        return Some("Windows keeps this name for itself".into());
    }
    if name.len() > MAX_NAME {
        return Some(format!("it has {} bytes, and file systems take {MAX_NAME}", name.len()));
    }
    let refused = name.chars().find(|c| is_refused(*c) || "{}".contains(*c))?;
    Some(format!("it has `{}`", refused.escape_default()))
}

/// Short names for paths of keys: the last key of each, with as many before it as it takes to tell them apart.
pub fn short(keys: &[String]) -> Vec<String> {
    let ends = |key: &String| -> Vec<String> {
        let parts: Vec<&str> = key.split('.').collect();
        (0..parts.len()).rev().map(|from| parts[from..].join(".")).collect()
    };
    let all: Vec<Vec<String>> = keys.iter().map(ends).collect();
    let alone = |i: usize, end: &String| all.iter().enumerate().all(|(j, other)| i == j || !other.contains(end));
    let one = |(i, ends): (usize, &Vec<String>)| file_safe(ends.iter().find(|end| alone(i, end)).unwrap_or(&keys[i]));
    all.iter().enumerate().map(one).collect()
}

/// Names for the values of one key: the value where it is short and plain, the type of a stage, else its number from 1.
pub(super) fn of_values(values: &[Value]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for (i, value) in values.iter().enumerate() {
        let name = match value {
            Value::Null => "none".into(),
            Value::Bool(_) | Value::Number(_) => value.to_string(),
            Value::String(text) => file_safe(text),
            Value::Object(map) => map.get("type").and_then(Value::as_str).map(file_safe).unwrap_or_default(),
            Value::Array(_) => String::new(),
        };
        let number = (i + 1).to_string();
        names.push(match name {
            name if name.is_empty() => number,
            name if names.contains(&name) => format!("{name}-{number}"),
            name => name,
        });
    }
    names
}

/// `text` in characters that every file system takes.
fn file_safe(text: &str) -> String {
    let safe = |c: char| if c.is_alphanumeric() || "._+-".contains(c) { c } else { '-' };
    let safe: String = text.chars().map(safe).take(MAX_LENGTH).collect();
    safe.trim_matches(|c| c == '.' || c == '-').to_owned()
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn keys_are_as_short_as_they_can_be_told_apart() {
        let names = |keys: &[&str]| short(&keys.iter().map(|key| key.to_string()).collect::<Vec<_>>());
        assert_eq!(names(&["transfer.deformer.lambda", "correspondence.sampling"]), ["lambda", "sampling"]);
        assert_eq!(names(&["transfer.type", "correspondence.type"]), ["transfer.type", "correspondence.type"]);
        assert_eq!(names(&["transfer", "a.transfer"]), ["transfer", "a.transfer"]);
        assert_eq!(names(&["shapes.rename.a/../b"]), ["b"]);
        assert_eq!(names(&["shapes.rename.x\\y/z"]), ["x-y-z"]);
    }

    #[test]
    fn values_become_names_that_differ() {
        let values = [json!(0.1), json!(5), json!("a/b: c"), json!({ "type": "x" }), json!({ "type": "x", "k": 1 })];
        assert_eq!(of_values(&values), ["0.1", "5", "a-b--c", "x", "x-5"]);
        assert_eq!(of_values(&[json!([1]), json!(null), json!(true)]), ["1", "none", "true"]);
        assert_eq!(of_values(&[json!("../a.obj"), json!("..")]), ["a.obj", "2"]);
    }

    #[test]
    fn names_that_no_file_can_have_are_refused() {
        assert_eq!(
            ["camel", "", ".x", "a/b", "größe", "CON", "..", "a\\b", "a\0", "\u{202e}a"]
                .map(|name| refused(name).is_some()),
            [false, true, true, true, false, true, true, true, true, true]
        );
    }
}
