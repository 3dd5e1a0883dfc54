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
    read_utf8(path).map_err(|error| unreadable(path, "read", &error))
}

fn read_utf8(path: &Path) -> io::Result<String> {
    check_regular(path)?;
    String::from_utf8(std::fs::read(path)?).map_err(|problem| {
        let start = &problem.as_bytes()[..problem.utf8_error().valid_up_to()];
        let line = start.iter().filter(|byte| **byte == b'\n').count() + 1;
        let byte = problem.as_bytes()[start.len()];
        io::Error::new(ErrorKind::InvalidData, format!("not UTF-8 text: line {line} has the byte {byte:#04x}"))
    })
}

/// Checks that `path` is no pipe, device or socket, from which a program could wait or read for ever.
///
/// # Errors
///
/// That it is one, and those of the system.
pub fn check_regular(path: &Path) -> io::Result<()> {
    let kind = std::fs::metadata(path)?.file_type();
    // Reading a folder has an error of its own.
    if kind.is_file() || kind.is_dir() {
        return Ok(());
    }
    Err(io::Error::new(ErrorKind::InvalidInput, format!("it is {}, expected a regular file", special(kind))))
}

#[cfg(unix)]
fn special(kind: std::fs::FileType) -> &'static str {
    use std::os::unix::fs::FileTypeExt;
    match kind {
        _ if kind.is_fifo() => "a named pipe",
        _ if kind.is_socket() => "a socket",
        _ if kind.is_char_device() || kind.is_block_device() => "a device",
        _ => "no regular file",
    }
}

#[cfg(not(unix))]
fn special(_: std::fs::FileType) -> &'static str {
    "no regular file"
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
        ErrorKind::InvalidInput => "copy its contents into a file first".into(),
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
        _ => format!("cannot {action}: {error}"),
    }
}

/// The BLAKE3 hash of a file in hexadecimal.
///
/// # Errors
///
/// If the file cannot be read.
pub fn hash_file(path: &Path) -> io::Result<String> {
    check_regular(path)?;
    let mut hasher = blake3::Hasher::new();
    hasher.update_reader(std::fs::File::open(path)?)?;
    Ok(hasher.finalize().to_hex().to_string())
}
