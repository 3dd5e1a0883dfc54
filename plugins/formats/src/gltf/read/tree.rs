//! JSON as a tree, with the keys that stand twice in one object.

use std::{cell::RefCell, fmt};

use serde::de::{DeserializeSeed, Deserializer, MapAccess, SeqAccess, Visitor};
use serde_json::{Map, Number, Value};

/// No more keys are told.
const MAX_TOLD: usize = 100;

/// Parses a text; of a key that stands twice in one object the last value counts.
///
/// # Errors
///
/// The parser's.
pub fn parse(text: &str) -> serde_json::Result<(Value, Vec<String>)> {
    let doubles = RefCell::default();
    let mut parser = serde_json::Deserializer::from_str(text);
    let value = Tree(&doubles).deserialize(&mut parser)?;
    parser.end()?;
    Ok((value, doubles.into_inner()))
}

/// Makes a tree, and takes down the keys that stand twice.
#[derive(Clone, Copy)]
struct Tree<'a>(&'a RefCell<Vec<String>>);

impl<'de> DeserializeSeed<'de> for Tree<'_> {
    type Value = Value;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Value, D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Tree<'_> {
    type Value = Value;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a JSON value")
    }

    fn visit_unit<E>(self) -> Result<Value, E> {
        Ok(Value::Null)
    }

    fn visit_bool<E>(self, value: bool) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_i64<E>(self, value: i64) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_u64<E>(self, value: u64) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_f64<E>(self, value: f64) -> Result<Value, E> {
        Ok(Number::from_f64(value).map_or(Value::Null, Value::Number))
    }

    fn visit_str<E>(self, value: &str) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_string<E>(self, value: String) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Value, A::Error> {
        let mut values = Vec::new();
        while let Some(value) = items.next_element_seed(self)? {
            values.push(value);
        }
        Ok(values.into())
    }

    fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<Value, A::Error> {
        let mut object = Map::new();
        while let Some(key) = entries.next_key::<String>()? {
            let value = entries.next_value_seed(self)?;
            let mut doubles = self.0.borrow_mut();
            if object.contains_key(&key) && doubles.len() < MAX_TOLD {
                doubles.push(key.clone());
            }
            object.insert(key, value);
        }
        Ok(object.into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_is_parsed_as_by_the_parser_itself() {
        let text = r#"{ "a": [1, -2, 0.1, 1e300, true, null, "\u00e9"], "b": { "c": {} } }"#;
        let (value, doubles) = parse(text).unwrap();
        assert_eq!((value, doubles), (serde_json::from_str(text).unwrap(), vec![]));
        assert_eq!(
            parse("[1, 2").unwrap_err().to_string(),
            serde_json::from_str::<Value>("[1, 2").unwrap_err().to_string()
        );
        assert!(parse("{} {}").is_err());
        assert!(parse(&"[".repeat(100_000)).is_err(), "no deep recursion");
    }
}
