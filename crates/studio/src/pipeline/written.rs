//! Values as YAML that a person might have written.

use serde_json::Value;

/// A value on one line.
pub fn flow(value: &Value) -> String {
    match value {
        Value::Null => "~".into(),
        Value::String(text) => scalar(text),
        Value::Array(list) if list.is_empty() => "[]".into(),
        Value::Array(list) => format!("[{}]", list.iter().map(flow).collect::<Vec<_>>().join(", ")),
        Value::Object(map) if map.is_empty() => "{}".into(),
        Value::Object(map) => {
            let entries = map.iter().map(|(key, value)| format!("{}: {}", scalar(key), flow(value)));
            format!("{{ {} }}", entries.collect::<Vec<_>>().join(", "))
        }
        other => other.to_string(),
    }
}

/// A whole text, a line for each key.
pub fn block(value: &Value) -> String {
    let Value::Object(map) = value else { return flow(value) };
    map.iter().map(|(key, value)| format!("{}: {}\n", scalar(key), flow(value))).collect()
}

/// A text with quotes where YAML would take it for something else.
pub fn scalar(text: &str) -> String {
    let is_plain = text.starts_with(|c: char| c.is_ascii_alphabetic() || "_./".contains(c))
        && text.chars().all(|c| c.is_ascii_alphanumeric() || "_./-".contains(c));
    let is_word = ["true", "false", "null", "yes", "no", "on", "off", "y", "n", ".inf", ".nan"]
        .contains(&text.to_ascii_lowercase().as_str());
    let is_number =
        text.parse::<f64>().is_ok() || text.starts_with('.') && text[1..].starts_with(|c: char| c.is_ascii_digit());
    if is_plain && !is_word && !is_number { text.into() } else { Value::from(text).to_string() }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn what_yaml_takes_for_something_else_has_quotes() {
        let value = json!({ "clip": "Run", "fps": 24, "name": "yes", "files": ["a b", "c.obj"] });
        assert_eq!(flow(&value), "{ clip: Run, fps: 24, name: \"yes\", files: [\"a b\", c.obj] }");
    }
}
