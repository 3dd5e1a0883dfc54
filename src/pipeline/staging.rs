//! Writing results aside and moving them into place together, so that nothing half-written is ever left.
//!
//! A file is written beside its place under a name of its own, known to this module; [`commit`] moves all files of a
//! run at once, and [`discard_all_and_exit`] removes those of a run that is interrupted.

use std::{
    collections::BTreeSet,
    ffi::OsStr,
    fs::File,
    io::{self, BufWriter, Write},
    path::{Path, PathBuf},
    sync::{Mutex, MutexGuard, PoisonError},
};

use crate::core::{Error, Result};

/// The files that are written aside.
static ASIDE: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// A complete file that waits to be moved into its place; dropped, it is removed.
#[derive(Debug)]
pub struct Staged {
    aside: PathBuf,
    place: PathBuf,
    bytes: u64,
}

/// A file that is in its place.
#[derive(Clone, Debug, PartialEq, Eq, serde::Deserialize, serde::Serialize)]
pub struct WrittenFile {
    /// The file.
    pub path: PathBuf,
    /// Its size.
    pub bytes: u64,
}

impl Staged {
    /// What it will be once it is in its place.
    pub fn written(&self) -> WrittenFile {
        WrittenFile { path: self.place.clone(), bytes: self.bytes }
    }
}

/// Writes the file for `place` aside; folders are made as needed.
///
/// # Errors
///
/// Whatever `write` gives, and [`Error::Io`] about `place`.
pub fn stage(place: &Path, write: impl FnOnce(&mut dyn Write) -> Result<()>) -> Result<Staged> {
    let failed = |error: io::Error| Error::write(place, error);
    let folder = place.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder).map_err(|error| Error::write(folder, error))?;
    let name = place.file_name().unwrap_or_default().to_string_lossy();
    let aside = folder.join(format!(".{name}.{}.part", std::process::id()));
    // The name is known before the file exists, so that an interrupt between the two leaves nothing.
    locked().insert(aside.clone());
    let mut staged = Staged { aside, place: place.into(), bytes: 0 };
    let mut out = BufWriter::with_capacity(1 << 16, File::create(&staged.aside).map_err(failed)?);
    write(&mut out)?;
    out.flush().map_err(failed)?;
    staged.bytes = out.get_ref().metadata().map_err(failed)?.len();
    Ok(staged)
}

/// Writes `bytes` for `place` aside, as [`stage`].
///
/// # Errors
///
/// [`Error::Io`] about `place`.
pub fn stage_bytes(place: &Path, bytes: &[u8]) -> Result<Staged> {
    stage(place, |out| out.write_all(bytes).map_err(|error| Error::write(place, error)))
}

/// Writes a file whole: aside, and then into its place.
///
/// # Errors
///
/// [`Error::Io`] about `place`.
pub fn write(place: &Path, bytes: &[u8]) -> Result<()> {
    commit(vec![stage_bytes(place, bytes)?]).map(drop)
}

/// Moves files into their places.
///
/// # Errors
///
/// [`Error::Io`] about the first that cannot be moved; those after it are removed.
pub fn commit(files: Vec<Staged>) -> Result<Vec<WrittenFile>> {
    let mut written = Vec::new();
    // While the lock is held an interrupt waits, so that it finds all files in place or none.
    let mut aside = locked();
    for file in &files {
        if let Err(error) = std::fs::rename(&file.aside, &file.place) {
            drop(aside);
            return Err(Error::write(&file.place, error));
        }
        aside.remove(&file.aside);
        written.push(file.written());
    }
    Ok(written)
}

/// Removes what runs that were killed have left aside for `places`.
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

/// Removes every file written aside, and lets none be moved or made until the process ends with `status`.
pub fn discard_all_and_exit(status: u8) -> ! {
    let aside = locked();
    for file in aside.iter() {
        let _ = std::fs::remove_file(file);
    }
    std::process::exit(status.into())
}

impl Drop for Staged {
    fn drop(&mut self) {
        let mut aside = locked();
        if aside.remove(&self.aside) {
            let _ = std::fs::remove_file(&self.aside);
        }
    }
}

fn locked() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    ASIDE.lock().unwrap_or_else(PoisonError::into_inner)
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
        assert_eq!(written, [WrittenFile { path: place.clone(), bytes: 3 }]);
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
