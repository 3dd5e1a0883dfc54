//! YAML texts: their values, and diagnostics for texts that are no YAML.

use std::sync::Arc;

use serde_json::{Map, Value};

use crate::{
    braces::{guarded, unguarded},
    diagnostic::{Diagnostic, Kind, Location},
    finite::{Finite, NOT_FINITE, is_about_finiteness},
    limits::{MAX_YAML_BYTES, MAX_YAML_DEPTH, MAX_YAML_VALUES, thousands},
    source_tree::{SourceSpan, SourceText, Span},
};

/// The value of a YAML text, with aliases and merge keys resolved.
///
/// # Errors
///
/// If it is no YAML.
pub fn yaml_value(text: &str) -> Result<Value, serde_saphyr::Error> {
    let options = serde_saphyr::options! {
        strict_booleans: true,
        with_snippet: false,
        budget: serde_saphyr::budget! {
            max_nodes: MAX_YAML_VALUES,
            max_depth: MAX_YAML_DEPTH,
            max_merge_keys: MAX_YAML_VALUES,
            enforce_alias_anchor_ratio: false,
        },
        alias_limits: serde_saphyr::alias_limits! { max_total_replayed_events: MAX_YAML_VALUES },
    };
    Ok(unguarded(serde_saphyr::from_str_with_options::<Finite>(&guarded(text), options)?.0))
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
    if let Some((message, hint)) = beyond_limits(&problem) {
        return Diagnostic::new(Kind::BadPipeline, message).at(location).hint(hint);
    }
    let (message, hint) = if let Some(rest) = problem.strip_prefix("duplicate mapping key: ") {
        let key = rest.split(',').next().unwrap_or(rest);
        (format!("the key `{key}` stands here a second time"), "remove one of the two")
    } else if problem.contains("recursive references") {
        ("an alias stands within the value that it repeats".into(), "take the alias out of the value")
    } else if problem.starts_with("multiple YAML documents") {
        ("a second document begins here".into(), "remove the line `---` and what follows it; a file holds one document")
    } else if is_about_finiteness(&problem) {
        (NOT_FINITE.into(), "write a number below 1e308, or leave the key out")
    } else if problem.contains("cannot deserialize null into string") {
        ("a key is empty".into(), "write the name of the key before the `:`")
    } else if problem.contains("simple key expected") {
        ("there is no `:` after a key, or the key has more than 1,024 characters".into(), "write `key: value`")
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

/// The diagnostic of a text that is too long to be a YAML file; `None` if it is not.
pub fn too_long(file: &std::path::Path, text: &str) -> Option<Diagnostic> {
    if text.len() <= MAX_YAML_BYTES {
        return None;
    }
    let (found, limit) = (thousands(text.len()), thousands(MAX_YAML_BYTES));
    let message = format!("the file has {found} bytes, and a YAML file {limit} at most");
    let diagnostic = Diagnostic::new(Kind::BadPipeline, message).at(Location::File(file.into()));
    Some(diagnostic.hint("is it the file that is meant? long lists of files are written as a glob, e.g. `pose-*.obj`"))
}

/// What is told of a text that asks for more than a file may, and the way out.
///
/// The parser wraps these errors where aliases are replayed, so that its words alone tell them.
fn beyond_limits(problem: &str) -> Option<(String, &'static str)> {
    const SHORTER: &str = "write less into one file; long lists of files are written as a glob, e.g. `pose-*.obj`";
    const FEWER: &str = "use fewer aliases (`*name`), or aliases of smaller values";
    let has = |words: &str| problem.contains(words);
    Some(if has("recursion limit exceeded") || has("budget breached: Depth") {
        let message = format!("mappings and sequences stand within each other more than {MAX_YAML_DEPTH} deep");
        (message, "take out the outer ones")
    } else if has("alias replay") || has("alias expansion") || has("budget breached: RecordedAnchor") {
        (format!("aliases repeat more than {} values", thousands(MAX_YAML_VALUES)), FEWER)
    } else if has("budget breached") {
        (format!("the file has more than {} values", thousands(MAX_YAML_VALUES)), SHORTER)
    } else {
        return None;
    })
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
