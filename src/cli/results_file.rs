//! The file that `mimesh run --table FILE` writes.

use std::path::Path;

use mimesh_document::{
    diagnostic::{Diagnostic, Kind, Location, Result},
    paths,
};
use mimesh_pipeline::{Prepared, report::Results, staging};

/// The file for the table of results.
pub struct ResultsFile<'a> {
    file: &'a Path,
    /// Formats the table as the file's extension asks for.
    format: fn(&Results) -> String,
}

impl<'a> ResultsFile<'a> {
    /// Takes the format from the extension of `file`.
    ///
    /// # Errors
    ///
    /// A diagnostic if the extension is neither `csv` nor `md`.
    pub fn new(file: &'a Path) -> Result<Self> {
        let extension = file.extension().map(|extension| extension.to_string_lossy().to_lowercase());
        let format = match extension.as_deref() {
            Some("csv") => Results::csv,
            Some("md") => Results::markdown,
            _ => {
                let diagnostic = Diagnostic::new(Kind::Usage, "a table is written as .csv or .md").at(location(file));
                return Err(diagnostic.hint("e.g. `--table results.csv`").into());
            }
        };
        Ok(Self { file, format })
    }

    /// Checks that no run reads or writes the file.
    ///
    /// # Errors
    ///
    /// A diagnostic if one does, or if the file is a folder.
    pub fn check(&self, all: &[Prepared]) -> Result<()> {
        let message = if all.iter().any(|run| self.is_used_by(run)) {
            "a run reads or writes this file"
        } else if self.file.is_dir() {
            "there is a folder of that name"
        } else {
            return Ok(());
        };
        let diagnostic = Diagnostic::new(Kind::CannotWrite, message).at(location(self.file));
        Err(diagnostic.hint("choose another name").into())
    }

    fn is_used_by(&self, run: &Prepared) -> bool {
        let identity = paths::identity(self.file);
        let is_this = |path: &Path| paths::identity(path) == identity;
        run.inputs.iter().any(|input| is_this(&input.path)) || run.outputs.files().into_iter().any(is_this)
    }

    /// Writes the table.
    ///
    /// # Errors
    ///
    /// A diagnostic if the file cannot be written.
    pub fn write(&self, results: &Results) -> Result<()> {
        staging::write(self.file, (self.format)(results).as_bytes())?;
        Ok(())
    }
}

fn location(file: &Path) -> Location {
    Location::Argument(format!("--table {}", file.display()))
}
