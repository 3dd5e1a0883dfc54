//! The file that `mimesh run --table FILE` writes.

use std::path::Path;

use mimesh_document::diagnostic::{Kind, Result};
use mimesh_pipeline::{Prepared, report::Results};

use crate::cli::out_file::{OutFile, write_all};

/// The file for the table of results.
pub struct ResultsFile<'a> {
    file: OutFile<'a>,
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
        let file = OutFile { option: "--table", file };
        let format = match &*file.extension() {
            "csv" => Results::csv,
            "md" => Results::markdown,
            _ => {
                let diagnostic = file.diagnostic(Kind::Usage, "a table is written as .csv or .md");
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
        let inputs = all.iter().flat_map(|run| &run.inputs).map(|input| &*input.path);
        let outputs = all.iter().flat_map(|run| run.outputs.files());
        self.file.check_is_none_of(inputs.chain(outputs), "a run reads or writes this file")?;
        self.file.check_is_no_folder()
    }

    /// Writes the table.
    ///
    /// # Errors
    ///
    /// A diagnostic if the file cannot be written.
    pub fn write(&self, results: &Results) -> Result<()> {
        write_all(&[(self.file.file, (self.format)(results).as_bytes())])?;
        Ok(())
    }
}
