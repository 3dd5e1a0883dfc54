//! Files: their text and hash, and what went wrong with a file in words that do not depend on the system.
//!
//! All texts that a user names are read here: from regular files alone, since a pipe may never end and a device never does, and up
//! to a size.

use std::{
    fs::{File, FileType, Metadata},
    io::{self, ErrorKind, Read},
    path::{Path, PathBuf},
};

use crate::{
    diagnostic::{Diagnostic, Kind, Location},
    encoding,
    limits::{MAX_TEXT_BYTES, thousands},
    paths::similar_file,
};

/// Reads a text file.
///
/// # Errors
///
/// A [`Diagnostic`] at the file.
pub fn read_text(path: &Path) -> Result<String, Diagnostic> {
    read_text_up_to(path, MAX_TEXT_BYTES)
}

/// Reads a text file of at most `limit` bytes.
///
/// # Errors
///
/// A [`Diagnostic`] at the file: that it is missing, no regular file, longer, or no UTF-8.
pub fn read_text_up_to(path: &Path, limit: u64) -> Result<String, Diagnostic> {
    let mut bytes = Vec::new();
    // One byte more tells whether the file goes on.
    let read = open(path)?.take(limit.saturating_add(1)).read_to_end(&mut bytes);
    read.map_err(|error| unreadable(path, "read", &error))?;
    if bytes.len() as u64 > limit {
        let message =
            format!("the file has more than {} bytes", thousands(usize::try_from(limit).unwrap_or(usize::MAX)));
        let diagnostic = Diagnostic::new(Kind::BadData, message).at(Location::File(path.into()));
        return Err(diagnostic.hint("is it the file that is meant? texts of this kind are far smaller"));
    }
    encoding::utf8(bytes).map_err(|problem| {
        Diagnostic::new(Kind::BadData, problem.message).at(Location::File(path.into())).hint(problem.hint)
    })
}

/// Opens a regular file to read it.
///
/// # Errors
///
/// A [`Diagnostic`] at the file.
fn open(path: &Path) -> Result<File, Diagnostic> {
    open_regular(path).map_err(|error| unreadable(path, "read", &error))
}

/// Opens a regular file to read it: opening a pipe would wait for its writer, and a device has no end.
///
/// # Errors
///
/// Those of the system, and that it is something else.
pub fn open_regular(path: &Path) -> io::Result<File> {
    check_regular(path)?;
    let file = File::open(path)?;
    // It may have been exchanged in between.
    expect_file(&file.metadata()?)?;
    Ok(file)
}

/// Checks that `path` is a regular file.
///
/// # Errors
///
/// Those of the system, and that it is something else.
pub fn check_regular(path: &Path) -> io::Result<()> {
    expect_file(&std::fs::metadata(path)?)
}

fn expect_file(metadata: &Metadata) -> io::Result<()> {
    match other_than_file(metadata.file_type()) {
        None => Ok(()),
        Some(_) if metadata.is_dir() => Err(ErrorKind::IsADirectory.into()),
        Some(found) => Err(io::Error::new(ErrorKind::InvalidInput, format!("it is {found}, expected a file"))),
    }
}

/// What something is that is no regular file, with its article.
fn other_than_file(found: FileType) -> Option<&'static str> {
    if found.is_file() {
        return None;
    }
    if found.is_dir() {
        return Some("a folder");
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        if found.is_fifo() {
            return Some("a pipe");
        }
        if found.is_socket() {
            return Some("a socket");
        }
    }
    Some("a device")
}

/// Why there is no regular file at `path`, in words that name it, and the way out if there is one; `None` if there is one.
pub fn why_no_file(path: &Path) -> Option<(String, Option<String>)> {
    let shown = path.display();
    let error = match std::fs::metadata(path) {
        Ok(metadata) => {
            let found = other_than_file(metadata.file_type())?;
            let hint = match metadata.is_dir() {
                true => "name a file in it; `*.obj` in quotes stands for all of a kind",
                false => "write its contents into a file, and name that",
            };
            return Some((format!("{shown} is {found}, expected a file"), Some(hint.into())));
        }
        Err(error) => error,
    };
    if error.kind() == ErrorKind::NotFound {
        if let Some(aim) = broken_link(path) {
            let hint = "make the link anew, or name the file itself";
            return Some((format!("{shown} is a link to {}, which does not exist", aim.display()), Some(hint.into())));
        }
        return Some((format!("no such file: {shown}"), similar_file(path)));
    }
    let hint = hint_of(path, &error);
    Some((format!("{}: {shown}", io_message("read", &error)), Some(hint).filter(|hint| !hint.is_empty())))
}

/// Where the link at `path` leads, if there is nothing.
fn broken_link(path: &Path) -> Option<PathBuf> {
    std::fs::read_link(path).ok()
}

/// The nearest folder around `path` that lets nobody look into it.
fn closed_folder(path: &Path) -> Option<&Path> {
    let open = |folder: &&Path| folder.as_os_str().is_empty() || folder.symlink_metadata().is_ok();
    path.ancestors().skip(1).find(open)
}

/// The diagnostic of a file that cannot be read, or for another `action` opened.
pub fn unreadable(path: &Path, action: &str, error: &io::Error) -> Diagnostic {
    let kind = match error.kind() {
        ErrorKind::NotFound | ErrorKind::IsADirectory | ErrorKind::InvalidInput => Kind::MissingInput,
        _ => Kind::BadData,
    };
    Diagnostic::new(kind, io_message(action, error)).at(Location::File(path.into())).hint(hint_of(path, error))
}

/// The way out where `path` cannot be read; may be empty.
fn hint_of(path: &Path, error: &io::Error) -> String {
    match error.kind() {
        ErrorKind::NotFound => match broken_link(path) {
            Some(aim) => format!("it is a link to {}, which does not exist", aim.display()),
            None => similar_file(path).unwrap_or_default(),
        },
        ErrorKind::InvalidData => "is it the file that is meant? if so, save it as UTF-8".into(),
        ErrorKind::PermissionDenied => match closed_folder(path) {
            Some(folder) if path.symlink_metadata().is_err() => {
                format!("the folder {} is closed to this user: allow reading it", folder.display())
            }
            _ => "allow reading it, or give another file".into(),
        },
        ErrorKind::IsADirectory => "name a file in it".into(),
        ErrorKind::InvalidInput => "write its contents into a file, and name that".into(),
        _ => String::new(),
    }
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
        // What was found in place of a regular file.
        ErrorKind::InvalidInput => error.to_string(),
        ErrorKind::InvalidFilename => format!("cannot {action}: the path is longer than the system takes"),
        _ => {
            let text = error.to_string();
            // The system's number says nothing to people.
            let text = text.split(" (os error").next().unwrap_or_default();
            match text.contains("symbolic link") {
                true => format!("cannot {action}: it is a link that leads back to itself"),
                false => format!("cannot {action}: {text}"),
            }
        }
    }
}

/// The BLAKE3 hash of a regular file in hexadecimal.
///
/// # Errors
///
/// If the file cannot be read, or is no regular file.
pub fn hash_file(path: &Path) -> io::Result<String> {
    let mut hasher = blake3::Hasher::new();
    hasher.update_reader(open_regular(path)?)?;
    Ok(hasher.finalize().to_hex().to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_read_up_to_its_limit() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.txt");
        std::fs::write(&file, "12345").unwrap();
        assert_eq!(read_text_up_to(&file, 5).unwrap(), "12345");
        let message = read_text_up_to(&file, 4).unwrap_err().message;
        assert_eq!(message, "the file has more than 4 bytes");
    }

    #[cfg(unix)]
    #[test]
    fn what_is_no_regular_file_is_told_by_what_it_is() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let _socket = std::os::unix::net::UnixListener::bind(at("socket")).unwrap();
        std::os::unix::fs::symlink("none", at("broken")).unwrap();
        std::os::unix::fs::symlink("loop", at("loop")).unwrap();
        let told = |path: &Path| (read_text(path).unwrap_err().message, why_no_file(path).unwrap().0);
        for (path, expected) in
            [(at("socket"), "is a socket"), (folder.path().into(), "is a folder"), ("/dev/zero".into(), "is a device")]
        {
            let (read, found) = told(&path);
            assert!(read.ends_with(&format!("{expected}, expected a file")), "{read}");
            assert_eq!(found, format!("{} {expected}, expected a file", path.display()));
        }
        assert!(told(&at("broken")).1.ends_with("is a link to none, which does not exist"));
        assert!(told(&at("loop")).1.contains("cannot read"), "{:?}", told(&at("loop")));
        assert!(hash_file(Path::new("/dev/zero")).is_err());
        let long = PathBuf::from("a".repeat(100_000));
        assert!(told(&long).0.contains("longer than the system takes"), "{:?}", told(&long));
    }
}
