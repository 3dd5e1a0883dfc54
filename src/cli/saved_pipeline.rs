//! The file that takes a pipeline with every choice spelled out.

use std::path::Path;

use mimesh_document::diagnostic::{Kind, Result};
use mimesh_pipeline::{Prepared, spelled_out::spelled_out};

use crate::cli::out_file::{OutFile, write_all};

/// What a pipeline's file may end in.
const EXTENSIONS: [&str; 2] = ["yaml", "yml"];

/// The file for a pipeline.
pub struct SavedPipeline<'a> {
    file: OutFile<'a>,
}

impl<'a> SavedPipeline<'a> {
    /// Takes `file`, named with `--save`.
    ///
    /// # Errors
    ///
    /// As [`named`](Self::named).
    pub fn new(file: &'a Path) -> Result<Self> {
        Self::named("--save", file)
    }

    /// Takes `file`, named with `--save`, whether or not it is there already.
    ///
    /// # Errors
    ///
    /// A diagnostic if it is no `.yaml`.
    pub fn replacing(file: &'a Path) -> Result<Self> {
        let file = OutFile { option: "--save", file };
        file.check(&EXTENSIONS)?;
        Ok(Self { file })
    }

    /// Takes `file`, named with `option`.
    ///
    /// # Errors
    ///
    /// A diagnostic if it is no `.yaml`, or is there already.
    pub fn named(option: &'static str, file: &'a Path) -> Result<Self> {
        let out = OutFile { option, file };
        out.check(&EXTENSIONS)?;
        if file.exists() {
            let diagnostic = out.diagnostic(Kind::CannotWrite, "exists already");
            return Err(diagnostic.hint("nothing is overwritten; choose another name").into());
        }
        Ok(Self { file: out })
    }

    /// Writes the only one of `all`.
    ///
    /// # Errors
    ///
    /// A diagnostic if there are several, and if the file cannot be written.
    pub fn write(&self, all: &[Prepared]) -> Result<()> {
        let [one] = all else {
            let message = "the pipeline declares several runs, expected one";
            let hint = "save one of them: give it a file of its own, or leave `targets` and `matrix` out";
            return Err(self.file.diagnostic(Kind::Usage, message).hint(hint).into());
        };
        let file = self.file.file;
        let inputs = one.inputs.iter().map(|input| &*input.path);
        self.file.check_is_none_of(inputs.chain(one.outputs.files()), "the run reads or writes this file")?;
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        let text = format!("# mimesh run {name}\n\n{}", spelled_out(one, file));
        write_all(&[(file, text.as_bytes())]).map(drop)
    }
}
