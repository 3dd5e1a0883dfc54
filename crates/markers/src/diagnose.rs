//! Errors of `core` as diagnostics.
//!
//! `document` knows nothing of `core`, so the conversion stands in the lowest crate that knows both.

use std::io::ErrorKind;

use mimesh_core::Error;
use mimesh_document::{Diagnostic, Kind, Location, files};

/// Remedy: write the results into another folder.
pub const OTHER_OUTPUT_FOLDER: &str = "other_output_folder";

/// Remedy: let meshes refer to files in another folder.
pub const OTHER_ROOT: &str = "other_root";

/// Remedy: let the process have more memory.
pub const MORE_MEMORY: &str = "more_memory";

/// Errors that can be shown as a [`Diagnostic`].
pub trait IntoDiagnostic {
    /// The error as a diagnostic at the file and line that it names.
    fn into_diagnostic(self) -> Diagnostic;
}

impl IntoDiagnostic for Error {
    fn into_diagnostic(self) -> Diagnostic {
        let kind = kind_of(&self);
        let diagnostic = Diagnostic::new(kind, self.to_string()).hint(self.hint().unwrap_or_default());
        match self {
            Error::File { path, line: Some(line), message, .. } => {
                Diagnostic { message, ..diagnostic }.at(Location::Line { file: path, line })
            }
            Error::File { path, line: None, message, .. } => {
                Diagnostic { message, ..diagnostic }.at(Location::File(path))
            }
            Error::OutOfReach { path, referenced, reason } => {
                let message = format!("it refers to {}, {reason}", referenced.display());
                let diagnostic = Diagnostic { message, ..diagnostic }.at(Location::File(path));
                diagnostic.remedy(OTHER_ROOT, "", "allow its folder")
            }
            Error::Io { path, action: "write", source } => {
                let message = files::io_message("write", &source);
                let hint = if source.kind() == ErrorKind::StorageFull { "free some space" } else { "" };
                let diagnostic = Diagnostic::new(kind, message).at(Location::File(path)).hint(hint);
                diagnostic.remedy(OTHER_OUTPUT_FOLDER, "", "write elsewhere")
            }
            Error::Io { path, action, source } => files::unreadable(&path, action, &source),
            Error::Memory { .. } => diagnostic.remedy(MORE_MEMORY, "", "allow more"),
            _ => diagnostic,
        }
    }
}

/// The kind of an error of a stage or a file.
fn kind_of(error: &Error) -> Kind {
    match error {
        Error::Io { action: "write", .. } => Kind::CannotWrite,
        Error::Io { source, .. } if matches!(source.kind(), ErrorKind::NotFound | ErrorKind::IsADirectory) => {
            Kind::MissingInput
        }
        Error::Setting { .. } => Kind::BadPipeline,
        Error::Memory { .. } => Kind::Memory,
        Error::Other(_) => Kind::Internal,
        _ => Kind::BadData,
    }
}

#[cfg(test)]
mod tests {
    use std::{io, path::Path};

    use super::*;

    #[test]
    fn errors_of_files_tell_missing_from_unreadable_and_from_unwritable() {
        let path = Path::new("a.obj");
        let missing = Error::read(path, io::ErrorKind::NotFound.into());
        let folder = Error::read(path, io::ErrorKind::IsADirectory.into());
        let denied = Error::read(path, io::ErrorKind::PermissionDenied.into());
        let full = Error::write(path, io::ErrorKind::StorageFull.into());
        let kinds = [missing, folder, denied, full].map(|error| error.into_diagnostic().kind);
        assert_eq!(kinds, [Kind::MissingInput, Kind::MissingInput, Kind::BadData, Kind::CannotWrite]);
    }
}
