//! Ranges of numbers, which the JSON Schema of settings declares: `#[schemars(range(min = 0.0))]`.

use std::{
    any::TypeId,
    collections::HashMap,
    sync::{LazyLock, Mutex, PoisonError},
};

use schemars::{JsonSchema, generate::SchemaSettings};
use serde::Serialize;
use serde_json::Value;

use super::slot::stage_of;
use crate::{Error, Result};

/// Checks every number of `settings` against the range that its schema declares, for callers from Rust; a pipeline has checked
/// them before. Stages that are nested in `settings` check themselves when they are bound.
///
/// # Errors
///
/// [`Error::Setting`] for the first number that is out of its range or not finite. It names the key as YAML does, with those that
/// lead to it, e.g. `term_weights.gaps` or `closest[0]`.
pub fn check_ranges<T: Serialize + JsonSchema + 'static>(settings: &T) -> Result<()> {
    let values = serde_json::to_value(settings).map_err(|error| Error::Other(error.into()))?;
    check_values(inlined::<T>(), &values)
}

/// Like [`check_ranges`], of settings as JSON whose schema has no references.
///
/// # Errors
///
/// Those of [`check_ranges`].
pub fn check_values(schema: &Value, settings: &Value) -> Result<()> {
    check("", schema, settings)
}

/// The schema of `T` without references. Those of the stages that may be nested in it make it large, so each is made once.
fn inlined<T: JsonSchema + 'static>() -> &'static Value {
    static SCHEMAS: LazyLock<Mutex<HashMap<TypeId, &'static Value>>> = LazyLock::new(Mutex::default);
    // A panic elsewhere leaves the map as it was or with one schema more.
    let mut schemas = SCHEMAS.lock().unwrap_or_else(PoisonError::into_inner);
    schemas.entry(TypeId::of::<T>()).or_insert_with(|| {
        let inlining = SchemaSettings::draft2020_12().with(|settings| settings.inline_subschemas = true);
        Box::leak(Box::new(T::json_schema(&mut inlining.into_generator()).to_value()))
    })
}

/// Checks the numbers at and below the setting `name`; the settings as a whole have an empty name.
fn check(name: &str, schema: &Value, value: &Value) -> Result<()> {
    if stage_of(schema).is_some() {
        return Ok(());
    }
    for alternatives in ["anyOf", "oneOf"].iter().filter_map(|key| schema.get(key)?.as_array()) {
        let results = alternatives.iter().filter(|one| fits(one, value)).map(|one| check(name, one, value));
        let results: Vec<_> = results.collect();
        if !results.iter().any(Result::is_ok) {
            results.into_iter().next().unwrap_or(Ok(()))?;
        }
    }
    match value {
        Value::Number(number) => match number.as_f64().filter(|number| !is_inside(schema, *number)) {
            Some(found) => Err(out_of_range(name, schema, found.to_string())),
            None => Ok(()),
        },
        // JSON has no other numbers, so that these are written as `null`.
        Value::Null if schema.get("type").is_some_and(|kind| kind == "number") => {
            Err(out_of_range(name, schema, "NaN or infinity".into()))
        }
        Value::Object(values) => {
            let properties = schema.get("properties").and_then(Value::as_object).into_iter().flatten();
            properties.filter_map(|(key, schema)| Some((key, schema, values.get(key)?))).try_for_each(
                |(key, schema, value)| match name {
                    "" => check(key, schema, value),
                    _ => check(&format!("{name}.{key}"), schema, value),
                },
            )
        }
        Value::Array(values) => {
            let Some(items) = schema.get("items") else { return Ok(()) };
            values.iter().enumerate().try_for_each(|(i, value)| check(&format!("{name}[{i}]"), items, value))
        }
        _ => Ok(()),
    }
}

/// Whether `value` is of the kind that `schema`, one of several alternatives, is for.
fn fits(schema: &Value, value: &Value) -> bool {
    if let Some(constant) = schema.get("const") {
        return constant == value;
    }
    let kinds: &[&str] = match value {
        Value::Null => &["null"],
        Value::Bool(_) => &["boolean"],
        Value::Number(_) => &["number", "integer"],
        Value::String(_) => &["string"],
        Value::Array(_) => &["array"],
        Value::Object(_) => &["object"],
    };
    let is_kind = |kind: &Value| kind.as_str().is_some_and(|kind| kinds.contains(&kind));
    let of_kind = match schema.get("type") {
        Some(Value::Array(several)) => several.iter().any(is_kind),
        Some(kind) => is_kind(kind),
        None => true,
    };
    let has_key = |(key, value): (&String, &Value)| {
        let property = schema.get("properties").and_then(|properties| properties.get(key));
        property.is_some_and(|property| property.get("const").is_none_or(|constant| constant == value))
    };
    of_kind && value.as_object().is_none_or(|values| values.iter().all(has_key))
}

fn out_of_range(name: &str, schema: &Value, found: String) -> Error {
    let expected = range(schema).unwrap_or_else(|| "a finite number".into());
    Error::Setting { setting: name.to_owned().into(), expected, found }
}

/// Whether `number` lies in the range of `schema`; any number does where it declares none.
pub fn is_inside(schema: &Value, number: f64) -> bool {
    let limit = |key: &str| schema.get(key).and_then(Value::as_f64);
    limit("minimum").is_none_or(|min| number >= min)
        && limit("maximum").is_none_or(|max| number <= max)
        && limit("exclusiveMinimum").is_none_or(|above| number > above)
        && limit("exclusiveMaximum").is_none_or(|below| number < below)
}

/// The range that `schema` declares for a number, in words, e.g. `0 to 1` or `at least 1`; `None` if it declares none.
pub fn range(schema: &Value) -> Option<String> {
    let limit = |key: &str, word| schema.get(key).and_then(Value::as_f64).map(|limit| (limit, word));
    let low = limit("minimum", "at least").or(limit("exclusiveMinimum", "more than"));
    let high = limit("maximum", "at most").or(limit("exclusiveMaximum", "less than"));
    match (low, high) {
        (Some((low, "at least")), Some((high, "at most"))) => Some(format!("{low} to {high}")),
        (Some((low, low_word)), Some((high, high_word))) => Some(format!("{low_word} {low} and {high_word} {high}")),
        (Some((limit, word)), None) | (None, Some((limit, word))) => Some(format!("{word} {limit}")),
        (None, None) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Clone, JsonSchema, Serialize)]
    struct Settings {
        #[schemars(range(min = 0.0, max = 1.0))]
        share: f64,
        #[schemars(range(min = 2))]
        count: usize,
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        size: f64,
        #[schemars(range(max = 9))]
        some: Option<u32>,
        #[schemars(inner(range(min = 0.0)))]
        both: [f64; 2],
        #[serde(rename = "terms")]
        parts: Vec<Part>,
        part: Option<Part>,
        choice: Choice,
        free: f64,
    }

    #[derive(Clone, JsonSchema, Serialize)]
    struct Part {
        #[schemars(range(min = -1.0))]
        weight: f64,
    }

    #[derive(Clone, JsonSchema, Serialize)]
    #[serde(rename_all = "snake_case")]
    enum Choice {
        #[allow(dead_code, reason = "only its schema is looked at")]
        Plain,
        Other(Part),
    }

    fn good() -> Settings {
        let part = Part { weight: 0.0 };
        let (parts, choice) = (vec![part.clone(); 2], Choice::Other(part.clone()));
        let both = [0.0, 5.0];
        Settings { share: 1.0, count: 2, size: 0.1, some: Some(9), both, parts, part: Some(part), choice, free: -3.0 }
    }

    fn refused(change: impl Fn(&mut Settings)) -> String {
        let mut settings = good();
        change(&mut settings);
        check_ranges(&settings).expect_err("out of range").to_string()
    }

    #[test]
    fn numbers_in_their_ranges_pass() {
        check_ranges(&good()).unwrap();
        check_ranges(&Settings { some: None, part: None, choice: Choice::Plain, ..good() }).unwrap();
    }

    #[test]
    fn a_number_out_of_its_range_is_named_as_in_yaml() {
        assert_eq!(refused(|s| s.share = 1.5), "share: expected 0 to 1, found 1.5");
        assert_eq!(refused(|s| s.count = 1), "count: expected at least 2, found 1");
        assert_eq!(refused(|s| s.size = 0.0), "size: expected more than 0, found 0");
        assert_eq!(refused(|s| s.some = Some(10)), "some: expected 0 to 9, found 10");
        assert_eq!(refused(|s| s.both[1] = -2.0), "both[1]: expected at least 0, found -2");
        assert_eq!(refused(|s| s.parts[1].weight = -2.0), "terms[1].weight: expected at least -1, found -2");
        assert_eq!(refused(|s| s.part = Some(Part { weight: -2.0 })), "part.weight: expected at least -1, found -2");
        let choice = refused(|s| s.choice = Choice::Other(Part { weight: -2.0 }));
        assert_eq!(choice, "choice.other.weight: expected at least -1, found -2");
    }

    #[test]
    fn numbers_that_are_not_finite_are_refused_with_a_range_and_without() {
        for number in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(refused(|s| s.share = number), "share: expected 0 to 1, found NaN or infinity");
            assert_eq!(refused(|s| s.both[0] = number), "both[0]: expected at least 0, found NaN or infinity");
            assert_eq!(refused(|s| s.free = number), "free: expected a finite number, found NaN or infinity");
        }
    }
}
