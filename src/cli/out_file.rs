//! A file that an option names for a command to write.

use std::path::{Path, PathBuf};

use mimesh_document::{
    diagnostic::{Diagnostic, Kind, Location, Result},
    paths,
};
use mimesh_pipeline::staging;

use crate::cli::terminal;

/// Writes whole files together, and shows what others had left there; the paths of the files.
///
/// # Errors
///
/// Those of [`staging::write_all`].
pub fn write_all(files: &[(&Path, &[u8])]) -> Result<Vec<PathBuf>> {
    let written = staging::write_all(files)?;
    written.warnings.iter().for_each(|warning| terminal::warn(warning));
    Ok(written.files.into_iter().map(|file| file.path).collect())
}

/// A file to write, with the option that names it, e.g. `--out`.
#[derive(Clone, Copy, Debug)]
pub struct OutFile<'a> {
    /// The option.
    pub option: &'static str,
    /// Its argument.
    pub file: &'a Path,
}

impl OutFile<'_> {
    /// The extension in lower case; empty if there is none.
    pub fn extension(&self) -> String {
        self.file.extension().unwrap_or_default().to_string_lossy().to_lowercase()
    }

    /// Checks that the file has one of `extensions` and is not a folder.
    ///
    /// # Errors
    ///
    /// A diagnostic if it does not.
    pub fn check(&self, extensions: &[&str]) -> Result<()> {
        if !extensions.contains(&&*self.extension()) {
            return Err(self.diagnostic(Kind::Usage, format!("expected a .{} file", extensions[0])).into());
        }
        self.check_is_no_folder()
    }

    /// Checks that the file is not a folder.
    ///
    /// # Errors
    ///
    /// A diagnostic if it is.
    pub fn check_is_no_folder(&self) -> Result<()> {
        if self.file.is_dir() { Err(self.refusal("there is a folder of that name")) } else { Ok(()) }
    }

    /// Checks that the file is none of `others`, by whatever path; `message` says what they are.
    ///
    /// # Errors
    ///
    /// A diagnostic if it is one of them.
    pub fn check_is_none_of<'p>(&self, others: impl IntoIterator<Item = &'p Path>, message: &str) -> Result<()> {
        let identity = paths::identity(self.file);
        match others.into_iter().any(|other| paths::identity(other) == identity) {
            true => Err(self.refusal(message)),
            false => Ok(()),
        }
    }

    /// A diagnostic at the option.
    pub fn diagnostic(&self, kind: Kind, message: impl Into<String>) -> Diagnostic {
        let argument = format!("{} {}", self.option, self.file.display());
        Diagnostic::new(kind, message).at(Location::Argument(argument))
    }

    fn refusal(&self, message: &str) -> mimesh_document::Diagnostics {
        self.diagnostic(Kind::CannotWrite, message).hint("choose another name").into()
    }
}
