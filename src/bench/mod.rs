//! How good every transfer method is where the answer is known: on built-in samples, and on folders of meshes.
//!
//! A [`Case`] is a source with poses, a target with known results and markers; a [`Method`] the stages of a pipeline.
//! Every pair of them becomes a pipeline in YAML, which anyone can run again, and is run as `mimesh run` would.

mod cases;
mod methods;
mod table;

use std::{
    fs,
    path::{Path, PathBuf},
};

pub use self::{
    cases::{Case, folder, samples},
    methods::{METHODS, Method, Targets},
    table::{csv, markdown, rows},
};
use crate::{
    diagnostic::{Diagnostic, Kind, Location, Result},
    pipeline::{self, Options, Report, Watch, staging},
};

/// What came of a method on a case.
#[derive(Debug)]
pub struct Entry {
    /// Name of the case.
    pub case: String,
    /// Name of the method.
    pub method: &'static str,
    /// The pipeline.
    pub pipeline: PathBuf,
    /// What it did, or why it failed.
    pub ended: std::result::Result<Box<Report>, Vec<Diagnostic>>,
    /// Poses that failed on their own, of which the figures know nothing.
    pub failed: Vec<Diagnostic>,
}

/// What begins every file that is written here, so that no other is replaced.
const MARK: &str = "# Written by `mimesh bench-quality`: ";

/// Runs `method` on `case`, with pipeline and results in `folder`.
///
/// # Errors
///
/// If the pipeline cannot be written; that it fails is in the result.
pub fn run(case: &Case, method: &Method, folder: &Path, threads: usize, watch: &dyn Watch) -> Result<Entry> {
    let name = format!("{}-{}", case.name, method.name);
    let file = folder.join(format!("{name}.yaml"));
    let markers = case.marker_file().map(|(name, text)| (folder.join(name), text));
    if file.exists() && !fs::read_to_string(&file).is_ok_and(|text| text.starts_with(MARK)) {
        let message = "there is a file of that name that `bench-quality` has not written";
        let diagnostic = Diagnostic::new(Kind::CannotWrite, message).at(Location::File(file));
        return Err(diagnostic.hint("name another folder with `--out`").into());
    }
    let mut staged = Vec::new();
    for (path, text) in markers.into_iter().chain([(file.clone(), case.pipeline(method, &name))]) {
        staged.push(staging::stage_bytes(&path, text.as_bytes())?);
    }
    staging::commit(staged)?;
    // Times are to be those of the work, so nothing is taken from a cache.
    let ended = pipeline::prepare(&file, &Options::default())
        .and_then(|prepared| pipeline::run(&prepared, &[], threads, None, watch))
        .map_err(|failure| failure.diagnostics);
    let (ended, failed) = match ended {
        Ok(outcome) => (Ok(Box::new(outcome.report)), outcome.failed),
        Err(diagnostics) => (Err(diagnostics), vec![]),
    };
    Ok(Entry { case: case.name.clone(), method: method.name, pipeline: file, ended, failed })
}
