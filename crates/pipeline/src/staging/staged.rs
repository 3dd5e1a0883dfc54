//! A file in the making.

use std::{
    collections::BTreeMap,
    fs::File,
    io::{BufWriter, Write},
    path::{Path, PathBuf},
};

use mimesh_core::Error;
use mimesh_document::Diagnostic;
use mimesh_markers::IntoDiagnostic;

use super::{disk, registry};

/// A file that is being written, or waits to be moved into its place; dropped, it is removed.
#[derive(Debug)]
pub struct Staged {
    /// Where it is.
    pub(super) part: PathBuf,
    /// The number of its place in its transaction.
    pub(super) number: usize,
    /// The place as the user named it.
    place: PathBuf,
    bytes: u64,
    blake3: String,
    renamed: BTreeMap<String, String>,
}

/// A file in its place.
#[derive(Clone, Debug, PartialEq, Eq, serde::Deserialize, serde::Serialize)]
pub struct WrittenFile {
    /// The file.
    #[serde(serialize_with = "crate::json::path")]
    pub path: PathBuf,
    /// Its size.
    pub bytes: u64,
    /// The hash of its contents. A file that has another one is of another run.
    #[serde(default)]
    pub blake3: String,
    /// The poses that it has under another name, with that name.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub renamed: BTreeMap<String, String>,
}

impl Staged {
    /// An empty file at `part` for `place`, and the file to write to.
    pub(super) fn create(part: PathBuf, number: usize, place: &Path) -> Result<(Self, File), Diagnostic> {
        // The name is known before the file exists, so that an interrupt between the two leaves nothing.
        registry::locked().add(&part);
        let staged =
            Self { part, number, place: place.into(), bytes: 0, blake3: String::new(), renamed: BTreeMap::new() };
        let file = File::options().read(true).write(true).create_new(true).open(&staged.part);
        let file = file.map_err(|error| Error::write(place, error).into_diagnostic())?;
        Ok((staged, file))
    }

    /// Notes size and hash of the file, which is complete, when it is on the disk.
    ///
    /// # Errors
    ///
    /// Those of the system about its place.
    pub fn close(&mut self) -> Result<(), Diagnostic> {
        let failed = |error| Error::write(&self.place, error).into_diagnostic();
        // Some systems let only those that may write wait for the disk.
        let mut file = File::options().read(true).write(true).open(&self.part).map_err(failed)?;
        let mut hasher = blake3::Hasher::new();
        hasher.update_reader(&mut file).map_err(failed)?;
        disk::sync(&file).map_err(failed)?;
        (self.bytes, self.blake3) = (hasher.count(), hasher.finalize().to_hex().to_string());
        Ok(())
    }

    /// Writes the whole file by `write`, and closes it.
    pub(super) fn fill(
        mut self,
        file: File,
        write: impl FnOnce(&mut dyn Write) -> mimesh_core::Result<()>,
    ) -> Result<Self, Diagnostic> {
        let mut out = BufWriter::with_capacity(1 << 16, file);
        write(&mut out).map_err(IntoDiagnostic::into_diagnostic)?;
        out.flush().map_err(|error| Error::write(&self.place, error).into_diagnostic())?;
        drop(out);
        self.close()?;
        Ok(self)
    }

    /// Where the file will be.
    pub fn place(&self) -> &Path {
        &self.place
    }

    /// Notes the poses that the file has under another name, with that name.
    pub fn set_renamed(&mut self, renamed: &[(String, String)]) {
        self.renamed = renamed.iter().cloned().collect();
    }

    /// The file as it will be in its place.
    pub fn written(&self) -> WrittenFile {
        let Self { place, bytes, blake3, renamed, .. } = self;
        WrittenFile { path: place.clone(), bytes: *bytes, blake3: blake3.clone(), renamed: renamed.clone() }
    }
}

impl Drop for Staged {
    fn drop(&mut self) {
        let mut temporary = registry::locked();
        if temporary.forget(&self.part) {
            let _ = std::fs::remove_file(&self.part);
        }
    }
}
