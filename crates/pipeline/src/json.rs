//! Plain data as JSON.

use std::path::Path;

use serde::{Serialize, Serializer};
use serde_json::Value;

/// `data` as a JSON value.
///
/// # Panics
///
/// If `data` has mappings whose keys are no strings, which no settings and no report have.
pub fn to_value<T: Serialize + ?Sized>(data: &T) -> Value {
    serde_json::to_value(data).expect("settings and reports serialise to JSON")
}

/// `data` as the bytes of a JSON text.
///
/// # Panics
///
/// As [`to_value`].
pub fn to_bytes<T: Serialize + ?Sized>(data: &T) -> Vec<u8> {
    serde_json::to_vec(data).expect("settings and reports serialise to JSON")
}

/// A path as a text of JSON, with a mark in place of what is no Unicode.
///
/// # Errors
///
/// Those of the serialiser.
pub fn path<S: Serializer>(path: &Path, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(&path.to_string_lossy())
}
