//! From values of a document to typed values, with all that is wrong at once.
//!
//! When a value cannot be deserialised, the offending part is noted and taken out of a copy, and the rest is tried again,
//! so that a second mistake in it is found as well.

use serde::de::DeserializeOwned;
use serde_json::Value;
use serde_path_to_error::Segment;

use crate::{
    diagnostic::{Diagnostic, Diagnostics, SHOW_SETTINGS},
    document::{At, Document},
    serde_errors::rephrase,
    shapes::Shapes,
    step::Step,
};

/// Mistakes of one value that are looked for: more are of one kind.
const MAX_MISTAKES: usize = 100;

/// Deserialises the value at `path` of `document`; all that is wrong is added to `diagnostics`.
///
/// `None` if there is no value, or nothing of it could be understood. After diagnostics the result is only good to look for more.
pub fn deserialize<T: DeserializeOwned>(
    document: &Document,
    path: &[Step],
    shapes: &dyn Shapes,
    diagnostics: &mut Diagnostics,
) -> Option<T> {
    let mut value = document.get(path)?.clone();
    if value.is_array() && describes_mapping::<T>() {
        // Serde would take a sequence for the fields of a struct in their order.
        diagnostics.push(diagnostic(document, path, shapes, "invalid type: sequence, expected struct"));
        return None;
    }
    let mut removed: Vec<Vec<Step>> = vec![];
    // Each mistake costs another reading of the whole.
    while removed.len() < MAX_MISTAKES {
        let error = match serde_path_to_error::deserialize::<_, T>(&value) {
            Ok(parsed) => return Some(parsed),
            Err(error) => error,
        };
        let inner: Vec<Step> = error.path().iter().filter_map(step).collect();
        let text = error.inner().to_string();
        // Of a part that was taken out the first reason counts, not that it is missing or that its stand-in is wrong.
        let follows = removed.iter().any(|gone| *gone == inner || gone[..gone.len() - 1] == inner[..]);
        if !follows {
            let whole: Vec<Step> = path.iter().chain(&inner).cloned().collect();
            diagnostics.push(diagnostic(document, &whole, shapes, &text));
        }
        let gone = take_out(&mut value, &inner, &removed)?;
        removed.push(gone);
    }
    None
}

/// Whether `T` is read from a mapping: it can be read from an empty one, or misses a key in it.
fn describes_mapping<T: DeserializeOwned>() -> bool {
    match serde_json::from_value::<T>(Value::Object(serde_json::Map::new())) {
        Ok(_) => true,
        Err(error) => error.to_string().starts_with("missing field"),
    }
}

/// The diagnostic at `path` for a message of serde.
fn diagnostic(document: &Document, path: &[Step], shapes: &dyn Shapes, error: &str) -> Diagnostic {
    let root = &document.value;
    let in_type = path.last() == Some(&Step::Key("type".into()));
    let settings = if in_type { &path[..path.len() - 1] } else { path };
    let variants = shapes.variants(root, settings);
    let key = path.iter().rev().find_map(|step| if let Step::Key(key) = step { Some(key.as_str()) } else { None });
    let rephrased = rephrase(error, key.unwrap_or("pipeline"), variants.as_ref(), &shapes.choices(root, path));
    let name = document.get(settings).and_then(|settings| settings.get("type")).and_then(Value::as_str);
    let mut hint = rephrased.hint;
    if rephrased.about_key
        && !rephrased.missing
        && let Some((Step::Key(key), mapping)) = path.split_last()
        && let Some(now) = shapes.renamed(root, mapping, key)
    {
        hint = format!("`{key}` is now called `{now}`");
    }
    // Settings of unknown type fail as a whole; the word to point at is their type.
    let mut at = path.to_vec();
    if error.starts_with("unknown variant") && variants.is_some() && !in_type {
        at.push(Step::Key("type".into()));
    }
    let point = if rephrased.about_key && !rephrased.missing { At::Key } else { At::Value };
    let diagnostic = document.diagnostic(&at, point, rephrased.message);
    match variants {
        Some(variants) if rephrased.missing && hint.is_empty() => {
            let stage = format!("{} {}", variants.kind, name.unwrap_or("TYPE"));
            diagnostic.remedy(SHOW_SETTINGS, stage, "see the settings of this type")
        }
        _ => diagnostic.hint(hint),
    }
}

fn step(segment: &Segment) -> Option<Step> {
    match segment {
        Segment::Seq { index } => Some(Step::Index(*index)),
        Segment::Map { key } => Some(Step::Key(key.clone())),
        Segment::Enum { variant } => Some(Step::Key(variant.clone())),
        Segment::Unknown => None,
    }
}

/// Takes the value at `path` out and gives its path, or that of the value around it which had to go as a whole; `None`
/// if nothing is left.
///
/// In a sequence an empty string takes its place, so that the items behind it keep their numbers.
fn take_out(value: &mut Value, path: &[Step], removed: &[Vec<Step>]) -> Option<Vec<Step>> {
    for end in (1..=path.len()).rev() {
        let path = &path[..end];
        let (last, parents) = path.split_last()?;
        match (parents.iter().try_fold(&mut *value, |value, step| step.get_mut(value))?, last) {
            (Value::Object(map), Step::Key(key)) if map.contains_key(key) => {
                map.shift_remove(key);
                return Some(path.to_vec());
            }
            (Value::Array(list), Step::Index(index)) if !removed.iter().any(|gone| gone == path) => {
                *list.get_mut(*index)? = Value::String(String::new());
                return Some(path.to_vec());
            }
            _ => {}
        }
    }
    None
}
