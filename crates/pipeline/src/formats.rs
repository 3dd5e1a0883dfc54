//! Which format reads or writes a path.

use std::path::{Path, PathBuf};

use mimesh_core::{
    Error,
    mesh::{Mesh, MeshSequence},
    plugin,
    stage::{FileInput, Format, MeshWriter, Selection},
};
use mimesh_document::diagnostic::{self, Diagnostic, Kind, Location};
use mimesh_markers::IntoDiagnostic;
use nalgebra::Point3;

use crate::file_on_disk::{FileOnDisk, Reach};

/// The registered formats, with the settings that a pipeline gives some of them, and the files that meshes may open.
#[derive(Debug)]
pub struct Formats {
    all: Vec<Box<dyn Format>>,
    reach: Reach,
}

/// How a path is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Writes {
    /// One file a pose.
    Pose,
    /// One file for rest and poses.
    Sequence,
}

impl Formats {
    /// Every registered format; those in `settings` replace the default of their type. Mesh files open what is in `reach`.
    pub fn new(settings: Vec<Box<dyn Format>>, reach: Reach) -> Self {
        let mut formats: Vec<_> = plugin::instances::<dyn Format>().into_iter().map(|(_, format)| format).collect();
        for format in settings {
            match formats.iter_mut().find(|other| other.typetag_name() == format.typetag_name()) {
                Some(other) => *other = format,
                None => formats.push(format),
            }
        }
        Self { all: formats, reach }
    }

    /// All of them, with their settings.
    pub fn all(&self) -> &[Box<dyn Format>] {
        &self.all
    }

    /// The format of `path`.
    ///
    /// # Errors
    ///
    /// [`Unknown`] with the extensions that are read.
    pub fn reader(&self, path: &Path) -> Result<&dyn Format, Unknown> {
        self.find(path, "read", |_| true)
    }

    /// Reads the selected part of the file `path`.
    ///
    /// # Errors
    ///
    /// Those of the format, and [`Error::File`] for a path that no format fits.
    pub fn read(&self, path: &Path, selection: &Selection) -> Result<MeshSequence, Error> {
        self.reader_for(path)?.read(&self.input(path), selection)
    }

    /// Reads the positions of a pose of `rest` (#V × 3) from the file `path`.
    ///
    /// # Errors
    ///
    /// As [`read`](Self::read), and if the file does not have the vertices and polygons of `rest`.
    pub fn read_pose(&self, path: &Path, selection: &Selection, rest: &Mesh) -> Result<Vec<Point3<f64>>, Error> {
        self.reader_for(path)?.read_pose(&self.input(path), selection, rest)
    }

    /// All files that are read with `path`: itself and those that it refers to; `path` alone if it has no format.
    ///
    /// Those that it may not open are not among them, since nothing may be done with them, not even hashing.
    pub fn files(&self, path: &Path) -> Vec<PathBuf> {
        let input = self.input(path);
        let references = self.reader(path).map(|format| format.references(&input)).unwrap_or_default();
        let referenced = references.iter().map(|reference| input.path_of(reference));
        std::iter::once(path.into()).chain(referenced.filter(|file| input.may_open(file))).collect()
    }

    fn input(&self, path: &Path) -> FileOnDisk<'_> {
        FileOnDisk { path: path.into(), reach: &self.reach }
    }

    fn reader_for(&self, path: &Path) -> Result<&dyn Format, Error> {
        self.reader(path).map_err(|unknown| Error::file(path, unknown.message, unknown.hint))
    }

    /// The format of the file `path`.
    ///
    /// # Errors
    ///
    /// A diagnostic if there is no such file, or no format for it.
    pub fn reader_of(&self, path: &Path) -> diagnostic::Result<&dyn Format> {
        // Of a file that is not there its ending does not matter.
        let metadata = std::fs::metadata(path).map_err(|error| Error::read(path, error).into_diagnostic())?;
        if metadata.is_dir() {
            return Err(Error::read(path, std::io::ErrorKind::IsADirectory.into()).into_diagnostic().into());
        }
        let unreadable = |unknown: Unknown| Diagnostic::new(Kind::BadData, unknown.message).hint(unknown.hint);
        Ok(self.reader(path).map_err(|unknown| unreadable(unknown).at(Location::File(path.into())))?)
    }

    /// The format of `path`, which can write, and how.
    ///
    /// # Errors
    ///
    /// [`Unknown`] with the extensions that are written.
    pub fn writer(&self, path: &Path) -> Result<(&dyn Format, Writes), Unknown> {
        let format = self.find(path, "write", |format| format.writer().is_some())?;
        match format.writer() {
            Some(MeshWriter::Sequence(_)) => Ok((format, Writes::Sequence)),
            _ => Ok((format, Writes::Pose)),
        }
    }

    fn find(&self, path: &Path, does: &str, can: impl Fn(&dyn Format) -> bool) -> Result<&dyn Format, Unknown> {
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        let able = || self.all.iter().map(Box::as_ref).filter(|format| can(*format));
        if let Some(format) = able().find(|f| extension.as_deref().is_some_and(|e| f.extensions().contains(&e))) {
            return Ok(format);
        }
        let known: Vec<_> = able().flat_map(|format| format.extensions().iter().map(|e| format!(".{e}"))).collect();
        let message = match extension {
            Some(extension) => format!("no format can {does} .{extension} files"),
            None => format!("the file name has no extension, so its format is not known to {does} it"),
        };
        Err(Unknown { message, hint: format!("formats that {does}: {}", known.join(", ")) })
    }
}

/// The error of a path that no format fits.
#[derive(Debug)]
pub struct Unknown {
    /// What is wrong.
    pub message: String,
    /// What would do.
    pub hint: String,
}
