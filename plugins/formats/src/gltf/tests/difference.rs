//! The places in which two JSON texts differ.

use serde_json::Value;

/// One line a difference, with its JSON pointer; new entries at the end of a list are counted.
///
/// # Panics
///
/// If keys that both have stand in another order.
pub fn differences(before: &Value, after: &Value) -> Vec<String> {
    let mut found = Vec::new();
    compare("", before, after, &mut found);
    found
}

fn compare(at: &str, before: &Value, after: &Value, found: &mut Vec<String>) {
    match (before, after) {
        (Value::Object(old), Value::Object(new)) => {
            let kept: Vec<_> = old.keys().filter(|key| new.contains_key(*key)).collect();
            let in_order: Vec<_> = new.keys().filter(|key| old.contains_key(*key)).collect();
            assert_eq!(kept, in_order, "{at}: keys in another order");
            for (key, value) in old {
                match new.get(key) {
                    Some(other) => compare(&format!("{at}/{key}"), value, other, found),
                    None => found.push(format!("{at}/{key}: removed")),
                }
            }
            found.extend(new.keys().filter(|key| !old.contains_key(*key)).map(|key| format!("{at}/{key}: new")));
        }
        (Value::Array(old), Value::Array(new)) => {
            for (index, (old, new)) in old.iter().zip(new).enumerate() {
                compare(&format!("{at}/{index}"), old, new, found);
            }
            match new.len() as i64 - old.len() as i64 {
                0 => {}
                added => found.push(format!("{at}: {added:+}")),
            }
        }
        _ if before == after => {}
        _ => found.push(format!("{at}: changed")),
    }
}
