//! Checking what the text of a pipeline shows alone.

use std::path::PathBuf;

use mimesh_document::{Document, diagnostic::Result};

use super::{
    common::{Options, check_formats, check_registry},
    findings::{Findings, Scope},
    run_diagnostics::RunDiagnostics,
    stages::check_files,
};
use crate::{
    compose::{self, Runs},
    formats::Formats,
    parse::{Parsed, Required, parse},
    schema::resolve_files,
};

/// Checks the text of the pipeline in `document`, with the files that it `included`: keys, types, ranges, variables, names of stages, and
/// files that settings name. It reads no mesh, so it takes a moment; a whole check finds all of this, too.
///
/// # Errors
///
/// All that is wrong with the text, each once.
pub fn check_text(document: Document, included: Vec<PathBuf>, options: &Options) -> Result<()> {
    let file = document.file.clone();
    let Runs { runs, diagnostics, suppressed, .. } = compose::compose_document(document, included, &options.settings)?;
    let mut collected = RunDiagnostics::new(&runs, diagnostics, suppressed);
    for (i, run) in runs.into_iter().enumerate() {
        let mut document = run.document;
        let files = resolve_files(&mut document);
        let mut found = Findings::default();
        let Parsed { mut pipeline, rejected, .. } = parse(&document, Required::Run, &mut found.diagnostics);
        let formats = Formats::new(std::mem::take(&mut pipeline.formats), options.reach(&file));
        let scope = Scope { document: &document, formats: &formats, rejected: &rejected };
        check_registry(&mut found);
        check_formats(scope, &mut found);
        check_files(scope, &mut found, &files);
        if let Err(diagnostics) = found.diagnostics.into_result() {
            collected.add(i, diagnostics);
        }
    }
    collected.finish(&file)
}
