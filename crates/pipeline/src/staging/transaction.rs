//! Files that are written together.

use std::{
    collections::{BTreeSet, HashMap, HashSet},
    fs::{self, File},
    io::{self, Write},
    path::{Path, PathBuf},
};

use mimesh_core::Error;
use mimesh_document::{Diagnostic, Kind, Location};
use mimesh_markers::IntoDiagnostic;

use super::{
    Staged, WrittenFile, disk,
    failure::{Failure, gone},
    folder_lock::FolderLock,
    journal::{Before, Ending, Journal, Move},
    moves::Moving,
    names,
    place::{folder_of, resolve},
    pointer::point_at,
    recovery, registry,
    survey::in_folder,
};

type Result<T> = std::result::Result<T, Diagnostic>;

/// Files that are being written and will be in their places all together; dropped, it leaves nothing.
#[derive(Debug)]
pub struct Transaction {
    /// `None` when it has ended.
    journal: Option<Journal>,
    /// The numbers of the places as the user named them.
    numbers: HashMap<PathBuf, usize>,
    /// The files, at the end of all links.
    files: Vec<PathBuf>,
    /// What tells where the journal is, in folders other than its own.
    pointers: Vec<PathBuf>,
    /// Folders that were made, those around others first.
    made: Vec<PathBuf>,
    /// Sentences about what others had left.
    warnings: Vec<String>,
}

impl Transaction {
    /// Begins to write `places`, of which the last is moved last; their folders are made as needed.
    ///
    /// What a transaction that was killed has left at one of these places is finished or undone first.
    ///
    /// # Errors
    ///
    /// [`Kind::Busy`] if another process is writing one of the files, else those of the system.
    pub fn begin<'p>(places: impl IntoIterator<Item = &'p Path>) -> Result<Self> {
        let mut begun = Self {
            journal: None,
            numbers: HashMap::new(),
            files: vec![],
            pointers: vec![],
            made: vec![],
            warnings: vec![],
        };
        let places: Vec<&Path> = places.into_iter().collect();
        let mut seen = HashSet::new();
        for place in &places {
            begun.make_folder(place)?;
            let file = resolve(place)?;
            if !seen.insert(file.clone()) && !begun.numbers.contains_key(*place) {
                let message = "two results lead to this file, one of them by a link";
                let diagnostic = Diagnostic::new(Kind::CannotWrite, message).at(Location::File(place.into()));
                return Err(diagnostic.hint("give each result a name of its own"));
            }
            begun.numbers.insert(place.to_path_buf(), begun.files.len());
            begun.files.push(file);
        }
        let Some((last, home)) = places.last().zip(begun.files.last().map(|file| folder_of(file).to_owned())) else {
            return Ok(begun);
        };
        let failed = |error| Error::write(last, error).into_diagnostic();
        let folders: BTreeSet<PathBuf> = begun.files.iter().map(|file| folder_of(file).to_owned()).collect();
        {
            let _lock = lock(&home)?;
            begun.clear(&home, &places)?;
            recovery::remove_unbegun(&home).map_err(failed)?;
            let made = |path: &Path| registry::locked().add(path);
            begun.journal = Some(Journal::create(&home, &begun.files, made).map_err(failed)?);
        }
        for folder in folders.iter().filter(|folder| **folder != home) {
            let _lock = lock(folder)?;
            begun.clear(folder, &places)?;
            begun.point_from(folder).map_err(failed)?;
        }
        Ok(begun)
    }

    /// Makes the folder of a file, and notes what was made.
    fn make_folder(&mut self, place: &Path) -> Result<()> {
        let folder = folder_of(place);
        let missing: Vec<&Path> =
            folder.ancestors().take_while(|folder| !folder.as_os_str().is_empty() && !folder.exists()).collect();
        for folder in missing.into_iter().rev() {
            registry::locked().add_folder(folder);
            match fs::create_dir(folder) {
                Ok(()) => self.made.push(folder.into()),
                // Somebody else was first, or `..` leads to one that is there.
                Err(_) if folder.is_dir() => _ = registry::locked().forget_folder(folder),
                Err(error) => {
                    registry::locked().forget_folder(folder);
                    return Err(Error::write(folder, error).into_diagnostic());
                }
            }
        }
        Ok(())
    }

    /// Ends what other transactions have left at one of the files in `folder`.
    fn clear(&mut self, folder: &Path, places: &[&Path]) -> Result<()> {
        let found = in_folder(folder, &self.files);
        if let Some(refused) = found.refused.into_iter().next() {
            return Err(refused);
        }
        self.warnings.extend(found.warnings);
        for other in found.others {
            let place = self.files.iter().position(|file| *file == other.file).map_or(folder, |number| places[number]);
            self.warnings.extend(other.recover(place)?);
        }
        Ok(())
    }

    /// Sentences about what other transactions had left at the places, and what has become of it.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    fn point_from(&mut self, folder: &Path) -> io::Result<()> {
        let Some(journal) = &self.journal else { return Ok(()) };
        let pointer = folder.join(names::pointer(&journal.identity));
        registry::locked().add(&pointer);
        // One that is not written to its end is removed too.
        self.pointers.push(pointer.clone());
        point_at(&journal.path, &pointer)
    }

    /// An empty temporary file for `place`, one of those that the transaction began with, and the file to write to.
    ///
    /// # Errors
    ///
    /// Those of the system about `place`.
    pub fn create(&self, place: &Path) -> Result<(Staged, File)> {
        let Some((number, journal)) = self.numbers.get(place).copied().zip(self.journal.as_ref()) else {
            let message = format!("{} was not announced before it was written", place.display());
            return Err(Diagnostic::new(Kind::Internal, message));
        };
        let part = folder_of(&self.files[number]).join(names::part(&journal.identity, number));
        Staged::create(part, number, place)
    }

    /// Writes the file for `place` to a temporary file.
    ///
    /// # Errors
    ///
    /// Those of `write`, and of the system about `place`.
    pub fn stage(&self, place: &Path, write: impl FnOnce(&mut dyn Write) -> mimesh_core::Result<()>) -> Result<Staged> {
        let (staged, file) = self.create(place)?;
        staged.fill(file, write)
    }

    /// Writes `bytes` for `place`, as [`stage`](Self::stage).
    ///
    /// # Errors
    ///
    /// Those of the system about `place`.
    pub fn stage_bytes(&self, place: &Path, bytes: &[u8]) -> Result<Staged> {
        self.stage(place, |out| out.write_all(bytes).map_err(|error| Error::write(place, error)))
    }

    /// Moves files into their places, in this order. If one cannot be moved, all that were there before are put back.
    ///
    /// # Errors
    ///
    /// Those of the system about the file that cannot be moved. If something cannot be put back either, the error names it, and the next
    /// transaction with one of these places ends it.
    pub fn commit(mut self, files: Vec<Staged>) -> Result<Vec<WrittenFile>> {
        // While the lock is held an interrupt waits, so that it finds all files in place or none.
        let mut temporary = registry::locked();
        let done = self.move_all(&files);
        if let Err(failure) = &done
            && !failure.is_undone
        {
            // The journal and what it names stay.
            for file in self.temporary_files(&files) {
                temporary.forget(&file);
            }
            self.made.drain(..).for_each(|folder| _ = temporary.forget_folder(&folder));
            self.pointers.clear();
            self.journal = None;
            return Err(failure.diagnostic.clone());
        }
        for file in files.iter().filter(|file| !file.part.exists()) {
            temporary.forget(&file.part);
        }
        if done.is_ok() {
            self.made.drain(..).for_each(|folder| _ = temporary.forget_folder(&folder));
        }
        drop(temporary);
        done.map_err(|failure| failure.diagnostic)?;
        Ok(files.iter().map(Staged::written).collect())
    }

    fn move_all(&mut self, files: &[Staged]) -> std::result::Result<(), Box<Failure>> {
        let Some(journal) = &mut self.journal else { return Ok(()) };
        let moves = |file: &Staged| {
            let WrittenFile { bytes, blake3, .. } = file.written();
            let before = fs::symlink_metadata(&self.files[file.number]).ok();
            let replaces = before.is_some();
            Move { place: file.number, bytes, blake3, replaces, before: before.and_then(|found| Before::of(&found)) }
        };
        let moves: Vec<Move> = files.iter().map(moves).collect();
        let is_journaled = files.len() > 1 || moves.iter().any(|file| file.replaces);
        let moving = |about: &Move| Moving::new(&journal.identity, &self.files[about.place], about.clone());
        let moving: Vec<Moving> = moves.iter().map(moving).collect();
        let folders: BTreeSet<&Path> = files.iter().map(|file| folder_of(&self.files[file.number])).collect();
        let report = files.last().map_or(Path::new(""), Staged::place);
        let at_report = |error| Failure::whole(Error::write(report, error).into_diagnostic());
        if let Some((file, _)) = files.iter().zip(&moving).find(|(_, moving)| !moving.is_ready()) {
            return Err(Failure::whole(gone(file.place(), "its temporary file was removed or changed")));
        }
        if !journal.is_there() {
            return Err(Failure::whole(gone(report, "the journal of this run was removed or replaced")));
        }
        // A new file that is alone is moved whole, with or without a journal.
        if is_journaled {
            folders.iter().try_for_each(|folder| disk::sync_folder(folder)).map_err(at_report)?;
            journal.begin_moves(moves).map_err(at_report)?;
        }
        for (file, staged) in moving.iter().zip(files) {
            if let Err(error) = file.commit() {
                return Err(Failure::after_undoing(staged.place(), &error, &moving, journal));
            }
        }
        if let Err(error) = folders.iter().try_for_each(|folder| disk::sync_folder(folder)) {
            return Err(Failure::after_undoing(report, &error, &moving, journal));
        }
        // All is in place. What cannot be removed now, the next transaction removes.
        let is_told = !is_journaled || journal.end(Ending::Done).is_ok();
        for file in &moving {
            if !is_told || file.clean_up().is_err() {
                self.leave();
                break;
            }
        }
        Ok(())
    }

    /// Leaves the journal and its pointers to the next transaction.
    fn leave(&mut self) {
        self.pointers.clear();
        self.journal = None;
    }

    /// All temporary files that may be there.
    fn temporary_files(&self, files: &[Staged]) -> Vec<PathBuf> {
        let journal = self.journal.iter().map(|journal| &journal.path);
        journal.chain(&self.pointers).chain(files.iter().map(|file| &file.part)).cloned().collect()
    }
}

impl Drop for Transaction {
    fn drop(&mut self) {
        let mut temporary = registry::locked();
        let mut files = self.pointers.clone();
        // The journal goes last, and not before the others, which are found by it.
        files.extend(self.journal.iter().map(|journal| journal.path.clone()));
        let _ = files.iter().try_for_each(|file| disk::remove(file));
        files.iter().for_each(|file| _ = temporary.forget(file));
        for folder in self.made.drain(..).rev() {
            let _ = fs::remove_dir(&folder);
            temporary.forget_folder(&folder);
        }
    }
}

/// Waits until no other process looks through `folder`.
fn lock(folder: &Path) -> Result<FolderLock> {
    FolderLock::take(folder).map_err(|error| match error.kind() {
        io::ErrorKind::ResourceBusy => {
            let diagnostic = Diagnostic::new(Kind::Busy, "another process has held this folder for long");
            diagnostic.at(Location::File(folder.into())).hint("wait until it has ended, or write into another folder")
        }
        _ => Error::write(folder, error).into_diagnostic(),
    })
}
