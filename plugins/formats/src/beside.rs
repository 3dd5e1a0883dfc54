//! Files that lie beside the one that names them.

use std::{
    collections::HashMap,
    path::{Path, PathBuf},
    sync::Arc,
};

use mimesh_core::{Result, stage::FileInput};

use crate::paths::resolved;

/// The files beside one, each read once, however often and by whatever paths it is named.
pub struct FilesBeside<'a> {
    input: &'a dyn FileInput,
    known: HashMap<PathBuf, Arc<Vec<u8>>>,
}

impl<'a> FilesBeside<'a> {
    /// Those beside `input`; none is read yet.
    pub fn new(input: &'a dyn FileInput) -> Self {
        Self { input, known: HashMap::new() }
    }

    /// The name of the file that names them, for messages.
    pub fn path(&self) -> &'a Path {
        self.input.path()
    }

    /// How many are read.
    pub fn len(&self) -> usize {
        self.known.len()
    }

    /// The contents of the file that is called `reference`.
    ///
    /// # Errors
    ///
    /// Those of the input. What cannot be read is tried again when it is named again.
    pub fn read(&mut self, reference: &str) -> Result<Arc<Vec<u8>>> {
        let path = resolved(&self.input.path_of(reference));
        if let Some(known) = self.known.get(&path) {
            return Ok(known.clone());
        }
        let contents = Arc::new(self.input.referenced(reference)?);
        self.known.insert(path, contents.clone());
        Ok(contents)
    }
}
