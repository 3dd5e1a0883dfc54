//! The journal of a transaction: what it will write, then what it moves.
//!
//! A journal is a text file of at most three lines, each after the hash of its own contents, so that a line that was cut counts as
//! none: the places, before anything is written; the moves, when everything is written and nothing is moved; and the word that all
//! is moved.

use std::{
    fs::{File, TryLockError},
    io::{self, BufRead, BufReader, Read},
    path::{Path, PathBuf},
    time::{Duration, SystemTime, UNIX_EPOCH},
};

use serde::{Deserialize, Serialize, de::DeserializeOwned};

use super::{
    disk, names,
    place::{absolute, relative},
};
use crate::json::to_bytes;

/// The longest journal that is read, in bytes: some million places.
const MAX_BYTES: u64 = 1 << 30;

/// The journal of a transaction that lives in this process.
#[derive(Debug)]
pub(super) struct Journal {
    /// Locked until it is dropped.
    file: File,
    /// Where it is.
    pub path: PathBuf,
    /// The random name that all its files have in common.
    pub identity: String,
}

/// What the journal of a transaction says.
#[derive(Debug)]
pub(super) struct Record {
    /// When the transaction began, in seconds since 1970.
    pub started: u64,
    /// The files that it writes, absolute.
    pub places: Vec<PathBuf>,
    /// The files that are moved, once everything is written.
    pub moves: Option<Vec<Move>>,
    /// Whether all is moved.
    pub is_done: bool,
}

/// A file that is moved into its place.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub(super) struct Move {
    /// The number of its place among those of the journal.
    pub place: usize,
    /// Its size.
    pub bytes: u64,
    /// The hash of its contents.
    pub blake3: String,
    /// Whether there was a file before.
    pub replaces: bool,
}

/// The first line.
#[derive(Deserialize, Serialize)]
struct Head {
    mimesh_journal: u32,
    started: u64,
    /// Seen from the folder of the journal, since a volume may be mounted elsewhere.
    places: Vec<Name>,
}

/// The second line.
#[derive(Deserialize, Serialize)]
struct Moves {
    moves: Vec<Move>,
}

/// The third line.
#[derive(Deserialize, Serialize)]
struct Done {
    done: bool,
}

/// What the file says that tells where the journal is.
#[derive(Deserialize, Serialize)]
struct Pointer {
    mimesh_journal_at: Name,
}

/// A path. Those that are no Unicode are written as bytes.
#[derive(Deserialize, Serialize)]
#[serde(untagged)]
enum Name {
    Text(String),
    Bytes(Vec<u8>),
}

/// The layout of journals.
const VERSION: u32 = 1;

impl Journal {
    /// Makes the journal of a transaction that writes `places`, in `folder`; both are absolute and without links.
    pub fn create(folder: &Path, places: &[PathBuf], made: impl FnOnce(&Path)) -> io::Result<Self> {
        let mut file = tempfile::Builder::new()
            .prefix(names::PREFIX)
            .suffix(names::JOURNAL)
            .rand_bytes(names::IDENTITY_LETTERS)
            .tempfile_in(folder)?;
        made(file.path());
        // Where files cannot be locked, those of a transaction that was killed stay.
        match file.as_file().try_lock() {
            Ok(()) | Err(TryLockError::Error(_)) => {}
            Err(TryLockError::WouldBlock) => return Err(io::ErrorKind::ResourceBusy.into()),
        }
        let started = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |time| time.as_secs());
        let places = places.iter().map(|place| Name::of(&relative(place, folder))).collect();
        // Until it is kept it is removed by whatever fails.
        append(file.as_file_mut(), &Head { mimesh_journal: VERSION, started, places })?;
        let (file, path) = file.keep().map_err(|error| error.error)?;
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let identity = name[names::PREFIX.len()..name.len() - names::JOURNAL.len()].to_owned();
        Ok(Self { file, path, identity })
    }

    /// Takes over the journal of a transaction that was killed; `None` if its writer lives, or if nobody can tell.
    pub fn take_over(path: &Path) -> io::Result<Option<Self>> {
        let Some(names::Found::Journal(identity)) = names::parse(path) else { return Ok(None) };
        let file = File::options().read(true).append(true).open(path)?;
        Ok(is_free(&file).then(|| Self { identity: identity.into(), path: path.into(), file }))
    }

    /// Notes what will be moved, and waits until that is on the disk.
    pub fn begin_moves(&mut self, moves: Vec<Move>) -> io::Result<()> {
        append(&mut self.file, &Moves { moves })?;
        disk::sync(&self.file)
    }

    /// Notes that all is moved.
    pub fn end_moves(&mut self) -> io::Result<()> {
        append(&mut self.file, &Done { done: true })
    }
}

impl Record {
    /// What the journal at `path` says; `None` if it has not come to its first line, or is of another version.
    pub fn read(path: &Path) -> io::Result<Option<Self>> {
        let mut lines = BufReader::new(File::open(path)?.take(MAX_BYTES));
        let Some(head) = next::<Head>(&mut lines)?.filter(|head| head.mimesh_journal == VERSION) else {
            return Ok(None);
        };
        let folder = path.parent().unwrap_or(Path::new(""));
        let places: Option<Vec<PathBuf>> =
            head.places.into_iter().map(|name| Some(absolute(&name.path()?, folder))).collect();
        let Some(places) = places else { return Ok(None) };
        let moves = next::<Moves>(&mut lines)?.map(|line| line.moves);
        let moves = moves.filter(|moves| moves.iter().all(|file| file.place < places.len()));
        let is_done = moves.is_some() && next::<Done>(&mut lines)?.is_some();
        Ok(Some(Self { started: head.started, places, moves, is_done }))
    }
}

/// Writes into `file`, which is new, where `journal` is; both are absolute and without links.
pub(super) fn point_at(journal: &Path, file: &Path) -> io::Result<()> {
    let folder = file.parent().unwrap_or(Path::new(""));
    let mut out = File::options().write(true).create_new(true).open(file)?;
    append(&mut out, &Pointer { mimesh_journal_at: Name::of(&relative(journal, folder)) })
}

/// The journal that the file `pointer` names.
pub(super) fn pointed_at(pointer: &Path) -> Option<PathBuf> {
    let mut lines = BufReader::new(File::open(pointer).ok()?.take(MAX_BYTES));
    let name = next::<Pointer>(&mut lines).ok()??.mimesh_journal_at.path()?;
    let journal = absolute(&name, pointer.parent()?);
    // Nothing else is ever taken for a journal.
    matches!(names::parse(&journal), Some(names::Found::Journal(_))).then_some(journal)
}

/// Whether the journal at `path` has not come to the end of its first line, so that nothing else was written either.
pub(super) fn is_unbegun(path: &Path) -> bool {
    let mut line = Vec::new();
    let read = File::open(path).and_then(|file| BufReader::new(file.take(MAX_BYTES)).read_until(b'\n', &mut line));
    read.is_ok() && !line.ends_with(b"\n")
}

/// Whether the transaction of the journal at `path` is under way. Where locks cannot tell, it is.
pub(super) fn is_alive(path: &Path) -> bool {
    File::open(path).is_ok_and(|file| !is_free(&file))
}

/// Whether nobody else has locked `file`; we have then.
///
/// A program that was just started holds the locks of the one that starts it, for some moments after that one has let them go.
fn is_free(file: &File) -> bool {
    const LOOKS: usize = 20;
    (0..LOOKS).any(|look| {
        if look > 0 {
            std::thread::sleep(Duration::from_millis(10));
        }
        file.try_lock().is_ok()
    })
}

/// Adds a line after its hash.
fn append(file: &mut File, line: &impl Serialize) -> io::Result<()> {
    let line = to_bytes(line);
    let mut text = blake3::hash(&line).to_hex().as_bytes().to_vec();
    text.push(b' ');
    text.extend(line);
    text.push(b'\n');
    disk::append(file, &text)
}

/// The next line; `None` if there is none, or one that was cut or changed.
fn next<T: DeserializeOwned>(lines: &mut impl BufRead) -> io::Result<Option<T>> {
    let mut text = Vec::new();
    lines.read_until(b'\n', &mut text)?;
    let line = || {
        let (hash, line) = text.strip_suffix(b"\n")?.split_at_checked(2 * blake3::OUT_LEN)?;
        let line = line.strip_prefix(b" ")?;
        (blake3::hash(line).to_hex().as_bytes() == hash).then(|| serde_json::from_slice(line).ok())?
    };
    Ok(line())
}

impl Name {
    fn of(path: &Path) -> Self {
        match path.to_str() {
            Some(text) => Self::Text(text.into()),
            None => Self::Bytes(path.as_os_str().as_encoded_bytes().into()),
        }
    }

    #[cfg(unix)]
    fn path(self) -> Option<PathBuf> {
        use std::os::unix::ffi::OsStringExt;
        Some(match self {
            Self::Text(text) => text.into(),
            Self::Bytes(bytes) => std::ffi::OsString::from_vec(bytes).into(),
        })
    }

    /// Names that are no Unicode cannot be made from bytes on other systems.
    #[cfg(not(unix))]
    fn path(self) -> Option<PathBuf> {
        match self {
            Self::Text(text) => Some(text.into()),
            Self::Bytes(_) => None,
        }
    }
}
