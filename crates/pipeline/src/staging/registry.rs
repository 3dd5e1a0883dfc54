//! The temporary files that exist, so that an interrupt leaves none.

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
    sync::{Mutex, MutexGuard, PoisonError},
};

/// What an interrupt removes.
#[derive(Debug, Default)]
pub(super) struct Temporary {
    files: BTreeSet<PathBuf>,
    /// Folders that were made for them, removed if they are empty.
    folders: BTreeSet<PathBuf>,
}

static TEMPORARY: Mutex<Temporary> = Mutex::new(Temporary { files: BTreeSet::new(), folders: BTreeSet::new() });

/// The temporary files. While this is held, an interrupt waits.
pub(super) fn locked() -> MutexGuard<'static, Temporary> {
    TEMPORARY.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Temporary {
    /// Notes a file that is about to be made: an interrupt between the two must leave nothing.
    pub fn add(&mut self, file: &Path) {
        self.files.insert(file.into());
    }

    /// Notes a folder that is about to be made.
    pub fn add_folder(&mut self, folder: &Path) {
        self.folders.insert(folder.into());
    }

    /// Forgets a file that is in its place, or was removed.
    pub fn forget(&mut self, file: &Path) -> bool {
        self.files.remove(file)
    }

    /// Forgets a folder, which stays.
    pub fn forget_folder(&mut self, folder: &Path) -> bool {
        self.folders.remove(folder)
    }

    /// Removes all of them from the disk.
    fn remove(&self) {
        for file in &self.files {
            let _ = fs::remove_file(file);
        }
        // A folder comes before those in it.
        for folder in self.folders.iter().rev() {
            let _ = fs::remove_dir(folder);
        }
    }
}

/// Removes every temporary file, and lets none be moved or made until the process ends with `status`.
pub fn discard_all_and_exit(status: u8) -> ! {
    let temporary = locked();
    temporary.remove();
    std::process::exit(status.into())
}

/// Removes every temporary file, and lets none be moved or made any more: for a process that is about to end, whose threads may be at
/// work still.
pub fn discard_all_before_exit() {
    let temporary = locked();
    temporary.remove();
    std::mem::forget(temporary);
}
