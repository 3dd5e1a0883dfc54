use std::{
    borrow::Cow,
    collections::BTreeMap,
    fmt::Debug,
    path::{Path, PathBuf},
};

use crate::{Error, Result};

/// A file to read, and the files that it refers to.
///
/// Formats open nothing by themselves: the caller decides what may be opened, and bytes in memory work like a file.
pub trait FileInput: Debug + Send + Sync {
    /// The name of the file, for messages.
    fn path(&self) -> &Path;

    /// The contents of the file.
    ///
    /// # Errors
    ///
    /// [`Error::Io`] if it cannot be read.
    fn contents(&self) -> Result<Cow<'_, [u8]>>;

    /// The file, opened for reading parts of it, so that a large one is not held in memory.
    ///
    /// # Errors
    ///
    /// [`Error::Io`] if it cannot be read.
    fn open(&self) -> Result<Box<dyn ReadAt>> {
        Ok(Box::new(BytesInput::new(self.path(), self.contents()?)))
    }

    /// The contents of the file that this one calls `reference`, a path relative to its folder.
    ///
    /// # Errors
    ///
    /// [`Error::Io`] if it cannot be read, [`Error::OutOfReach`] if it may not be opened.
    fn referenced(&self, reference: &str) -> Result<Vec<u8>>;

    /// The path that `reference` stands for, for messages.
    fn path_of(&self, reference: &str) -> PathBuf {
        self.path().with_file_name(reference)
    }
}

/// A file that is read by parts.
pub trait ReadAt: Debug + Send + Sync {
    /// Its length in bytes.
    fn length(&self) -> u64;

    /// Fills `part` with the bytes from `offset` on.
    ///
    /// # Errors
    ///
    /// [`Error::Io`] if they cannot be read, or the file ends before.
    fn read_at(&self, offset: u64, part: &mut [u8]) -> Result<()>;
}

/// A file whose contents are in memory, with those that it refers to.
#[derive(Clone, Debug, Default)]
pub struct BytesInput {
    /// The name of the file; its extension tells the format.
    pub path: PathBuf,
    /// The contents.
    pub contents: Vec<u8>,
    /// The contents of other files, by the references to them.
    pub others: BTreeMap<String, Vec<u8>>,
}

impl BytesInput {
    /// A file that refers to no other.
    pub fn new(path: impl Into<PathBuf>, contents: impl Into<Vec<u8>>) -> Self {
        Self { path: path.into(), contents: contents.into(), others: BTreeMap::new() }
    }
}

impl FileInput for BytesInput {
    fn path(&self) -> &Path {
        &self.path
    }

    fn contents(&self) -> Result<Cow<'_, [u8]>> {
        Ok(Cow::Borrowed(&self.contents))
    }

    fn referenced(&self, reference: &str) -> Result<Vec<u8>> {
        let known = self.others.get(reference).cloned();
        known.ok_or_else(|| Error::read(&self.path_of(reference), std::io::ErrorKind::NotFound.into()))
    }
}

impl ReadAt for BytesInput {
    fn length(&self) -> u64 {
        self.contents.len() as u64
    }

    fn read_at(&self, offset: u64, part: &mut [u8]) -> Result<()> {
        let from = usize::try_from(offset).ok().and_then(|start| self.contents.get(start..)?.get(..part.len()));
        let from = from.ok_or_else(|| Error::read(&self.path, std::io::ErrorKind::UnexpectedEof.into()))?;
        part.copy_from_slice(from);
        Ok(())
    }
}
