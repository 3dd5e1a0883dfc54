//! Results of stages, kept under what they depend on, so that a run does again only what is new.
//!
//! A key is the BLAKE3 hash of the program, the stage's settings, the contents of its inputs and the keys of the stages before
//! it; no time stamp or path takes part. Kept are the proximity graph, the triangle map, every posed target on its own as
//! soon as it is done, and what metrics said of it: a run that was killed goes on where it was. A bound transfer is no data; it is
//! bound anew if any pose is missing. Frames of one motion depend on those before, so that they are kept but taken only all
//! together, and so are the figures of metrics.

mod codec;
mod keys;
mod record;
mod store;

use std::{
    path::{Path, PathBuf},
    sync::Mutex,
};

pub use codec::{Keep, Moved, OfTransfer};
pub use keys::{Recipe, Recipes};
pub use record::{Change, Record};
pub use store::{Found, Kept, Key, Store};

use crate::{
    core::Error,
    diagnostic::Kind,
    diagnostic::{Diagnostic, Result},
};

/// The variable of the environment that names the cache's folder.
pub const VARIABLE: &str = "MIMESH_CACHE";

/// The most that is kept where nobody says otherwise: 2 GiB.
pub const DEFAULT_LIMIT: u64 = 2 << 30;

/// Where results are kept during a run.
#[derive(Debug)]
pub struct Cache {
    /// The folder.
    pub store: Store,
    program: String,
    warnings: Mutex<Vec<String>>,
}

impl Cache {
    /// The cache in `folder`; `None` is the user's own.
    ///
    /// # Errors
    ///
    /// If the system tells no folder for caches.
    pub fn new(folder: Option<&Path>, limit: u64) -> Result<Self> {
        let folder = folder.map_or_else(default_folder, |folder| Ok(folder.into()))?;
        let program = keys::program().ok_or_else(|| {
            Diagnostic::new(Kind::Internal, "the program cannot read its own file, by which results are kept")
                .hint("run with `--no-cache`")
        })?;
        Ok(Self { store: Store::new(&folder, limit), program, warnings: Mutex::default() })
    }

    /// What results of `prepared` depend on.
    pub fn recipes(&self, prepared: &super::Prepared) -> Recipes {
        Recipes::new(prepared, &self.program)
    }

    /// The result of this kind under `key`, if it is there and whole.
    pub fn get<T: Keep>(&self, kind: &str, key: Key) -> Option<T> {
        match self.store.get(kind, key) {
            Found::Missing => None,
            Found::Whole(bytes) => T::from_bytes(&bytes),
            Found::Damaged => {
                self.warn(format!("a kept result ({kind}) was damaged; it is removed and computed again"));
                None
            }
        }
    }

    /// Keeps a result; where that fails the run goes on without, and says so once.
    pub fn put<T: Keep>(&self, kind: &str, key: Key, result: &T) {
        if let Err(error) = self.store.put(kind, key, &result.to_bytes()) {
            self.warn(format!("results are not kept: {}", of_writing(&error)));
        }
    }

    /// Sentences about the cache since the last call, each once.
    pub fn warnings(&self) -> Vec<String> {
        std::mem::take(&mut *self.warnings.lock().unwrap_or_else(std::sync::PoisonError::into_inner))
    }

    fn warn(&self, sentence: String) {
        let mut warnings = self.warnings.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        if !warnings.contains(&sentence) {
            warnings.push(sentence);
        }
    }
}

/// Why a folder cannot be written, without the name of the entry, so that all entries say the same.
fn of_writing(error: &Error) -> String {
    match error {
        Error::Io { source, .. } => format!("{source}; say where with `--cache DIR`, or run with `--no-cache`"),
        other => other.to_string(),
    }
}

/// The user's folder for results.
fn default_folder() -> Result<PathBuf> {
    if let Some(folder) = std::env::var_os(VARIABLE).filter(|folder| !folder.is_empty()) {
        return Ok(folder.into());
    }
    dirs::cache_dir().map(|folder| folder.join("mimesh")).ok_or_else(|| {
        Diagnostic::new(Kind::CannotWrite, "the system names no folder for caches")
            .hint(format!("name one: `--cache DIR` or the variable {VARIABLE}; or run with `--no-cache`"))
            .into()
    })
}
