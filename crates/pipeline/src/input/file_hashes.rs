//! Sizes and hashes of input files, each computed once.

use std::{
    collections::HashMap,
    fs, io,
    path::{Path, PathBuf},
    sync::{Arc, Mutex, OnceLock, PoisonError},
};

use mimesh_document::files::hash_file;

/// The size and the hash of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HashedFile {
    /// The size in bytes.
    pub bytes: u64,
    /// The BLAKE3 hash of the contents, in hexadecimal.
    pub blake3: String,
}

/// Sizes and hashes of files, each computed when it is first asked for and then remembered; runs of one pipeline share them.
#[derive(Debug, Default)]
pub struct FileHashes {
    files: Mutex<HashMap<PathBuf, Entry>>,
}

/// `None` if the file could not be read.
type Entry = Arc<OnceLock<Option<HashedFile>>>;

impl FileHashes {
    /// The size and the hash of `path`; `None` if it cannot be read.
    pub fn get(&self, path: &Path) -> Option<HashedFile> {
        let entry = {
            let mut files = self.files.lock().unwrap_or_else(PoisonError::into_inner);
            files.entry(path.to_path_buf()).or_default().clone()
        };
        entry.get_or_init(|| hashed(path).ok()).clone()
    }

    /// The hash of `path` in hexadecimal; `None` if it cannot be read.
    pub fn hash(&self, path: &Path) -> Option<String> {
        self.get(path).map(|file| file.blake3)
    }
}

fn hashed(path: &Path) -> io::Result<HashedFile> {
    Ok(HashedFile { bytes: fs::metadata(path)?.len(), blake3: hash_file(path)? })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_hashed_once() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a");
        fs::write(&file, "one").unwrap();
        let hashes = FileHashes::default();
        let first = hashes.get(&file).unwrap();
        assert_eq!((first.bytes, first.blake3.clone()), (3, blake3::hash(b"one").to_hex().to_string()));
        fs::write(&file, "another").unwrap();
        assert_eq!(hashes.get(&file), Some(first));
        assert_eq!(hashes.get(&folder.path().join("b")), None);
    }
}
