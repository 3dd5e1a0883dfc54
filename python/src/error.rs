//! Diagnostics as exceptions of Python.

use mimesh_core::Error;
use mimesh_document::{Diagnostic, Diagnostics, Kind, Location};
use mimesh_markers::IntoDiagnostic;
use pyo3::prelude::*;
use serde_json::{Value, json};

use crate::remedies::in_python;

/// A result whose error is an exception once there is an interpreter at hand.
pub type Outcome<T> = Result<T, Diagnostics>;

/// The exception of `diagnostics`: a class of `mimesh._errors` by their kind, with all of them as its `diagnostics`.
pub fn exception(py: Python<'_>, diagnostics: &Diagnostics) -> PyErr {
    let list = json(diagnostics).to_string();
    let made = py.import("mimesh._errors").and_then(|errors| {
        let message = diagnostics.list.iter().map(|one| in_python(one).to_string()).collect::<Vec<_>>().join("\n");
        errors.getattr("exception_of")?.call1((kind_name(diagnostics.kind()), message, list))
    });
    made.map_or_else(|error| error, PyErr::from_value)
}

/// The exception of an error of a stage or a file.
pub fn exception_of(py: Python<'_>, error: Error) -> PyErr {
    exception(py, &error.into_diagnostic().into())
}

/// The exception of settings or arguments that nobody can work with.
pub fn misuse(py: Python<'_>, message: impl Into<String>, hint: impl Into<String>) -> PyErr {
    exception(py, &Diagnostic::new(Kind::Usage, message).hint(hint).into())
}

/// Diagnostics as a list of JSON, with ways out in the words of Python.
pub fn json(diagnostics: &Diagnostics) -> Value {
    diagnostics.list.iter().map(one_as_json).collect()
}

fn one_as_json(diagnostic: &Diagnostic) -> Value {
    let shown = in_python(diagnostic);
    let mut value = shown.to_json();
    value["kind"] = json!(kind_name(diagnostic.kind));
    value["text"] = json!(shown.to_string());
    if let Some(Location::Span { length, .. }) = &diagnostic.location {
        value["length"] = json!(length);
    }
    value
}

/// The name of a kind in JSON, by which Python finds the class of its exception.
fn kind_name(kind: Kind) -> &'static str {
    match kind {
        Kind::Internal => "internal",
        Kind::Usage => "usage",
        Kind::BadData => "bad_data",
        Kind::MissingInput => "missing_input",
        Kind::CannotWrite => "cannot_write",
        Kind::Busy => "busy",
        Kind::Memory => "memory",
        Kind::BadPipeline => "bad_pipeline",
    }
}

/// What Python raised, in a line.
pub fn words(py: Python<'_>, error: &PyErr) -> String {
    let name = error.get_type(py).name().map(|name| name.to_string()).unwrap_or_default();
    let words = error.value(py).to_string();
    if words.is_empty() { name } else { format!("{name}: {words}") }
}

/// Where Python raised it, in words; empty where nobody knows.
pub fn place(py: Python<'_>, error: &PyErr) -> String {
    // Only so does the value have its traceback.
    let value = error.clone_ref(py).into_value(py);
    let place = py.import("mimesh._errors").and_then(|errors| errors.getattr("place_of")?.call1((value,))?.extract());
    place.unwrap_or_default()
}
