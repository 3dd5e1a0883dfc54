//! The journal of a transaction: what it will write, then what it moves.
//!
//! A journal is a text file of at most three lines, each after the hash of its own contents, so that a line that was cut counts as
//! none: the places, before anything is written; the moves, when everything is written and nothing is moved; and the word that all
//! is moved, or put back.
//!
//! A folder may come from a stranger, and with it a file that looks like a journal. So only regular files are opened, links are not
//! followed, and what is read is bounded. What a journal may move is decided in [`recovery`](super::recovery).

use std::{
    fs::{self, File, Metadata, TryLockError},
    io::{self, BufRead, BufReader, ErrorKind, Read},
    path::{Path, PathBuf},
    time::{Duration, SystemTime, UNIX_EPOCH},
};

use mimesh_document::files::open_regular;
use serde::{Deserialize, Serialize, de::DeserializeOwned};

use super::{
    disk, names,
    path_text::{MAX_PLACES, PathText, bounded},
    place::{absolute, relative},
};
use crate::json::to_bytes;

/// The longest journal that is written or read, in bytes.
const MAX_BYTES: u64 = 128 << 20;

/// The journal of a transaction that lives in this process.
#[derive(Debug)]
pub(super) struct Journal {
    /// Locked until it is dropped.
    file: File,
    /// Where it is.
    pub path: PathBuf,
    /// The random name that all its files have in common.
    pub identity: String,
    /// Whether it may say what is moved, so that it has to say how that ended.
    has_moves: bool,
}

/// What a file that has the name of a journal holds.
#[derive(Debug)]
pub(super) enum Contents {
    /// Less than its first line: its writer has just begun, or died then.
    Unbegun,
    /// Something that this version does not understand.
    Foreign,
    /// A journal.
    Record(Record),
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
    /// How it ended, once nothing is left but to remove what is temporary.
    pub ending: Option<Ending>,
}

/// How a transaction that moved files has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ending {
    /// All files are in their places.
    Done,
    /// All that was there before is in its place again.
    Undone,
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
    /// What is known of it.
    #[serde(default)]
    pub before: Option<Before>,
}

/// What tells a file that was there before from one that was edited since.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub(super) struct Before {
    bytes: u64,
    /// When it was changed, in nanoseconds since 1970.
    modified: Option<i64>,
}

/// The first line.
#[derive(Deserialize, Serialize)]
struct Head {
    mimesh_journal: u32,
    started: u64,
    /// Seen from the folder of the journal, since a volume may be mounted elsewhere.
    #[serde(deserialize_with = "bounded")]
    places: Vec<PathText>,
}

/// The second line.
#[derive(Deserialize, Serialize)]
struct Moves {
    #[serde(deserialize_with = "bounded")]
    moves: Vec<Move>,
}

/// The third line.
#[derive(Deserialize, Serialize)]
struct End {
    /// Whether all is moved; else all is as it was.
    done: bool,
}

/// The layout of journals.
const VERSION: u32 = 1;

impl Journal {
    /// Makes the journal of a transaction that writes `places`, in `folder`; both are absolute and without links.
    pub fn create(folder: &Path, places: &[PathBuf], made: impl FnOnce(&Path)) -> io::Result<Self> {
        if places.len() > MAX_PLACES {
            return Err(io::Error::other(format!("more than {MAX_PLACES} files cannot be written together")));
        }
        let mut builder = tempfile::Builder::new();
        // Whoever shares the folder has to see who writes into it, unless the user's mask says otherwise.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let mut file = builder
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
        let places = places.iter().map(|place| PathText::of(&relative(place, folder))).collect();
        // Until it is kept it is removed by whatever fails.
        append(file.as_file_mut(), &Head { mimesh_journal: VERSION, started, places })?;
        let (file, path) = file.keep().map_err(|error| error.error)?;
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let identity = name[names::PREFIX.len()..name.len() - names::JOURNAL.len()].to_owned();
        Ok(Self { file, path, identity, has_moves: false })
    }

    /// Takes over the journal of a transaction that was killed; `None` if its writer lives, or if nobody can tell.
    pub fn take_over(path: &Path) -> io::Result<Option<Self>> {
        let Some(names::Found::Journal(identity)) = names::parse(path) else { return Ok(None) };
        check(path)?;
        let file = File::options().read(true).append(true).open(path)?;
        Ok(is_free(&file).then(|| Self { identity: identity.into(), path: path.into(), file, has_moves: true }))
    }

    /// Whether the journal is still in its folder: others may have removed it, and nothing could be recovered without it.
    pub fn is_there(&self) -> bool {
        !fs::symlink_metadata(&self.path).is_err_and(|error| error.kind() == ErrorKind::NotFound)
    }

    /// Notes what will be moved, and waits until that is on the disk.
    pub fn begin_moves(&mut self, moves: Vec<Move>) -> io::Result<()> {
        self.has_moves = true;
        append(&mut self.file, &Moves { moves })?;
        disk::sync(&self.file)
    }

    /// Notes that all is moved, or all is as it was; nothing where no moves were noted.
    pub fn end(&mut self, ending: Ending) -> io::Result<()> {
        if !self.has_moves {
            return Ok(());
        }
        append(&mut self.file, &End { done: ending == Ending::Done })
    }
}

impl Before {
    /// What is known of a file; `None` if it is something else.
    pub fn of(found: &Metadata) -> Option<Self> {
        let nanoseconds = |time: SystemTime| match time.duration_since(UNIX_EPOCH) {
            Ok(after) => i64::try_from(after.as_nanos()).ok(),
            Err(before) => i64::try_from(before.duration().as_nanos()).ok().map(|time| -time),
        };
        let modified = found.modified().ok().and_then(nanoseconds);
        found.is_file().then_some(Self { bytes: found.len(), modified })
    }
}

impl Contents {
    /// What the file at `path` holds, which has the name of a journal.
    ///
    /// # Errors
    ///
    /// Those of the system, and that it is no regular file, or too large.
    pub fn read(path: &Path) -> io::Result<Self> {
        let mut lines = BufReader::new(open(path, MAX_BYTES)?);
        let mut first = Vec::new();
        lines.read_until(b'\n', &mut first)?;
        if !first.ends_with(b"\n") {
            return Ok(Self::Unbegun);
        }
        let Some(head) = parse::<Head>(&first).filter(|head| head.mimesh_journal == VERSION) else {
            return Ok(Self::Foreign);
        };
        let folder = path.parent().unwrap_or(Path::new(""));
        let place = |name: PathText| {
            let place = absolute(&name.path()?, folder);
            let is_result = place.file_name().is_some_and(|name| !names::is_ours(name));
            is_result.then_some(place)
        };
        let Some(places) = head.places.into_iter().map(place).collect::<Option<Vec<PathBuf>>>() else {
            return Ok(Self::Foreign);
        };
        let mut second = Vec::new();
        lines.read_until(b'\n', &mut second)?;
        let moves = parse::<Moves>(&second).map(|line| line.moves);
        let moves = moves.filter(|moves| moves.iter().all(|file| file.place < places.len()));
        // A line that is whole and yet means nothing was not written by us, and what it was to say nobody knows.
        if moves.is_none() && second.ends_with(b"\n") {
            return Ok(Self::Foreign);
        }
        let end = if moves.is_some() { next::<End>(&mut lines)? } else { None };
        let ending = end.map(|end| if end.done { Ending::Done } else { Ending::Undone });
        Ok(Self::Record(Record { started: head.started, places, moves, ending }))
    }
}

/// Opens a file that may be a stranger's.
pub(super) fn open(path: &Path, limit: u64) -> io::Result<io::Take<File>> {
    check(path)?;
    let file = open_regular(path)?;
    if file.metadata()?.len() > limit {
        return Err(io::Error::new(ErrorKind::InvalidInput, "it is larger than any journal"));
    }
    Ok(file.take(limit))
}

/// Checks that `path` is a regular file and no link.
fn check(path: &Path) -> io::Result<()> {
    match fs::symlink_metadata(path)? {
        found if found.is_symlink() => Err(io::Error::new(ErrorKind::InvalidInput, "it is a link, expected a file")),
        _ => mimesh_document::files::check_regular(path),
    }
}

/// Whether the transaction of the journal at `path` is under way. Where locks cannot tell, it is.
pub(super) fn is_alive(path: &Path) -> bool {
    // Some file systems lock only what is open for writing.
    let open = || File::options().read(true).append(true).open(path).or_else(|_| File::open(path));
    check(path).and_then(|()| open()).is_ok_and(|file| !is_free(&file))
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
pub(super) fn append(file: &mut File, line: &impl Serialize) -> io::Result<()> {
    let line = to_bytes(line);
    if line.len() as u64 > MAX_BYTES / 2 - 100 {
        return Err(io::Error::other("the names of the files are too long for all of them to be written together"));
    }
    let mut text = blake3::hash(&line).to_hex().as_bytes().to_vec();
    text.push(b' ');
    text.extend(line);
    text.push(b'\n');
    disk::append(file, &text)
}

/// The next line; `None` if there is none, or one that was cut or changed.
pub(super) fn next<T: DeserializeOwned>(lines: &mut impl BufRead) -> io::Result<Option<T>> {
    let mut text = Vec::new();
    lines.read_until(b'\n', &mut text)?;
    Ok(parse(&text))
}

/// The contents of a line after their hash.
fn parse<T: DeserializeOwned>(text: &[u8]) -> Option<T> {
    let (hash, line) = text.strip_suffix(b"\n")?.split_at_checked(2 * blake3::OUT_LEN)?;
    let line = line.strip_prefix(b" ")?;
    (blake3::hash(line).to_hex().as_bytes() == hash).then(|| serde_json::from_slice(line).ok())?
}
