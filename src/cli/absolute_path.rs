//! Paths for commands that run in another folder.

use std::path::{Path, PathBuf};

use mimesh_document::{Diagnostic, Kind, diagnostic::Result};

/// A path as text, absolute.
///
/// # Errors
///
/// A diagnostic if it is no Unicode, or the folder at hand is gone.
pub fn absolute(path: &Path) -> Result<String> {
    let whole: PathBuf = std::path::absolute(path)
        .map_err(|error| Diagnostic::new(Kind::Usage, format!("{}: no absolute path: {error}", path.display())))?;
    match whole.into_os_string().into_string() {
        Ok(text) => Ok(text),
        Err(path) => {
            let message = format!("`{}`: expected Unicode, since files of jobs are text", path.to_string_lossy());
            Err(Diagnostic::new(Kind::Usage, message).hint("rename it, or reach it by a link with another name").into())
        }
    }
}
