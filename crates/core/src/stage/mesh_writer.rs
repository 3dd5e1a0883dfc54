use std::{
    fs::File,
    io::{self, Read, Seek, Write},
    path::Path,
};

use nalgebra::Point3;

use crate::{
    Error, Result,
    mesh::{ClipTime, Mesh, PosesAre},
};

/// How a format writes: one file a pose, or all poses in one file.
#[derive(Clone, Copy)]
pub enum MeshWriter<'a> {
    /// One file a pose.
    Pose(&'a dyn PoseWriter),
    /// One file for rest and poses.
    Sequence(&'a dyn SequenceFormat),
}

/// A format that takes one pose a file.
pub trait PoseWriter {
    /// Writes `mesh` with its vertices at `positions`.
    ///
    /// # Errors
    ///
    /// Those of `out`; [`Error::Shape`] if the counts differ.
    fn write(&self, mesh: &Mesh, positions: &[Point3<f64>], out: &mut dyn Write) -> Result<(), WriteError>;

    /// Writes a file that will lie in `folder`, so that its references to other files hold from there.
    ///
    /// # Errors
    ///
    /// Those of [`write`](Self::write).
    fn write_in(
        &self,
        _folder: &Path,
        mesh: &Mesh,
        positions: &[Point3<f64>],
        out: &mut dyn Write,
    ) -> Result<(), WriteError> {
        self.write(mesh, positions, out)
    }

    /// Sentences about data of `mesh` that files in `folder` do not keep, or keep otherwise.
    fn warnings(&self, _folder: &Path, _mesh: &Mesh) -> Vec<String> {
        Vec::new()
    }
}

/// A format that takes a rest mesh and its poses in one file.
pub trait SequenceFormat {
    /// Checks that a file of `mesh` with `poses` poses would not be larger than the format allows.
    ///
    /// # Errors
    ///
    /// [`Error::Data`] with both sizes.
    fn check_size(&self, _mesh: &Mesh, _poses: usize) -> Result<()> {
        Ok(())
    }

    /// Starts a file of `mesh` in `file`, which is empty; at most `poses` poses are added one by one.
    ///
    /// # Errors
    ///
    /// If the mesh cannot be written in this format, or the file cannot be written.
    fn start(
        &self,
        mesh: &Mesh,
        poses: usize,
        file: Box<dyn SequenceFile>,
    ) -> Result<Box<dyn SequenceWriter>, WriteError>;
}

/// A file that takes poses as they come: the writer goes back to its start for what is known only at the end.
pub trait SequenceFile: Read + Write + Seek + Send {
    /// Cuts or extends it to `length` bytes.
    ///
    /// # Errors
    ///
    /// Those of the system.
    fn set_length(&mut self, length: u64) -> io::Result<()>;
}

impl SequenceFile for File {
    fn set_length(&mut self, length: u64) -> io::Result<()> {
        self.set_len(length)
    }
}

/// A file in the making that takes poses.
pub trait SequenceWriter: Send {
    /// Adds a pose, which may be a frame of a clip.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] if the count differs from the mesh, and those of the file.
    fn add(&mut self, name: &str, time: Option<&ClipTime>, positions: &[Point3<f64>]) -> Result<(), WriteError>;

    /// Says what the poses are, before the first; a writer that is not told judges by their names.
    fn set_poses_are(&mut self, _poses: PosesAre) {}

    /// Sentences about what the file does not keep or has under another name, once all poses are added.
    fn warnings(&self) -> Vec<String> {
        Vec::new()
    }

    /// The added poses that the file has under another name, each with that name.
    fn renamed(&self) -> &[(String, String)] {
        &[]
    }

    /// Completes the file.
    ///
    /// # Errors
    ///
    /// Those of the file.
    fn finish(self: Box<Self>) -> Result<(), WriteError>;
}

/// The error of writing, before a path is known.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The sink failed.
    #[error(transparent)]
    Io(#[from] std::io::Error),
    /// The mesh does not go into the format.
    #[error(transparent)]
    Mesh(#[from] Error),
}
