//! The places of results: links are followed, and what is no file is refused.

use std::{
    fs, io,
    path::{Component, Path, PathBuf},
};

use mimesh_core::Error;
use mimesh_document::{Diagnostic, Kind, Location};
use mimesh_markers::IntoDiagnostic;

/// Links in a row that are followed, as Linux does.
const MAX_LINKS: usize = 40;

/// The file that is written for `place`: at the end of all links, in a folder that exists.
///
/// # Errors
///
/// Those of the system, and what [`not_a_file`] says.
pub(super) fn resolve(place: &Path) -> Result<PathBuf, Diagnostic> {
    let failed = |error| Error::write(place, error).into_diagnostic();
    let file = follow(place).map_err(failed)?;
    if let Some(kind) = not_a_file(&file) {
        let diagnostic = Diagnostic::new(Kind::CannotWrite, format!("cannot write: there is {kind} of that name"));
        return Err(diagnostic.at(Location::File(place.into())).hint("choose another folder or name"));
    }
    let name = file.file_name().ok_or_else(|| failed(io::ErrorKind::InvalidFilename.into()))?;
    Ok(folder_of(&file).canonicalize().map_err(failed)?.join(name))
}

/// The folder of a file.
pub(super) fn folder_of(file: &Path) -> &Path {
    file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// What is at `path`, in words, if it is neither a file nor free: results never go into it.
pub fn not_a_file(path: &Path) -> Option<&'static str> {
    let kind = fs::metadata(path).ok()?.file_type();
    match () {
        () if kind.is_file() => None,
        () if kind.is_dir() => Some("a folder"),
        () => Some(special(kind)),
    }
}

#[cfg(unix)]
fn special(kind: fs::FileType) -> &'static str {
    use std::os::unix::fs::FileTypeExt;
    match () {
        () if kind.is_fifo() => "a pipe",
        () if kind.is_socket() => "a socket",
        () => "a device",
    }
}

#[cfg(not(unix))]
fn special(_: fs::FileType) -> &'static str {
    "something that is no file"
}

/// The end of the links that begin at `place`; it need not exist.
fn follow(place: &Path) -> io::Result<PathBuf> {
    let mut file = place.to_path_buf();
    for _ in 0..MAX_LINKS {
        match fs::symlink_metadata(&file) {
            Ok(found) if found.is_symlink() => file = folder_of(&file).join(fs::read_link(&file)?),
            Ok(_) => return Ok(file),
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(file),
            Err(error) => return Err(error),
        }
    }
    Err(io::Error::other("too many links in a row"))
}

/// `file` as it is seen from `folder`; both are absolute and without links.
pub(super) fn relative(file: &Path, folder: &Path) -> PathBuf {
    let same = file.components().zip(folder.components()).take_while(|(a, b)| a == b).count();
    // Nothing in common, as on two drives.
    if same == 0 {
        return file.into();
    }
    let up = folder.components().skip(same).map(|_| Component::ParentDir);
    up.chain(file.components().skip(same)).collect()
}

/// `path`, which was seen from `folder`, without `..`.
pub(super) fn absolute(path: &Path, folder: &Path) -> PathBuf {
    let mut file = folder.to_path_buf();
    for part in path.components() {
        match part {
            Component::ParentDir => _ = file.pop(),
            Component::CurDir => {}
            part => file.push(part),
        }
    }
    file
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_seen_from_a_folder_leads_back() {
        for (file, folder, seen) in [("/a/b/c", "/a/b", "c"), ("/a/x/c", "/a/b/d", "../../x/c"), ("/c", "/a", "../c")] {
            assert_eq!(relative(Path::new(file), Path::new(folder)), Path::new(seen));
            assert_eq!(absolute(Path::new(seen), Path::new(folder)), Path::new(file));
        }
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_to_files_that_need_not_be_there_and_never_in_a_circle() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().canonicalize().unwrap().join(name);
        fs::create_dir(at("deep")).unwrap();
        symlink("deep/new.obj", at("a")).unwrap();
        symlink("a", at("b")).unwrap();
        assert_eq!(resolve(&at("b")).unwrap(), at("deep/new.obj"));
        symlink("c", at("c")).unwrap();
        assert!(resolve(&at("c")).is_err());
        symlink("/dev/null", at("d")).unwrap();
        let told = resolve(&at("d")).unwrap_err().to_string();
        assert!(told.contains("there is a device of that name"), "{told}");
        assert!(resolve(&at("deep")).unwrap_err().to_string().contains("a folder"));
    }
}
