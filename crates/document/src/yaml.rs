//! YAML texts: their values, and diagnostics for texts that are no YAML.

use std::sync::Arc;

use serde_json::{Map, Value};

use crate::{
    braces::{guarded, unguarded},
    diagnostic::{Diagnostic, Kind, Location},
    source_tree::{SourceSpan, SourceText, Span},
};

/// The value of a YAML text, with aliases and merge keys resolved.
///
/// # Errors
///
/// If it is no YAML.
pub fn yaml_value(text: &str) -> Result<Value, serde_saphyr::Error> {
    let options = serde_saphyr::options! { strict_booleans: true, with_snippet: false };
    Ok(unguarded(serde_saphyr::from_str_with_options::<Value>(&guarded(text), options)?))
}

/// The diagnostic of a text that is no YAML, in words of someone who writes it and with a way out that fits.
pub fn not_yaml(text: &Arc<SourceText>, error: serde_saphyr::Error) -> Diagnostic {
    let error = error.without_snippet();
    let mut problem = error.to_string();
    let mut location = Location::File(text.file.clone());
    if let Some(at) = error.location().filter(|at| at.line() > 0) {
        let (line, column) = (at.line() as usize, at.column() as usize);
        if let Some(end) = problem.find(&format!(" at line {line}, column {column}")) {
            problem.truncate(end);
        }
        location = SourceSpan::Text(text.clone(), Span { line, column: column.max(1) - 1, length: 1 }).location();
    }
    let (message, hint) = if let Some(rest) = problem.strip_prefix("duplicate mapping key: ") {
        let key = rest.split(',').next().unwrap_or(rest);
        (format!("the key `{key}` stands here a second time"), "remove one of the two")
    } else if problem.starts_with("multiple YAML documents") {
        ("a second document begins here".into(), "remove the line `---` and what follows it; a file holds one document")
    } else if problem.contains("tab") {
        (problem, "indent with blanks")
    } else if problem.contains("unknown anchor") {
        (
            "`*` at the beginning of a value refers to an anchor, and there is none of this name".into(),
            "put a glob that begins with `*` in quotes: `\"*.obj\"`",
        )
    } else {
        (problem, "a text with `:`, `#` or `{…}` in it needs quotes, and lines of one map the same indentation")
    };
    Diagnostic::new(Kind::BadPipeline, format!("not valid YAML: {message}")).at(location).hint(hint)
}

/// `value` with the key `type` first in every map, so that typetag needs no buffer and errors keep their path.
pub fn type_first(value: Value) -> Value {
    match value {
        Value::Object(mut map) => {
            let tag = map.shift_remove("type").map(|tag| ("type".to_owned(), tag));
            let others = map.into_iter().map(|(key, value)| (key, type_first(value)));
            Value::Object(tag.into_iter().chain(others).collect::<Map<_, _>>())
        }
        Value::Array(list) => Value::Array(list.into_iter().map(type_first).collect()),
        other => other,
    }
}
