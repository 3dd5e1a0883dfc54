//! Folders that one process at a time looks through.

use std::{
    fs::{File, TryLockError},
    io,
    path::Path,
    time::{Duration, Instant},
};

/// How long another process may hold a folder: it looks through it, and ends what was left there.
const PATIENCE: Duration = Duration::from_secs(30);

/// Between two looks at whether a folder is free.
const PAUSE: Duration = Duration::from_millis(5);

/// A folder in which no other transaction begins or ends, where the system can hold it.
#[derive(Debug)]
pub(super) struct FolderLock {
    _folder: Option<File>,
}

impl FolderLock {
    /// Waits until no other process holds `folder`.
    ///
    /// # Errors
    ///
    /// [`io::ErrorKind::ResourceBusy`] if another one does not let it go.
    pub fn take(folder: &Path) -> io::Result<Self> {
        // Not every system opens a folder.
        let Ok(opened) = File::open(folder) else { return Ok(Self { _folder: None }) };
        let started = Instant::now();
        loop {
            match opened.try_lock() {
                Ok(()) => return Ok(Self { _folder: Some(opened) }),
                Err(TryLockError::WouldBlock) if started.elapsed() < PATIENCE => std::thread::sleep(PAUSE),
                Err(TryLockError::WouldBlock) => return Err(io::ErrorKind::ResourceBusy.into()),
                Err(TryLockError::Error(_)) => return Ok(Self { _folder: None }),
            }
        }
    }
}
