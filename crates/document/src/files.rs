//! Files: their text and hash, and what went wrong with a file in words that do not depend on the system.

use std::{
    io::{self, ErrorKind},
    path::Path,
};

use crate::{
    diagnostic::{Diagnostic, Kind, Location},
    paths::similar_file,
};

/// Reads a text file.
///
/// # Errors
///
/// A [`Diagnostic`] at the file.
pub fn read_text(path: &Path) -> Result<String, Diagnostic> {
    std::fs::read_to_string(path).map_err(|error| unreadable(path, "read", &error))
}

/// The diagnostic of a file that cannot be read, or for another `action` opened.
pub fn unreadable(path: &Path, action: &str, error: &io::Error) -> Diagnostic {
    let kind = match error.kind() {
        ErrorKind::NotFound | ErrorKind::IsADirectory => Kind::MissingInput,
        _ => Kind::BadData,
    };
    let hint = match error.kind() {
        ErrorKind::NotFound => similar_file(path).unwrap_or_default(),
        ErrorKind::InvalidData => "is it the file that is meant? if so, save it as UTF-8".into(),
        ErrorKind::PermissionDenied => "allow reading it, or give another file".into(),
        _ => String::new(),
    };
    Diagnostic::new(kind, io_message(action, error)).at(Location::File(path.into())).hint(hint)
}

/// What happened to a file while `action` (`read`, `write`) was tried.
pub fn io_message(action: &str, error: &io::Error) -> String {
    match error.kind() {
        ErrorKind::NotFound if action == "write" => "cannot write: no such folder".into(),
        ErrorKind::NotFound => "no such file".into(),
        ErrorKind::IsADirectory => "is a folder, expected a file".into(),
        ErrorKind::PermissionDenied => format!("no permission to {action} it"),
        ErrorKind::StorageFull => format!("cannot {action}: the disk is full"),
        ErrorKind::InvalidData => format!("cannot {action}: not UTF-8 text"),
        _ => format!("cannot {action}: {error}"),
    }
}

/// The BLAKE3 hash of a file in hexadecimal.
///
/// # Errors
///
/// If the file cannot be read.
pub fn hash_file(path: &Path) -> io::Result<String> {
    let mut hasher = blake3::Hasher::new();
    hasher.update_reader(std::fs::File::open(path)?)?;
    Ok(hasher.finalize().to_hex().to_string())
}
