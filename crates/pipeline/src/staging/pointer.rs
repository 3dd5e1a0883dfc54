//! Files that tell, in the other folders of a transaction, where its journal is.

use std::{
    fs::File,
    io::{self, BufReader, Read},
    path::{Path, PathBuf},
};

use serde::{Deserialize, Serialize};

use super::{
    journal::{append, next, open},
    names::{self, Found},
    path_text::PathText,
    place::{absolute, folder_of, relative},
};

/// The longest pointer that is read, in bytes.
const MAX_BYTES: u64 = 64 << 10;

/// What the file says.
#[derive(Deserialize, Serialize)]
struct Pointer {
    mimesh_journal_at: PathText,
}

/// Writes into `file`, which is new, where `journal` is; both are absolute and without links.
pub(super) fn point_at(journal: &Path, file: &Path) -> io::Result<()> {
    let folder = file.parent().unwrap_or(Path::new(""));
    let mut out = File::options().write(true).create_new(true).open(file)?;
    append(&mut out, &Pointer { mimesh_journal_at: PathText::of(&relative(journal, folder)) })
}

/// The journal that the file `pointer` names, which has the identity `identity` as it has.
pub(super) fn pointed_at(pointer: &Path, identity: &str) -> Option<PathBuf> {
    let mut lines = BufReader::new(open(pointer, MAX_BYTES).ok()?);
    let name = next::<Pointer>(&mut lines).ok()??.mimesh_journal_at.path()?;
    let journal = absolute(&name, pointer.parent()?);
    // Nothing else is ever taken for a journal.
    (names::parse(&journal) == Some(Found::Journal(identity))).then_some(journal)
}

/// Whether `pointer` was never written to its end, since its writer was killed then: it points at nothing.
pub(super) fn is_unfinished(pointer: &Path) -> bool {
    let mut text = Vec::new();
    let read = open(pointer, MAX_BYTES).and_then(|mut file| file.read_to_end(&mut text));
    read.is_ok() && !text.contains(&b'\n')
}

/// Whether `folder` takes part in the transaction of the journal at `journal`: it holds the journal, or a file that points at it.
///
/// A journal names files anywhere, and may be a stranger's. Only who can write into a folder can make it take part.
pub(super) fn takes_part(folder: &Path, journal: &Path) -> bool {
    let Some(Found::Journal(identity)) = names::parse(journal) else { return false };
    if !folder.canonicalize().is_ok_and(|found| found == folder) {
        return false;
    }
    let points_at = || pointed_at(&folder.join(names::pointer(identity)), identity);
    folder == folder_of(journal) || points_at().is_some_and(|at| at == journal)
}
