//! Serialising what is shared.

use std::sync::Arc;

use serde::{Serialize, Serializer};

/// Serialises what is shared as what it is.
///
/// # Errors
///
/// Those of the serialiser.
pub fn serialize<T: Serialize, S: Serializer>(value: &Arc<T>, serializer: S) -> Result<S::Ok, S::Error> {
    (**value).serialize(serializer)
}
