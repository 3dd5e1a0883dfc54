//! Files that are on the disk, whole, before anybody hears of it.

use std::{
    fs::{self, File},
    io::{self, Write},
    path::Path,
};

use mimesh_core::Error;
use mimesh_document::Diagnostic;
use mimesh_markers::IntoDiagnostic;

/// Writes the whole file `path` so that after a crash either the old or the new contents are there.
///
/// The contents, and then the entry in the folder, are on the disk when this returns. A link stays a link, and permissions stay.
///
/// # Errors
///
/// Those of the system, at `path`; the old file then is as it was.
pub fn write(path: &Path, contents: &[u8]) -> Result<(), Diagnostic> {
    write_file(path, contents).map_err(|error| Error::write(path, error).into_diagnostic())
}

fn write_file(path: &Path, contents: &[u8]) -> io::Result<()> {
    let place = fs::canonicalize(path).unwrap_or_else(|_| path.into());
    let folder = place.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut temporary = tempfile::Builder::new().prefix(".mimesh-").suffix(".part").tempfile_in(folder)?;
    temporary.write_all(contents)?;
    match fs::metadata(&place) {
        Ok(metadata) => temporary.as_file().set_permissions(metadata.permissions())?,
        Err(_) => set_usual_permissions(temporary.as_file())?,
    }
    temporary.as_file().sync_all()?;
    temporary.persist(&place).map_err(|error| error.error)?;
    sync_folder(folder)
}

/// A temporary file is for its owner alone; a new file should be like any other.
#[cfg(unix)]
fn set_usual_permissions(file: &File) -> io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    file.set_permissions(fs::Permissions::from_mode(0o644))
}

#[cfg(not(unix))]
fn set_usual_permissions(_: &File) -> io::Result<()> {
    Ok(())
}

#[cfg(unix)]
fn sync_folder(folder: &Path) -> io::Result<()> {
    File::open(folder)?.sync_all()
}

#[cfg(not(unix))]
fn sync_folder(_: &Path) -> io::Result<()> {
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_replaced_whole_and_nothing_else_is_left() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.yaml");
        write(&path, b"one").unwrap();
        write(&path, b"two").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"two");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[cfg(unix)]
    #[test]
    fn a_link_stays_a_link() {
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("a"), folder.path().join("b"));
        write(&file, b"one").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        write(&link, b"two").unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&file).unwrap(), b"two");
    }

    #[test]
    fn a_folder_that_is_missing_is_an_error_at_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let error = write(&folder.path().join("no/a"), b"x").unwrap_err().to_string();
        assert!(error.contains("no/a"), "{error}");
    }
}
