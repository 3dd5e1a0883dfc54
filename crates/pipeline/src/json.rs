//! Plain data as JSON.

use serde::Serialize;
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
