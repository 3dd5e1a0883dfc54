//! The cache of a run: typed results in a store, and warnings about it.

use std::{
    path::{Path, PathBuf},
    sync::{Mutex, PoisonError},
};

use mimesh_core::Error;
use mimesh_document::{Diagnostic, Kind, diagnostic::Result};

use super::{
    codec::CacheCodec,
    store::{Key, Lookup, Store},
};

/// The environment variable that names the cache's folder.
pub const VARIABLE: &str = "MIMESH_CACHE";

/// The size of a cache where nobody sets another: 2 GiB.
pub const DEFAULT_LIMIT: u64 = 2 << 30;

/// Remedy: run without cached results.
pub const WITHOUT_CACHE: &str = "without_cache";

/// Remedy: choose another folder for cached results.
pub const OTHER_CACHE_FOLDER: &str = "other_cache_folder";

/// The cache that a run takes results from and puts results into.
#[derive(Debug)]
pub struct Cache {
    /// The folder.
    pub store: Store,
    /// The identity of the program, which is part of every key.
    program: String,
    warnings: Mutex<Vec<String>>,
}

impl Cache {
    /// The cache in `folder`, which may grow to `limit` bytes; `None` is the user's own folder.
    ///
    /// `program` identifies the code that computes results: results of another program are not used. A stage may compute
    /// something else after it was edited, whatever its version, so that a hash of the program's file is best.
    ///
    /// # Errors
    ///
    /// If the system names no folder for caches.
    pub fn new(folder: Option<&Path>, limit: u64, program: String) -> Result<Self> {
        let folder = folder.map_or_else(default_folder, |folder| Ok(folder.into()))?;
        Ok(Self { store: Store::new(&folder, limit), program, warnings: Mutex::default() })
    }

    /// The identity of the program.
    pub fn program(&self) -> &str {
        &self.program
    }

    /// The result of this kind under `key`, if it is there and whole.
    pub fn get<T: CacheCodec>(&self, kind: &str, key: Key) -> Option<T> {
        match self.store.get(kind, key) {
            Lookup::Miss => None,
            Lookup::Hit(bytes) => T::decode(&bytes),
            Lookup::Corrupt => {
                self.warn(format!("a cached result ({kind}) was damaged; it is removed and computed again"));
                None
            }
        }
    }

    /// Stores a result. Where that fails the run goes on without, and a warning says so once.
    pub fn put<T: CacheCodec>(&self, kind: &str, key: Key, result: &T) {
        if let Err(error) = self.store.put(kind, key, &result.encode()) {
            self.warn(format!("results are not cached: {}", reason(&error)));
        }
    }

    /// Sentences about the cache since the last call, each once.
    pub fn warnings(&self) -> Vec<String> {
        std::mem::take(&mut *self.warnings.lock().unwrap_or_else(PoisonError::into_inner))
    }

    fn warn(&self, sentence: String) {
        let mut warnings = self.warnings.lock().unwrap_or_else(PoisonError::into_inner);
        if !warnings.contains(&sentence) {
            warnings.push(sentence);
        }
    }
}

/// Why a folder cannot be written, without the name of the entry, so that all entries give the same reason.
fn reason(error: &Error) -> String {
    match error {
        Error::Io { source, .. } => format!("{source}; name another folder for the cache, or run without it"),
        other => other.to_string(),
    }
}

/// The user's folder for results.
fn default_folder() -> Result<PathBuf> {
    if let Some(folder) = std::env::var_os(VARIABLE).filter(|folder| !folder.is_empty()) {
        return Ok(folder.into());
    }
    dirs::cache_dir().map(|folder| folder.join("mimesh")).ok_or_else(|| {
        let diagnostic = Diagnostic::new(Kind::CannotWrite, "the system names no folder for caches");
        let diagnostic = diagnostic.hint(format!("name one by the environment variable {VARIABLE}"));
        diagnostic.remedy(OTHER_CACHE_FOLDER, "", "name another folder for the cache").into()
    })
}
