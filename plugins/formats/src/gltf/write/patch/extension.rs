//! Extensions taken out of the JSON.

use serde_json::{Map, Value};

/// Takes an extension out of an object; the list of extensions too if none is left.
pub fn remove_extension(object: &mut Map<String, Value>, name: &str) {
    let Some(extensions) = object.get_mut("extensions").and_then(Value::as_object_mut) else { return };
    if extensions.shift_remove(name).is_some() && extensions.is_empty() {
        object.shift_remove("extensions");
    }
}

/// Takes an extension out of the lists of those in use.
pub fn forget_extension(root: &mut Map<String, Value>, name: &str) {
    for key in ["extensionsUsed", "extensionsRequired"] {
        let Some(names) = root.get_mut(key).and_then(Value::as_array_mut) else { continue };
        names.retain(|other| other != name);
        if names.is_empty() {
            root.shift_remove(key);
        }
    }
}
