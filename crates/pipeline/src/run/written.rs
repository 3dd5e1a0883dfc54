//! The files of a run beside its meshes: the correspondence, pages, sheets and the report, written to temporary files.

use std::{io, path::Path};

use mimesh_core::{Error, stage::TriangleMap};
use mimesh_document::Diagnostic;
use serde_json::{Value, json};

use crate::{
    input::Prepared,
    json::to_value,
    page,
    pictures::Thumbnails,
    report::Report,
    staging::{Staged, Transaction},
};

/// The correspondence as a file that `from_file` reads.
pub(super) fn correspondence(transaction: &Transaction, path: &Path, map: &TriangleMap) -> Result<Staged, Diagnostic> {
    let mut contents = json!({ "format": "mimesh-correspondence", "version": 1 });
    if let (Value::Object(contents), Value::Object(map)) = (&mut contents, to_value(map)) {
        contents.extend(map);
    }
    transaction.stage(path, |out| writeln!(out, "{contents}").map_err(|error| Error::write(path, error)))
}

/// The pages and sheets of a run.
pub(super) fn visual_outputs(
    transaction: &Transaction,
    prepared: &Prepared,
    report: &Report,
    thumbnails: Thumbnails<'_>,
) -> Result<Vec<Staged>, Diagnostic> {
    let mut staged = Vec::new();
    for path in &prepared.outputs.sheets {
        staged.push(transaction.stage_bytes(path, &thumbnails.sheet())?);
    }
    if !prepared.outputs.pages.is_empty() {
        let page = page::page(report, &thumbnails.pictures(), &prepared.help);
        for path in &prepared.outputs.pages {
            staged.push(transaction.stage_bytes(path, page.as_bytes())?);
        }
    }
    Ok(staged)
}

/// The report as JSON.
pub(super) fn report(transaction: &Transaction, path: &Path, report: &Report) -> Result<Staged, Diagnostic> {
    transaction.stage(path, |out| {
        let written = serde_json::to_writer_pretty(&mut *out, report).map_err(io::Error::from);
        written.and_then(|()| writeln!(out)).map_err(|error| Error::write(path, error))
    })
}
