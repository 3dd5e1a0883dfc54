//! Whole files that are written together.

use std::path::Path;

use mimesh_document::Diagnostic;

use super::{Transaction, WrittenFile};

/// Files that were written together.
#[derive(Debug)]
pub struct Written {
    /// The files.
    pub files: Vec<WrittenFile>,
    /// Sentences about what others had left there.
    pub warnings: Vec<String>,
}

/// Writes whole files together.
///
/// # Errors
///
/// Those of the system about one of the places.
pub fn write_all(files: &[(&Path, &[u8])]) -> Result<Written, Diagnostic> {
    let transaction = Transaction::begin(files.iter().map(|(place, _)| *place))?;
    let staged = files.iter().map(|(place, bytes)| transaction.stage_bytes(place, bytes)).collect::<Result<_, _>>()?;
    let warnings = transaction.warnings().to_vec();
    Ok(Written { files: transaction.commit(staged)?, warnings })
}
