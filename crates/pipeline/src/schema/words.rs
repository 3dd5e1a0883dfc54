//! Ranges and choices of a schema, in words.

use serde_json::Value;

/// The words and one-key mappings that a schema lets a value be, if it is one of several.
pub fn choices(schema: &Value) -> Vec<String> {
    described_choices(schema).into_iter().map(|(choice, _)| choice).collect()
}

/// The [`choices`] with their descriptions, which may be empty; a mapping of one key is shown as `{ key: … }`.
pub fn described_choices(schema: &Value) -> Vec<(String, String)> {
    let list = |key: &str| schema.get(key).and_then(Value::as_array).into_iter().flatten();
    let plain = list("enum").filter_map(Value::as_str).map(|word| (word.to_owned(), String::new()));
    // A value that may be other than these, e.g. any path, is no choice.
    let described: Option<Vec<_>> = list("oneOf").map(described_choice).collect();
    plain.chain(described.unwrap_or_default()).collect()
}

fn described_choice(schema: &Value) -> Option<(String, String)> {
    let word = schema.get("const").and_then(Value::as_str).map(str::to_owned);
    let key = || {
        let mut keys = schema.get("properties")?.as_object()?.keys();
        keys.next().filter(|_| keys.next().is_none())
    };
    let choice = match word {
        Some(word) => word,
        None => format!("{{ {}: … }}", key()?),
    };
    let description = schema.get("description").and_then(Value::as_str).unwrap_or_default();
    Some((choice, description.replace('\n', " ")))
}

/// The range that a schema gives a number, in words, e.g. `0 to 1`.
pub fn range(schema: &Value) -> Option<String> {
    let limit = |key: &str| schema.get(key).and_then(Value::as_f64);
    let low = limit("minimum").map(|min| (min, "at least")).or(limit("exclusiveMinimum").map(|min| (min, "more than")));
    let high = limit("maximum").map(|max| (max, "at most")).or(limit("exclusiveMaximum").map(|max| (max, "less than")));
    match (low, high) {
        (Some((low, "at least")), Some((high, "at most"))) => Some(format!("{low} to {high}")),
        (Some((low, low_word)), Some((high, high_word))) => Some(format!("{low_word} {low} and {high_word} {high}")),
        (Some((limit, word)), None) | (None, Some((limit, word))) => Some(format!("{word} {limit}")),
        (None, None) => None,
    }
}

/// The range in words, if `number` is outside.
pub(super) fn violated_range(schema: &Value, number: f64) -> Option<String> {
    let limit = |key: &str| schema.get(key).and_then(Value::as_f64);
    let inside = limit("minimum").is_none_or(|min| number >= min)
        && limit("maximum").is_none_or(|max| number <= max)
        && limit("exclusiveMinimum").is_none_or(|above| number > above)
        && limit("exclusiveMaximum").is_none_or(|below| number < below);
    if inside { None } else { range(schema) }
}
