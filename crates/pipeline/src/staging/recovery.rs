//! What transactions that were killed have left: finished or undone.
//!
//! A journal is believed as far as its folder reaches. It moves files in its own folder, and in folders that point at it, and nowhere
//! else; and that of another user moves nothing. So a folder from a stranger cannot have files moved or removed elsewhere.

use std::{
    collections::BTreeSet,
    fs, io,
    path::{Path, PathBuf},
    time::{Duration, SystemTime, UNIX_EPOCH},
};

use mimesh_core::Error;
use mimesh_document::{Diagnostic, Kind, Location};
use mimesh_markers::IntoDiagnostic;

use super::{
    disk,
    journal::{self, Contents, Ending, Journal, Record},
    moves::Moving,
    names::{self, Found},
    owner::other_owner,
    place::folder_of,
    pointer::{is_unfinished, takes_part},
};

/// A transaction that has to do with one of our files.
#[derive(Debug)]
pub(super) struct Other {
    /// Its journal.
    pub journal: PathBuf,
    /// The first of our files that it writes.
    pub file: PathBuf,
    /// What the journal says.
    pub record: Record,
}

/// Removes the journals in `folder`, which we hold, of our transactions that were killed before they had said anything.
pub(super) fn remove_unbegun(folder: &Path) -> io::Result<()> {
    for entry in fs::read_dir(folder)?.filter_map(Result::ok) {
        let path = entry.path();
        if matches!(names::parse(&path), Some(Found::Journal(_)))
            && matches!(Contents::read(&path), Ok(Contents::Unbegun))
            && other_owner(&path, folder).is_none()
            && matches!(Journal::take_over(&path), Ok(Some(_)))
        {
            disk::remove(&path)?;
        }
    }
    Ok(())
}

impl Other {
    /// Finishes or undoes it, for the file that the user calls `place`; sentences about what was done.
    ///
    /// # Errors
    ///
    /// [`Kind::Busy`] if its writer lives, that it is not ours to end, and those of the system.
    pub fn recover(&self, place: &Path) -> Result<Vec<String>, Diagnostic> {
        let failed = |error: io::Error| Error::write(place, error).into_diagnostic();
        let at_journal = |error: io::Error| Error::write(&self.journal, error).into_diagnostic();
        if other_owner(&self.journal, folder_of(&self.journal)).is_some() {
            return Err(self
                .refusal()
                .filter(|_| !journal::is_alive(&self.journal))
                .unwrap_or_else(|| self.busy(place)));
        }
        let mut journal = match Journal::take_over(&self.journal) {
            Ok(Some(journal)) => journal,
            Ok(None) => return Err(self.busy(place)),
            Err(error) => return ended(error).map_err(at_journal),
        };
        // It may have gone on, or have ended, since it was read.
        let record = match Contents::read(&self.journal) {
            Ok(Contents::Record(record)) => record,
            Ok(_) => return Ok(vec![]),
            Err(error) => return ended(error).map_err(at_journal),
        };
        let again = Self { journal: self.journal.clone(), file: self.file.clone(), record };
        again.refusal().map_or(Ok(()), Err)?;
        again.end(&mut journal).map_err(failed)
    }

    /// Why it is not ours to end, if so.
    pub fn refusal(&self) -> Option<Diagnostic> {
        let refused = |message: String, hint: String| {
            Some(Diagnostic::new(Kind::CannotWrite, message).at(Location::File(self.journal.clone())).hint(hint))
        };
        if let Some(user) = other_owner(&self.journal, folder_of(&self.journal)) {
            let file = self.file.display();
            let message = format!(
                "a run of another user (number {user}) was stopped before its results were complete, among them {file}"
            );
            let stem = self.journal.file_stem().unwrap_or_default().to_string_lossy();
            let hint = format!(
                "let that user run it again, which ends it, or remove all files there that begin with `{stem}`"
            );
            return refused(message, hint);
        }
        let is_moving = self.record.moves.is_some() && self.record.ending.is_none();
        let strange = if is_moving { self.folders().find(|folder| !takes_part(folder, &self.journal)) } else { None };
        let folder = strange?.display();
        let message = format!("this journal names files in {folder}, which has no part in it, so nothing was moved");
        let hint = "remove it: it came with files of somebody else, or a file `.mimesh-….elsewhere` was removed there";
        refused(message, hint.into())
    }

    fn end(&self, journal: &mut Journal) -> io::Result<Vec<String>> {
        let moving = self.moving();
        let file = self.file.display();
        let mut told = Vec::new();
        let moved = moving.iter().filter(|file| fs::symlink_metadata(&file.part).is_err()).count();
        let mut note = |moving: &Moving, aside: Option<PathBuf>| {
            told.extend(aside.map(|aside| {
                format!(
                    "{}: it was edited after a run was stopped while it moved its results; what was edited is kept as {}",
                    moving.place.display(),
                    aside.display()
                )
            }));
        };
        match (&self.record.moves, self.record.ending) {
            // Only temporary files are left.
            (_, Some(_)) => {}
            (None, None) => {
                told.push(format!(
                    "{file}: a run was stopped before its results were complete; what it left was removed"
                ));
            }
            (Some(_), None) if moving.iter().all(Moving::can_finish) => {
                for one in &moving {
                    note(one, one.finish()?);
                }
                self.sync_folders()?;
                // A disk that is full does not keep the next run from ending this one again.
                let _ = journal.end(Ending::Done);
                moving.iter().try_for_each(Moving::clean_up)?;
                told.push(format!(
                    "{file}: a run was stopped when {moved} of its {} results were in place; now all of them are",
                    moving.len()
                ));
            }
            (Some(_), None) => {
                for one in moving.iter().rev() {
                    note(one, one.undo()?);
                }
                self.sync_folders()?;
                let _ = journal.end(Ending::Undone);
                told.push(format!(
                    "{file}: a run was stopped when {moved} of its {} results were in place, and some were lost; those that were there \
                     before it are in place again",
                    moving.len()
                ));
            }
        }
        self.remove_leftovers(journal)?;
        Ok(told)
    }

    /// Removes everything that has the identity of `journal`, and at last the journal.
    fn remove_leftovers(&self, journal: &Journal) -> io::Result<()> {
        for folder in self.folders() {
            let pointer = folder.join(names::pointer(&journal.identity));
            if !takes_part(folder, &self.journal) {
                // Nothing was written there yet.
                if is_unfinished(&pointer) {
                    disk::remove(&pointer)?;
                }
                continue;
            }
            for entry in fs::read_dir(folder)? {
                let entry = entry?;
                if names::belongs_to(&entry.file_name(), &journal.identity) {
                    disk::remove(&entry.path())?;
                }
            }
            disk::remove(&pointer)?;
        }
        disk::remove(&journal.path)
    }

    fn sync_folders(&self) -> io::Result<()> {
        self.folders().try_for_each(disk::sync_folder)
    }

    /// The folders of its files that are there.
    fn folders(&self) -> impl Iterator<Item = &Path> {
        let folders: BTreeSet<&Path> = self.record.places.iter().map(|place| folder_of(place)).collect();
        folders.into_iter().filter(|folder| folder.is_dir())
    }

    /// Its files on their way.
    pub fn moving(&self) -> Vec<Moving> {
        let Some(Found::Journal(identity)) = names::parse(&self.journal) else { return vec![] };
        let moves = self.record.moves.iter().flatten();
        moves.map(|about| Moving::new(identity, &self.record.places[about.place], about.clone())).collect()
    }

    fn busy(&self, place: &Path) -> Diagnostic {
        let message = format!("another process is writing this file{}", self.since());
        let hint = format!(
            "wait until it has ended, or write elsewhere; if no mimesh is at work there, on no machine, remove {}",
            self.journal.display()
        );
        Diagnostic::new(Kind::Busy, message).at(Location::File(place.into())).hint(hint)
    }

    /// When it began, for a message.
    fn since(&self) -> String {
        let began = UNIX_EPOCH.checked_add(Duration::from_secs(self.record.started));
        let age = began.and_then(|began| SystemTime::now().duration_since(began).ok());
        match age.map_or(0, |age| age.as_secs()) {
            0..=119 => ", since a moment ago".into(),
            seconds @ 120..=7199 => format!(", since {} minutes ago", seconds / 60),
            seconds => format!(", since {} hours ago", seconds / 3600),
        }
    }
}

/// Nothing is left to do if a journal that cannot be read is gone, since its transaction has ended meanwhile.
fn ended(error: io::Error) -> io::Result<Vec<String>> {
    if error.kind() == io::ErrorKind::NotFound { Ok(vec![]) } else { Err(error) }
}
