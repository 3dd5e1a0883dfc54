//! What transactions that were killed have left: found, finished or undone.

use std::{
    fs::{self, File, TryLockError},
    io,
    path::{Path, PathBuf},
    time::{Duration, SystemTime, UNIX_EPOCH},
};

use super::{
    disk,
    journal::{self, Journal, Record},
    moves::Moving,
    names::{self, Found},
    place::{folder_of, resolve},
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

/// A transaction that has to do with one of our files.
#[derive(Debug)]
pub(super) struct Other {
    /// Its journal.
    pub journal: PathBuf,
    /// The first of our files that it writes.
    pub file: PathBuf,
    record: Record,
}

/// What `check` and `plan` tell of a transaction at one of the places of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interrupted {
    /// It is under way.
    Alive,
    /// It was killed before it moved anything.
    Writing,
    /// It was killed when some of its files were moved.
    Moving {
        /// Files that are in their places.
        moved: usize,
        /// All its files.
        of: usize,
    },
}

impl FolderLock {
    /// Waits until no other process holds `folder`.
    pub fn take(folder: &Path) -> io::Result<Self> {
        // Not every system opens a folder.
        let Ok(opened) = File::open(folder) else { return Ok(Self { _folder: None }) };
        let started = std::time::Instant::now();
        loop {
            match opened.try_lock() {
                Ok(()) => return Ok(Self { _folder: Some(opened) }),
                Err(TryLockError::WouldBlock) if started.elapsed() < PATIENCE => std::thread::sleep(PAUSE),
                Err(TryLockError::WouldBlock) => {
                    return Err(io::Error::new(io::ErrorKind::ResourceBusy, "another process holds the folder"));
                }
                Err(TryLockError::Error(_)) => return Ok(Self { _folder: None }),
            }
        }
    }
}

/// Removes the journals in `folder`, which we hold, of transactions that were killed before they had said anything.
pub(super) fn remove_unbegun(folder: &Path) -> io::Result<()> {
    for entry in fs::read_dir(folder)?.filter_map(Result::ok) {
        let path = entry.path();
        if matches!(names::parse(&path), Some(Found::Journal(_)))
            && journal::is_unbegun(&path)
            && matches!(Journal::take_over(&path), Ok(Some(_)))
        {
            disk::remove(&path)?;
        }
    }
    Ok(())
}

/// The transactions in `folder` that write one of `files`, which are at the end of all links.
pub(super) fn at(folder: &Path, files: &[PathBuf]) -> Vec<Other> {
    let ours: std::collections::HashSet<&Path> = files.iter().map(PathBuf::as_path).collect();
    let mut journals: Vec<PathBuf> = fs::read_dir(folder)
        .into_iter()
        .flatten()
        .filter_map(Result::ok)
        .filter_map(|entry| match names::parse(&entry.path())? {
            Found::Journal(_) => Some(entry.path()),
            Found::Pointer(_) => journal::pointed_at(&entry.path()),
        })
        .collect();
    journals.sort();
    let other = |journal: PathBuf| {
        let record = Record::read(&journal).ok()??;
        let file = record.places.iter().find(|file| ours.contains(file.as_path()))?.clone();
        Some(Other { journal, file, record })
    };
    journals.into_iter().filter_map(other).collect()
}

/// The transactions that write one of `places`, without doing anything about them; each with the place.
pub fn interrupted<'p>(places: impl IntoIterator<Item = &'p Path>) -> Vec<(PathBuf, Interrupted)> {
    let files: Vec<PathBuf> = places.into_iter().filter_map(|place| resolve(place).ok()).collect();
    let folders: std::collections::BTreeSet<&Path> = files.iter().map(|file| folder_of(file)).collect();
    let mut others: Vec<Other> = folders.into_iter().flat_map(|folder| at(folder, &files)).collect();
    others.sort_by(|a, b| a.journal.cmp(&b.journal));
    others.dedup_by(|a, b| a.journal == b.journal);
    others.into_iter().map(|other| (other.file.clone(), other.state())).collect()
}

impl Other {
    /// Finishes or undoes it; `false` if its writer lives.
    pub fn recover(&self) -> io::Result<bool> {
        let journal = match Journal::take_over(&self.journal) {
            Ok(Some(journal)) => journal,
            Ok(None) => return Ok(false),
            Err(error) => return ended(error),
        };
        // It may have gone on, or have ended, since it was read.
        let record = match Record::read(&self.journal) {
            Ok(Some(record)) => record,
            Ok(None) => return Ok(true),
            Err(error) => return ended(error),
        };
        let moving = moving(&journal.identity, &record);
        if record.is_done {
            moving.iter().try_for_each(Moving::clean_up)?;
        } else if moving.iter().all(Moving::can_finish) {
            moving.iter().try_for_each(Moving::finish)?;
            sync_folders(&record)?;
            moving.iter().try_for_each(Moving::clean_up)?;
        } else {
            moving.iter().rev().try_for_each(Moving::undo)?;
            sync_folders(&record)?;
        }
        remove_leftovers(&journal, &record)?;
        Ok(true)
    }

    /// When it began, for a message.
    pub fn since(&self) -> String {
        let began = UNIX_EPOCH + Duration::from_secs(self.record.started);
        match SystemTime::now().duration_since(began).map_or(0, |age| age.as_secs()) {
            0..=119 => ", since a moment ago".into(),
            seconds @ 120..=7199 => format!(", since {} minutes ago", seconds / 60),
            seconds => format!(", since {} hours ago", seconds / 3600),
        }
    }

    fn state(&self) -> Interrupted {
        if journal::is_alive(&self.journal) {
            return Interrupted::Alive;
        }
        match names::parse(&self.journal) {
            Some(Found::Journal(identity)) if self.record.moves.is_some() => {
                let moving = moving(identity, &self.record);
                let moved = moving.iter().filter(|file| !file.part.exists()).count();
                Interrupted::Moving { moved, of: moving.len() }
            }
            _ => Interrupted::Writing,
        }
    }
}

/// Whether a journal that cannot be read is gone, since its transaction has ended meanwhile.
fn ended(error: io::Error) -> io::Result<bool> {
    if error.kind() == io::ErrorKind::NotFound { Ok(true) } else { Err(error) }
}

fn moving(identity: &str, record: &Record) -> Vec<Moving> {
    let moves = record.moves.iter().flatten();
    moves.map(|about| Moving::new(identity, &record.places[about.place], about.clone())).collect()
}

fn folders(record: &Record) -> std::collections::BTreeSet<&Path> {
    record.places.iter().map(|place| folder_of(place)).filter(|folder| folder.is_dir()).collect()
}

fn sync_folders(record: &Record) -> io::Result<()> {
    folders(record).into_iter().try_for_each(disk::sync_folder)
}

/// Removes everything that has the identity of `journal`, and at last the journal.
fn remove_leftovers(journal: &Journal, record: &Record) -> io::Result<()> {
    for folder in folders(record) {
        for entry in fs::read_dir(folder)? {
            let entry = entry?;
            if names::belongs_to(&entry.file_name(), &journal.identity) {
                disk::remove(&entry.path())?;
            }
        }
        disk::remove(&folder.join(names::pointer(&journal.identity)))?;
    }
    disk::remove(&journal.path)
}
