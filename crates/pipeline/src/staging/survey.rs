//! Which other transactions have to do with the files of one, found without touching anything.

use std::{
    collections::{BTreeSet, HashSet},
    fs, io,
    path::{Path, PathBuf},
};

use mimesh_document::{Diagnostic, Kind, Location, files::io_message};

use super::{
    journal::{self, Contents, Record},
    names::{self, Found},
    owner::other_owner,
    place::{folder_of, resolve},
    pointer::pointed_at,
    recovery::Other,
};

/// What there is in the folders of a run's results beside results.
#[derive(Debug, Default)]
pub struct Survey {
    /// The transactions that write one of the places, each with the first of these.
    pub interrupted: Vec<(PathBuf, Interrupted)>,
    /// Why a run cannot write there.
    pub refused: Vec<Diagnostic>,
    /// What is left alone, and why.
    pub warnings: Vec<String>,
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
    /// It was killed when it had moved all its files, or moved them back, and only temporary ones were left.
    Ended,
}

/// The journals in a folder that are of interest, and those that cannot be read.
#[derive(Debug, Default)]
pub(super) struct InFolder {
    /// Those that name one of our files.
    pub others: Vec<Other>,
    pub refused: Vec<Diagnostic>,
    pub warnings: Vec<String>,
}

/// Looks at the places of a run without doing anything about what is there.
pub fn survey<'p>(places: impl IntoIterator<Item = &'p Path>) -> Survey {
    let files: Vec<PathBuf> = places.into_iter().filter_map(|place| resolve(place).ok()).collect();
    let folders: BTreeSet<&Path> = files.iter().map(|file| folder_of(file)).collect();
    let mut survey = Survey::default();
    let mut others = Vec::new();
    for folder in folders {
        let found = in_folder(folder, &files);
        survey.refused.extend(found.refused);
        survey.warnings.extend(found.warnings);
        others.extend(found.others);
    }
    others.sort_by(|a: &Other, b| a.journal.cmp(&b.journal));
    others.dedup_by(|a, b| a.journal == b.journal);
    for other in others {
        let Some((other, state)) = state(other) else { continue };
        survey.refused.extend(if state == Interrupted::Alive { None } else { other.refusal() });
        survey.interrupted.push((other.file, state));
    }
    survey
}

/// The transactions in `folder` that write one of `files`, which are at the end of all links.
pub(super) fn in_folder(folder: &Path, files: &[PathBuf]) -> InFolder {
    let mut found = InFolder::default();
    let entries = match fs::read_dir(folder) {
        Ok(entries) => entries,
        // A folder that is yet to be made holds nothing.
        Err(error) if error.kind() == io::ErrorKind::NotFound => return found,
        Err(error) => {
            let message = format!("{}, so that nobody can see who writes there", io_message("look into", &error));
            let diagnostic = Diagnostic::new(Kind::CannotWrite, message).at(Location::File(folder.into()));
            found.refused.push(diagnostic.hint("allow reading the folder, or write into another one"));
            return found;
        }
    };
    let ours: HashSet<&Path> = files.iter().map(PathBuf::as_path).collect();
    let journals: BTreeSet<PathBuf> = entries
        .filter_map(Result::ok)
        .filter_map(|entry| match names::parse(&entry.path())? {
            Found::Journal(_) => Some(entry.path()),
            Found::Pointer(identity) => pointed_at(&entry.path(), identity),
        })
        .collect();
    for journal in journals {
        match Contents::read(&journal) {
            Ok(Contents::Record(record)) => found.others.extend(at_ours(journal, record, &ours)),
            Ok(Contents::Unbegun) => {}
            Ok(Contents::Foreign) if journal::is_alive(&journal) => {
                let message = "another process, of another version of mimesh, is writing into this folder";
                let diagnostic = Diagnostic::new(Kind::Busy, message).at(Location::File(journal));
                found.refused.push(diagnostic.hint("wait until it has ended, or write into another folder"));
            }
            Ok(Contents::Foreign) => found.warnings.push(format!(
                "{}: another version of mimesh wrote this journal, or it was changed, so it is left alone; remove it if no run of that \
                 version is to be ended",
                journal.display()
            )),
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            Err(error) => found.refused.push(unusable(&journal, &error)),
        }
    }
    found
}

/// A file that has the name of a journal, and that nobody can read as one.
fn unusable(journal: &Path, error: &io::Error) -> Diagnostic {
    let owner = other_owner(journal, folder_of(journal)).map_or(String::new(), |user| format!(" (of user {user})"));
    let reason = io_message("read", error);
    let message =
        format!("this is the name of a journal, which tells of results that are being written: {reason}{owner}");
    let hint = "remove it if no mimesh is at work there, on no machine, or write into another folder";
    Diagnostic::new(Kind::CannotWrite, message).at(Location::File(journal.into())).hint(hint)
}

/// The transaction of a journal, if it writes one of `ours`.
fn at_ours(journal: PathBuf, record: Record, ours: &HashSet<&Path>) -> Option<Other> {
    let file = record.places.iter().find(|file| ours.contains(file.as_path()))?.clone();
    Some(Other { journal, file, record })
}

/// How far a transaction has come; `None` if it has ended since it was found.
fn state(other: Other) -> Option<(Other, Interrupted)> {
    if journal::is_alive(&other.journal) {
        return Some((other, Interrupted::Alive));
    }
    // Its writer may have gone on until just now.
    let Ok(Contents::Record(record)) = Contents::read(&other.journal) else { return None };
    let other = Other { record, ..other };
    let state = match (&other.record.moves, other.record.ending) {
        (_, Some(_)) => Interrupted::Ended,
        (Some(_), None) => {
            let moving = other.moving();
            let moved = moving.iter().filter(|file| fs::symlink_metadata(&file.part).is_err()).count();
            Interrupted::Moving { moved, of: moving.len() }
        }
        (None, None) => Interrupted::Writing,
    };
    Some((other, state))
}
