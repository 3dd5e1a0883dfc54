//! The command line of mimesh, in an interpreter of Python.

use std::{
    ffi::OsString,
    path::Path,
    sync::{Mutex, PoisonError},
};

use mimesh::cli::{Host, run};
use mimesh_document::{Diagnostic, Kind, Location, diagnostic::Result, files::hash_file};
use pyo3::prelude::*;

use crate::error::{place, words};

/// The file of this module, once Python has said it.
static MODULE: Mutex<Option<String>> = Mutex::new(None);

/// Says which file this module was loaded from, and gives its hash.
#[pyfunction]
pub fn set_identity(file: &str) {
    *MODULE.lock().unwrap_or_else(PoisonError::into_inner) = Some(file.to_owned());
}

/// Runs the command line and gives its exit status; the first argument is the name of the program.
#[pyfunction]
pub fn main(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    let host = Host { arguments, load_python: Some(load), identity: Some(identity) };
    py.detach(|| run(&host))
}

/// Loads a file of stages.
fn load(file: &Path) -> Result<()> {
    Python::attach(|py| {
        let loaded = py.import("mimesh._stages").and_then(|stages| stages.getattr("load_file")?.call1((file,)));
        loaded.map(drop).map_err(|error| {
            let kind = if file.exists() { Kind::BadData } else { Kind::MissingInput };
            let diagnostic = Diagnostic::new(kind, words(py, &error)).hint(place(py, &error));
            diagnostic.at(Location::Argument(format!("--python {}", file.display()))).into()
        })
    })
}

/// The identity of the program for the cache: the hashes of this module and of the sources of stages that are written in Python.
pub fn identity() -> Result<String> {
    let wrong = |error: String| Diagnostic::new(Kind::Internal, format!("the package has no identity: {error}"));
    let module = MODULE.lock().unwrap_or_else(PoisonError::into_inner).clone();
    let module = module.ok_or_else(|| wrong("its module has no file".into()))?;
    let own = hash_file(Path::new(&module)).map_err(|error| wrong(error.to_string()))?;
    let sources = Python::attach(|py| {
        let stages = py.import("mimesh._stages")?;
        stages.getattr("sources_hash")?.call0()?.extract::<String>()
    });
    Ok(format!("{own} {}", sources.map_err(|error| wrong(error.to_string()))?))
}
