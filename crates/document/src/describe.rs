//! Values in words, for messages.

use serde_json::Value;

/// `value` in words: `nothing`, `the string "x"`, `a sequence`, `a mapping`, a number as it is.
pub fn describe(value: &Value) -> String {
    match value {
        Value::Null => "nothing".into(),
        Value::String(text) if text.is_empty() => "an empty string".into(),
        Value::String(text) => format!("the string \"{text}\""),
        Value::Array(_) => "a sequence".into(),
        Value::Object(_) => "a mapping".into(),
        other => other.to_string(),
    }
}
