//! Writing results to temporary files and moving them into place together, so that nothing half-written is ever left.
//!
//! A file is written beside its place under a name that this module knows. [`commit`] moves all files of a run at once, and
//! [`discard_all_and_exit`] removes those of a run that is interrupted.

use std::{
    collections::{BTreeMap, BTreeSet},
    ffi::OsStr,
    fs::File,
    io::{self, BufWriter, Write},
    path::{Path, PathBuf},
    sync::{Mutex, MutexGuard, PoisonError},
};

use mimesh_core::Error;
use mimesh_document::Diagnostic;
use mimesh_markers::IntoDiagnostic;

/// A result with a [`Diagnostic`].
type Result<T> = std::result::Result<T, Diagnostic>;

/// What file systems in use take for a name, in bytes.
const MAX_NAME: usize = 255;

/// The bytes that the name of a temporary file has beside that of its place: two dots, a process of ten digits, and `.part`.
const AFFIXES: usize = 17;

/// The longest name in bytes that a file may have to be written.
pub const MAX_WRITTEN_NAME: usize = MAX_NAME - AFFIXES;

/// The temporary files that exist.
static TEMPORARY: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// A file that is being written, or waits to be moved into its place; dropped, it is removed.
#[derive(Debug)]
pub struct Staged {
    temporary: PathBuf,
    place: PathBuf,
    bytes: u64,
    renamed: BTreeMap<String, String>,
}

/// A file in its place.
#[derive(Clone, Debug, PartialEq, Eq, serde::Deserialize, serde::Serialize)]
pub struct WrittenFile {
    /// The file.
    #[serde(serialize_with = "crate::json::path")]
    pub path: PathBuf,
    /// Its size.
    pub bytes: u64,
    /// The poses that it has under another name, with that name.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub renamed: BTreeMap<String, String>,
}

impl Staged {
    /// An empty temporary file for `place`, and the file to write to; folders are made as needed.
    ///
    /// # Errors
    ///
    /// Those of the system about `place`.
    pub fn create(place: &Path) -> Result<(Self, File)> {
        let folder = place.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        std::fs::create_dir_all(folder).map_err(|error| Error::write(folder, error).into_diagnostic())?;
        let name = place.file_name().unwrap_or_default().to_string_lossy();
        let temporary = folder.join(format!(".{name}.{}.part", std::process::id()));
        // The name is known before the file exists, so that an interrupt between the two leaves nothing.
        locked().insert(temporary.clone());
        let staged = Self { temporary, place: place.into(), bytes: 0, renamed: BTreeMap::new() };
        let file = File::options().read(true).write(true).create(true).truncate(true).open(&staged.temporary);
        let file = file.map_err(|error| Error::write(place, error).into_diagnostic())?;
        Ok((staged, file))
    }

    /// Notes the size of the file, which is complete.
    ///
    /// # Errors
    ///
    /// Those of the system about its place.
    pub fn close(&mut self) -> Result<()> {
        let failed = |error| Error::write(&self.place, error).into_diagnostic();
        self.bytes = std::fs::metadata(&self.temporary).map_err(failed)?.len();
        Ok(())
    }

    /// Where the file will be.
    pub fn place(&self) -> &Path {
        &self.place
    }

    /// Notes the poses that the file has under another name, with that name.
    pub fn set_renamed(&mut self, renamed: &[(String, String)]) {
        self.renamed = renamed.iter().cloned().collect();
    }

    /// The file as it will be in its place.
    pub fn written(&self) -> WrittenFile {
        WrittenFile { path: self.place.clone(), bytes: self.bytes, renamed: self.renamed.clone() }
    }
}

/// Writes the file for `place` to a temporary file; folders are made as needed.
///
/// # Errors
///
/// Those of `write`, and of the system about `place`.
pub fn stage(place: &Path, write: impl FnOnce(&mut dyn Write) -> mimesh_core::Result<()>) -> Result<Staged> {
    let (mut staged, file) = Staged::create(place)?;
    let mut out = BufWriter::with_capacity(1 << 16, file);
    write(&mut out).map_err(IntoDiagnostic::into_diagnostic)?;
    out.flush().map_err(|error| Error::write(place, error).into_diagnostic())?;
    staged.close()?;
    Ok(staged)
}

/// Writes `bytes` for `place`, as [`stage`].
///
/// # Errors
///
/// Those of the system about `place`.
pub fn stage_bytes(place: &Path, bytes: &[u8]) -> Result<Staged> {
    stage(place, |out| out.write_all(bytes).map_err(|error| Error::write(place, error)))
}

/// Writes a whole file.
///
/// # Errors
///
/// Those of the system about `place`.
pub fn write(place: &Path, bytes: &[u8]) -> Result<()> {
    commit(vec![stage_bytes(place, bytes)?]).map(drop)
}

/// Moves files into their places.
///
/// # Errors
///
/// Those of the system about the first that cannot be moved; those after it are removed.
pub fn commit(files: Vec<Staged>) -> Result<Vec<WrittenFile>> {
    let mut written = Vec::new();
    // While the lock is held an interrupt waits, so that it finds all files in place or none.
    let mut temporary = locked();
    for file in &files {
        if let Err(error) = std::fs::rename(&file.temporary, &file.place) {
            drop(temporary);
            return Err(Error::write(&file.place, error).into_diagnostic());
        }
        temporary.remove(&file.temporary);
        written.push(file.written());
    }
    Ok(written)
}

/// Removes the temporary files that killed runs have left for `places`.
///
/// Only where the system tells which processes are alive (Linux): elsewhere such files stay.
pub fn remove_abandoned(places: &[&Path]) {
    let processes = Path::new("/proc");
    if !processes.join(std::process::id().to_string()).is_dir() {
        return;
    }
    let folder = |place: &&Path| place.parent().map(Path::to_owned).unwrap_or_default();
    let folders: BTreeSet<PathBuf> = places.iter().map(folder).collect();
    let names: BTreeSet<_> = places.iter().filter_map(|place| place.file_name()).collect();
    for folder in folders {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { &folder };
        for entry in std::fs::read_dir(folder).into_iter().flatten().filter_map(io::Result::ok) {
            let name = entry.file_name();
            let parts = name.to_str().and_then(|name| name.strip_prefix('.')?.strip_suffix(".part")?.rsplit_once('.'));
            if let Some((place, process)) = parts
                && names.contains(OsStr::new(place))
                && process.parse::<u32>().is_ok()
                && !processes.join(process).exists()
            {
                let _ = std::fs::remove_file(entry.path());
            }
        }
    }
}

/// Removes every temporary file, and lets none be moved or made until the process ends with `status`.
pub fn discard_all_and_exit(status: u8) -> ! {
    let temporary = locked();
    for file in temporary.iter() {
        let _ = std::fs::remove_file(file);
    }
    std::process::exit(status.into())
}

impl Drop for Staged {
    fn drop(&mut self) {
        let mut temporary = locked();
        if temporary.remove(&self.temporary) {
            let _ = std::fs::remove_file(&self.temporary);
        }
    }
}

fn locked() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    TEMPORARY.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = std::fs::read_dir(folder).unwrap();
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
    }

    #[test]
    fn a_file_is_in_its_place_only_after_the_commit() {
        let folder = tempfile::tempdir().unwrap();
        let place = folder.path().join("new/a.txt");
        let staged = stage(&place, |out| out.write_all(b"abc").map_err(|e| Error::write(&place, e))).unwrap();
        assert!(!place.exists());
        let written = commit(vec![staged]).unwrap();
        assert_eq!(written, [WrittenFile { path: place.clone(), bytes: 3, renamed: BTreeMap::new() }]);
        assert_eq!(names(place.parent().unwrap()), ["a.txt"]);
    }

    #[test]
    fn a_failure_while_writing_leaves_nothing_and_keeps_what_was_there() {
        let folder = tempfile::tempdir().unwrap();
        let place = folder.path().join("a.txt");
        std::fs::write(&place, "old").unwrap();
        let failed = stage(&place, |out| {
            let _ = out.write_all(&[0; 100_000]);
            Err(Error::data("no", ""))
        });
        assert!(failed.is_err());
        assert_eq!(names(folder.path()), ["a.txt"]);
        assert_eq!(std::fs::read_to_string(&place).unwrap(), "old");
    }

    #[test]
    fn what_is_not_committed_is_removed() {
        let folder = tempfile::tempdir().unwrap();
        drop(stage(&folder.path().join("a.txt"), |_| Ok(())).unwrap());
        assert!(names(folder.path()).is_empty());
    }
}
