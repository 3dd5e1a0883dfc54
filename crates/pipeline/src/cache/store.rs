//! A folder of results under their keys.
//!
//! An entry is a file of its own, named by its key; the file begins with the BLAKE3 hash of kind, key and contents. It is written to a
//! temporary file and renamed, so that any number of runs, on any number of machines, may share a folder. Each run finds an entry whole
//! or not at all, and two that write the same entry write the same bytes. The hash shows entries that a failing disk or a hand has
//! changed, or copied from another key. They are removed, and computed again. What is no file, such as a link or a pipe, is no entry.

use std::{
    fs::Metadata,
    io::{self, Write},
    path::{Path, PathBuf},
    time::{Duration, SystemTime},
};

use mimesh_core::{Error, Result, memory};

/// The first bytes of an entry.
const MAGIC: &[u8] = b"mimesh cache 2\n";

/// The first bytes of entries whose hash was of the contents alone; they are written anew.
const OLD_MAGIC: &[u8] = b"mimesh cache 1\n";

/// The folder below the cache's that holds entries of this layout.
const LAYOUT: &str = "v1";

/// The first letters of the names of temporary files.
const TEMPORARY: &str = ".tmp-";

/// Temporary files of this age are removed; runs that were killed leave them.
const STALE: Duration = Duration::from_secs(3600);

/// The part of the limit that is left after a clean-up, so that not every run cleans up.
const AFTER_CLEANUP: f64 = 0.9;

/// A key: the BLAKE3 hash of everything that a result depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Key(pub blake3::Hash);

/// The answer of a store for a key.
#[derive(Debug, PartialEq, Eq)]
pub enum Lookup {
    /// The bytes that were stored.
    Hit(Vec<u8>),
    /// There is no entry.
    Miss,
    /// An entry that is not what was written; it is removed.
    Corrupt,
}

/// The size of a cache, or of a part of it.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct CacheUsage {
    /// Entries.
    pub entries: usize,
    /// Bytes.
    pub bytes: u64,
}

/// A folder of results.
#[derive(Clone, Debug)]
pub struct Store {
    folder: PathBuf,
    limit: u64,
}

/// An entry as the folder lists it.
struct Listed {
    path: PathBuf,
    kind: String,
    bytes: u64,
    used: SystemTime,
}

impl Store {
    /// The results in `folder`, which may grow to `limit` bytes; the folder is made when the first is stored.
    pub fn new(folder: &Path, limit: u64) -> Self {
        Self { folder: folder.join(LAYOUT), limit }
    }

    /// The entry of this kind under `key`.
    pub fn get(&self, kind: &str, key: Key) -> Lookup {
        let path = self.path(kind, key);
        let Some(length) = entry_length(&path) else { return Lookup::Miss };
        // Of what does not fit in memory nothing can be said; to compute it may take less.
        if memory::need("an entry of the cache", length).is_err() {
            return Lookup::Miss;
        }
        let Ok(mut bytes) = std::fs::read(&path) else { return Lookup::Miss };
        if bytes.starts_with(OLD_MAGIC) {
            return Lookup::Miss;
        }
        let start = MAGIC.len() + blake3::OUT_LEN;
        let whole = bytes.strip_prefix(MAGIC).and_then(|rest| rest.split_at_checked(blake3::OUT_LEN));
        if whole.is_some_and(|(hash, contents)| hash_of(kind, key, contents).as_bytes() == hash) {
            // What is used stays longest; where the time cannot be set, it goes sooner.
            let _ = std::fs::File::options().append(true).open(&path).and_then(|f| f.set_modified(SystemTime::now()));
            bytes.drain(..start);
            return Lookup::Hit(bytes);
        }
        let _ = std::fs::remove_file(&path);
        Lookup::Corrupt
    }

    /// Whether there is an entry; its contents are not checked.
    pub fn contains(&self, kind: &str, key: Key) -> bool {
        entry_length(&self.path(kind, key)).is_some()
    }

    /// Stores `contents`.
    ///
    /// # Errors
    ///
    /// [`Error::Io`] if the folder cannot be written.
    pub fn put(&self, kind: &str, key: Key, contents: &[u8]) -> Result<()> {
        let path = self.path(kind, key);
        let write = || -> io::Result<()> {
            let folder = path.parent().unwrap_or(&self.folder);
            std::fs::create_dir_all(folder)?;
            let mut builder = tempfile::Builder::new();
            // Whoever shares the folder may read it, unless the user's mask says otherwise.
            #[cfg(unix)]
            builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
            let mut temporary = builder.prefix(TEMPORARY).tempfile_in(folder)?;
            temporary.write_all(MAGIC)?;
            temporary.write_all(hash_of(kind, key, contents).as_bytes())?;
            temporary.write_all(contents)?;
            temporary.persist(&path).map(drop).map_err(|error| error.error)
        };
        write().map_err(|error| Error::write(&path, error))
    }

    /// Removes what has not been used for longest until the rest is well within the limit, if it is beyond; returns what was
    /// removed.
    pub fn clean_up(&self) -> CacheUsage {
        self.remove_stale();
        let mut all = self.list();
        let mut bytes: u64 = all.iter().map(|entry| entry.bytes).sum();
        let mut removed = CacheUsage::default();
        if bytes <= self.limit {
            return removed;
        }
        all.sort_by(|a, b| a.used.cmp(&b.used).then_with(|| a.path.cmp(&b.path)));
        let goal = (self.limit as f64 * AFTER_CLEANUP) as u64;
        for entry in all {
            if bytes <= goal {
                break;
            }
            if std::fs::remove_file(&entry.path).is_ok() {
                bytes -= entry.bytes;
                removed.entries += 1;
                removed.bytes += entry.bytes;
            }
        }
        removed
    }

    /// Removes every entry; nothing else that may lie in the folder.
    ///
    /// # Errors
    ///
    /// [`Error::Io`] about the first that cannot be removed.
    pub fn clear(&self) -> Result<CacheUsage> {
        self.remove_stale();
        let mut removed = CacheUsage::default();
        for entry in self.list() {
            match std::fs::remove_file(&entry.path) {
                Ok(()) => {
                    removed.entries += 1;
                    removed.bytes += entry.bytes;
                }
                Err(error) if error.kind() == io::ErrorKind::NotFound => {}
                Err(error) => return Err(Error::write(&entry.path, error)),
            }
        }
        Ok(removed)
    }

    /// The size of each kind of entries.
    pub fn usage(&self) -> std::collections::BTreeMap<String, CacheUsage> {
        let mut usage = std::collections::BTreeMap::<String, CacheUsage>::new();
        for entry in self.list() {
            let of_kind = usage.entry(entry.kind).or_default();
            of_kind.entries += 1;
            of_kind.bytes += entry.bytes;
        }
        usage
    }

    /// The bytes that the folder may grow to.
    pub fn limit(&self) -> u64 {
        self.limit
    }

    /// The bytes of all entries, if they are so many that a clean-up may have removed others.
    pub fn bytes_if_full(&self) -> Option<u64> {
        let bytes = self.list().iter().map(|entry| entry.bytes).sum();
        // A clean-up leaves a little less than its goal.
        (bytes as f64 > 0.9 * AFTER_CLEANUP * self.limit as f64).then_some(bytes)
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    fn path(&self, kind: &str, key: Key) -> PathBuf {
        let name = key.0.to_hex();
        self.folder.join(kind).join(&name[..2]).join(name.as_str())
    }

    /// All entries.
    fn list(&self) -> Vec<Listed> {
        let name = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let entry = |(kind, path, metadata): (PathBuf, PathBuf, Metadata)| {
            let [of_file, of_folder] = [name(&path), name(path.parent()?)];
            let is_key = of_file.len() == 64 && of_file.bytes().all(|c| c.is_ascii_hexdigit());
            let used = metadata.modified().unwrap_or(SystemTime::UNIX_EPOCH);
            let is_entry = is_key && of_file.starts_with(&of_folder) && of_folder.len() == 2;
            is_entry.then(|| Listed { kind: name(&kind), bytes: metadata.len(), used, path })
        };
        self.files().into_iter().filter_map(entry).collect()
    }

    /// Removes temporary files that runs have left.
    fn remove_stale(&self) {
        for (_, path, metadata) in self.files() {
            let is_temporary =
                path.file_name().is_some_and(|name| name.as_encoded_bytes().starts_with(TEMPORARY.as_bytes()));
            let is_old = metadata.modified().is_ok_and(|at| at.elapsed().is_ok_and(|age| age > STALE));
            if is_temporary && is_old {
                let _ = std::fs::remove_file(&path);
            }
        }
    }

    /// The files below the folders of all kinds, with the folder of their kind; nothing behind links.
    fn files(&self) -> Vec<(PathBuf, PathBuf, Metadata)> {
        let children = |folder: &Path| {
            let entries = std::fs::read_dir(folder).into_iter().flatten().filter_map(io::Result::ok);
            let mut paths: Vec<PathBuf> = entries.map(|entry| entry.path()).collect();
            paths.sort();
            paths
        };
        let mut files = Vec::new();
        for kind in children(&self.folder).into_iter().filter(|kind| is_folder(kind)) {
            for path in children(&kind).iter().filter(|folder| is_folder(folder)).flat_map(|folder| children(folder)) {
                if let Ok(metadata) = path.symlink_metadata()
                    && metadata.is_file()
                {
                    files.push((kind.clone(), path, metadata));
                }
            }
        }
        files
    }
}

/// The bytes of the entry at `path`, if that is a file itself, which ends when it is read, and lies in folders of the cache: behind a link
/// lies what is another's.
fn entry_length(path: &Path) -> Option<u64> {
    path.ancestors().skip(1).take(2).all(is_folder).then_some(())?;
    path.symlink_metadata().ok().filter(|found| found.is_file()).map(|found| found.len())
}

/// Whether `path` is a folder, and no link to one.
fn is_folder(path: &Path) -> bool {
    path.symlink_metadata().is_ok_and(|found| found.is_dir())
}

/// The hash at the beginning of an entry.
fn hash_of(kind: &str, key: Key, contents: &[u8]) -> blake3::Hash {
    let mut hasher = blake3::Hasher::new();
    // Lengths keep kind and contents apart.
    hasher.update(&(kind.len() as u64).to_le_bytes()).update(kind.as_bytes());
    hasher.update(key.0.as_bytes()).update(contents);
    hasher.finalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(text: &str) -> Key {
        Key(blake3::hash(text.as_bytes()))
    }

    #[test]
    fn what_is_kept_comes_back_and_what_is_changed_does_not() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::new(folder.path(), 1 << 20);
        assert_eq!(store.get("pose", key("a")), Lookup::Miss);
        store.put("pose", key("a"), b"contents").unwrap();
        assert_eq!(store.get("pose", key("a")), Lookup::Hit(b"contents".into()));
        assert_eq!(store.get("map", key("a")), Lookup::Miss, "another kind is another entry");

        let path = store.path("pose", key("a"));
        let whole = std::fs::read(&path).unwrap();
        // Every byte counts, and every length.
        for i in 0..whole.len() {
            let mut changed = whole.clone();
            changed[i] ^= 0x10;
            for damaged in [&changed[..], &whole[..i]] {
                std::fs::write(&path, damaged).unwrap();
                assert_eq!(store.get("pose", key("a")), Lookup::Corrupt, "byte {i}");
                assert!(!path.exists(), "a damaged entry is removed");
            }
        }
    }

    #[test]
    fn an_entry_that_was_copied_from_another_key_or_kind_is_none() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::new(folder.path(), 1 << 20);
        store.put("pose", key("a"), b"of a").unwrap();
        for (kind, name) in [("pose", "b"), ("map", "a")] {
            store.put(kind, key(name), b"its own").unwrap();
            std::fs::copy(store.path("pose", key("a")), store.path(kind, key(name))).unwrap();
            assert_eq!(store.get(kind, key(name)), Lookup::Corrupt, "{kind} {name}");
            assert_eq!(store.get(kind, key(name)), Lookup::Miss);
        }
        assert_eq!(store.get("pose", key("a")), Lookup::Hit(b"of a".into()));
    }

    #[cfg(unix)]
    #[test]
    fn what_is_no_file_is_no_entry_and_is_replaced_where_that_can_be() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::new(folder.path(), 1 << 20);
        store.put("pose", key("a"), b"a").unwrap();
        let path = store.path("pose", key("a"));
        std::fs::remove_file(&path).unwrap();
        // Read to its end, this would never come back.
        std::os::unix::fs::symlink("/dev/zero", &path).unwrap();
        assert_eq!(store.get("pose", key("a")), Lookup::Miss);
        assert!(!store.contains("pose", key("a")));
        store.put("pose", key("a"), b"a").unwrap();
        assert_eq!(store.get("pose", key("a")), Lookup::Hit(b"a".into()));
        std::fs::remove_file(&path).unwrap();
        std::fs::create_dir(&path).unwrap();
        assert_eq!(store.get("pose", key("a")), Lookup::Miss);
        assert!(store.put("pose", key("a"), b"a").is_err());
    }

    #[cfg(unix)]
    #[test]
    fn nothing_behind_a_link_is_touched() {
        let (folder, elsewhere) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let store = Store::new(folder.path(), 0);
        store.put("pose", key("a"), b"a").unwrap();
        let path = store.path("pose", key("a"));
        // Others' files with names of the same form, behind a link on each level.
        let [of_kind, of_key] = [elsewhere.path().join("kind"), elsewhere.path().join("key")];
        let name = path.file_name().unwrap();
        let others = [of_kind.join(path.parent().unwrap().file_name().unwrap()).join(name), of_key.join(name)];
        for other in &others {
            std::fs::create_dir_all(other.parent().unwrap()).unwrap();
            std::fs::write(other, "mine").unwrap();
        }
        let temporary = of_key.join(".tmp-old");
        std::fs::write(&temporary, "mine").unwrap();
        let file = std::fs::File::options().append(true).open(&temporary).unwrap();
        file.set_modified(SystemTime::now() - 2 * STALE).unwrap();
        std::os::unix::fs::symlink(&of_kind, folder.path().join("v1/map")).unwrap();
        std::fs::create_dir(folder.path().join("v1/transfer")).unwrap();
        let linked = folder.path().join("v1/transfer").join(path.parent().unwrap().file_name().unwrap());
        std::os::unix::fs::symlink(&of_key, linked).unwrap();
        for kind in ["map", "transfer"] {
            assert_eq!(store.get(kind, key("a")), Lookup::Miss);
        }
        assert_eq!(store.usage().len(), 1);
        assert_eq!((store.clean_up().entries, store.clear().unwrap().entries), (1, 0));
        assert!(others.iter().all(|other| other.exists()) && temporary.exists());
    }

    #[test]
    fn the_longest_unused_go_first() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::new(folder.path(), 1000);
        for (i, name) in ["old", "older", "new"].into_iter().enumerate() {
            store.put("pose", key(name), &[0; 400]).unwrap();
            let age = Duration::from_secs([200, 300, 100][i]);
            let file = std::fs::File::options().append(true).open(store.path("pose", key(name))).unwrap();
            file.set_modified(SystemTime::now() - age).unwrap();
        }
        // Looked at, it counts as used.
        assert!(matches!(store.get("pose", key("older")), Lookup::Hit(_)));
        assert_eq!(store.clean_up().entries, 1);
        assert_eq!(store.get("pose", key("old")), Lookup::Miss);
        assert!(matches!(store.get("pose", key("older")), Lookup::Hit(_)));
        assert_eq!(store.clean_up(), CacheUsage::default(), "within the limit nothing goes");
    }

    #[test]
    fn clearing_removes_entries_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::new(folder.path(), 1 << 20);
        store.put("pose", key("a"), b"1").unwrap();
        store.put("map", key("b"), b"22").unwrap();
        let own = folder.path().join("v1/pose/letter.txt");
        std::fs::write(&own, "mine").unwrap();
        assert_eq!(store.usage().len(), 2);
        assert_eq!(store.clear().unwrap().entries, 2);
        assert!(store.usage().is_empty() && own.exists());
    }

    #[test]
    fn many_writers_of_one_entry_leave_it_whole() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::new(folder.path(), 1 << 30);
        let contents = vec![7; 100_000];
        std::thread::scope(|scope| {
            for _ in 0..8 {
                scope.spawn(|| {
                    for _ in 0..20 {
                        store.put("pose", key("a"), &contents).unwrap();
                        assert_eq!(store.get("pose", key("a")), Lookup::Hit(contents.clone()));
                    }
                });
            }
        });
        assert_eq!(store.usage()["pose"].entries, 1);
    }
}
