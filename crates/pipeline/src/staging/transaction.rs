//! Files that are written together.

use std::{
    collections::{BTreeSet, HashMap},
    fs::{self, File},
    io::{self, Write},
    path::{Path, PathBuf},
};

use mimesh_core::Error;
use mimesh_document::{Diagnostic, Kind, Location};
use mimesh_markers::IntoDiagnostic;

use super::{
    Staged, WrittenFile, disk,
    journal::{self, Journal, Move},
    moves::Moving,
    names,
    place::{folder_of, resolve},
    recovery::{self, FolderLock},
    registry,
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
        let mut begun = Self { journal: None, numbers: HashMap::new(), files: vec![], pointers: vec![], made: vec![] };
        let places: Vec<&Path> = places.into_iter().collect();
        for place in &places {
            begun.make_folder(place)?;
            let file = resolve(place)?;
            begun.numbers.insert(place.to_path_buf(), begun.files.len());
            begun.files.push(file);
        }
        let Some((last, home)) = places.last().zip(begun.files.last().map(|file| folder_of(file).to_owned())) else {
            return Ok(begun);
        };
        let failed = |error| Error::write(last, error).into_diagnostic();
        let folders: BTreeSet<PathBuf> = begun.files.iter().map(|file| folder_of(file).to_owned()).collect();
        {
            let _lock = FolderLock::take(&home).map_err(failed)?;
            recovery::remove_unbegun(&home).map_err(failed)?;
            begun.clear(&home, &places)?;
            let made = |path: &Path| registry::locked().add(path);
            begun.journal = Some(Journal::create(&home, &begun.files, made).map_err(failed)?);
        }
        for folder in folders.iter().filter(|folder| **folder != home) {
            let _lock = FolderLock::take(folder).map_err(failed)?;
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
    fn clear(&self, folder: &Path, places: &[&Path]) -> Result<()> {
        for other in recovery::at(folder, &self.files) {
            let place = self.files.iter().position(|file| *file == other.file).map_or(folder, |number| places[number]);
            if !other.recover().map_err(|error| Error::write(place, error).into_diagnostic())? {
                let diagnostic =
                    Diagnostic::new(Kind::Busy, format!("another process is writing this file{}", other.since()));
                let hint = format!(
                    "wait until it has ended, or write elsewhere; if no mimesh is at work there, on no machine, remove {}",
                    other.journal.display()
                );
                return Err(diagnostic.at(Location::File(place.into())).hint(hint));
            }
        }
        Ok(())
    }

    fn point_from(&mut self, folder: &Path) -> io::Result<()> {
        let Some(journal) = &self.journal else { return Ok(()) };
        let pointer = folder.join(names::pointer(&journal.identity));
        registry::locked().add(&pointer);
        // One that is not written to its end is removed too.
        self.pointers.push(pointer.clone());
        journal::point_at(&journal.path, &pointer)
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
            Move { place: file.number, bytes, blake3, replaces: self.files[file.number].exists() }
        };
        let moves: Vec<Move> = files.iter().map(moves).collect();
        let moving = |about: &Move| Moving::new(&journal.identity, &self.files[about.place], about.clone());
        let moving: Vec<Moving> = moves.iter().map(moving).collect();
        let folders: BTreeSet<&Path> = files.iter().map(|file| folder_of(&self.files[file.number])).collect();
        let at_report = |error| Failure::whole(files.last().map_or(Path::new(""), Staged::place), error);
        // A single file is moved whole, with or without a journal.
        if files.len() > 1 {
            folders.iter().try_for_each(|folder| disk::sync_folder(folder)).map_err(at_report)?;
            journal.begin_moves(moves).map_err(at_report)?;
        }
        for (file, staged) in moving.iter().zip(files) {
            if let Err(error) = file.finish() {
                return Err(Failure::after_undoing(staged.place(), &error, &moving));
            }
        }
        if let Err(error) = folders.iter().try_for_each(|folder| disk::sync_folder(folder)) {
            return Err(Failure::after_undoing(files.last().map_or(Path::new(""), Staged::place), &error, &moving));
        }
        // All is in place. What cannot be removed now, the next transaction removes.
        let is_told = files.len() <= 1 || journal.end_moves().is_ok();
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

/// Why files were not moved.
struct Failure {
    diagnostic: Diagnostic,
    /// Whether everything is as it was.
    is_undone: bool,
}

impl Failure {
    /// A failure before anything was moved.
    fn whole(place: &Path, error: io::Error) -> Box<Self> {
        Box::new(Self { diagnostic: Error::write(place, error).into_diagnostic(), is_undone: true })
    }

    /// The failure `error` of moving to `place`, after all of `moving` was put back.
    fn after_undoing(place: &Path, error: &io::Error, moving: &[Moving]) -> Box<Self> {
        let diagnostic = Error::write(place, io::Error::new(error.kind(), error.to_string())).into_diagnostic();
        let stuck: Vec<_> = moving
            .iter()
            .rev()
            .filter(|file| file.undo().is_err())
            .map(|file| file.place.display().to_string())
            .collect();
        if stuck.is_empty() {
            return Box::new(Self { diagnostic, is_undone: true });
        }
        let message = format!(
            "{}; these could not be put back, so that the results are of two runs: {}",
            diagnostic.message,
            stuck.join(", ")
        );
        let diagnostic =
            Diagnostic { message, ..diagnostic }.hint("run it again: the next run ends what this one has left");
        Box::new(Self { diagnostic, is_undone: false })
    }
}

/// Writes a whole file.
///
/// # Errors
///
/// Those of the system about `place`.
pub fn write(place: &Path, bytes: &[u8]) -> Result<()> {
    write_all(&[(place, bytes)]).map(drop)
}

/// Writes whole files together.
///
/// # Errors
///
/// Those of the system about one of the places.
pub fn write_all(files: &[(&Path, &[u8])]) -> Result<Vec<WrittenFile>> {
    let transaction = Transaction::begin(files.iter().map(|(place, _)| *place))?;
    let staged = files.iter().map(|(place, bytes)| transaction.stage_bytes(place, bytes)).collect::<Result<_>>()?;
    transaction.commit(staged)
}
