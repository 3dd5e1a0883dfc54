use std::{
    fmt::Debug,
    io::Write,
    path::{Path, PathBuf},
};

use nalgebra::Point3;

use crate::{
    Error, Result,
    mesh::{Mesh, MeshSequence, Polygons},
};

/// A file format, found by the extension of a path.
///
/// # Contract
///
/// - what it writes it reads back: positions to the format's precision, polygons and their order exactly;
/// - vertex order and count are those of the mesh;
/// - damaged input gives an error that names file and line or element, never a panic.
#[typetag::serde(tag = "type")]
pub trait Format: Debug + Send + Sync {
    /// Extensions in lower case without the dot, e.g. `["obj"]`.
    fn extensions(&self) -> &'static [&'static str];

    /// Reads a mesh, and the poses that the file holds.
    ///
    /// # Errors
    ///
    /// [`Error::Io`] if the file cannot be read, [`Error::File`] if its contents are not understood.
    fn read(&self, path: &Path) -> Result<MeshSequence>;

    /// Reads only the positions of a pose of `rest` (#V × 3), and checks that the file has its vertices and polygons.
    ///
    /// # Errors
    ///
    /// The errors of [`read`](Self::read), and [`Error::File`] that names the counts, or the first polygon, in which the file
    /// differs from `rest`.
    fn read_pose(&self, path: &Path, rest: &Mesh) -> Result<Vec<Point3<f64>>> {
        let pose = self.read(path)?.rest;
        check_pose(path, rest, pose.positions.len(), &pose.polygons)?;
        Ok(pose.positions)
    }

    /// All files that reading `path` reads: `path` itself and those that it names, whether they exist or not.
    ///
    /// A cached result depends on the contents of each of them.
    fn files(&self, path: &Path) -> Vec<PathBuf> {
        vec![path.into()]
    }

    /// How this format writes; `None` if it only reads.
    fn writer(&self) -> Option<MeshWriter<'_>> {
        None
    }
}

/// Checks that a pose read from `path`, of `vertices` vertices and of `polygons`, is a pose of `rest`.
///
/// # Errors
///
/// [`Error::File`] that names the counts, or the first polygon (from 0), in which they differ.
pub fn check_pose(path: &Path, rest: &Mesh, vertices: usize, polygons: &Polygons) -> Result<()> {
    let differ = |message: String| {
        let hint =
            "a pose has the vertices and polygons of the rest mesh in the same order; export both with one setting";
        Err(Error::file(path, message, hint))
    };
    if vertices != rest.positions.len() {
        return differ(format!("pose has {vertices} vertices, the rest mesh {}", rest.positions.len()));
    }
    if polygons.len() != rest.polygons.len() {
        return differ(format!("pose has {} polygons, the rest mesh {}", polygons.len(), rest.polygons.len()));
    }
    if *polygons != rest.polygons {
        let differs = |(pose, rest)| pose != rest;
        let polygon = polygons.iter().zip(rest.polygons.iter()).position(differs).unwrap_or_default();
        return differ(format!(
            "polygon {polygon} (from 0) differs: pose has vertices {:?}, the rest mesh {:?}",
            polygons.get(polygon),
            rest.polygons.get(polygon)
        ));
    }
    Ok(())
}

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
}

/// A format that takes a rest mesh and its poses in one file.
pub trait SequenceFormat {
    /// Starts a file for `mesh`; poses are added one by one.
    ///
    /// # Errors
    ///
    /// If the mesh cannot be written in this format, or there is no room for temporary data.
    fn start(&self, mesh: &Mesh) -> Result<Box<dyn SequenceWriter>, WriteError>;
}

/// A file in the making that takes poses.
pub trait SequenceWriter {
    /// Adds a pose.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] if the count differs from the mesh.
    fn add(&mut self, name: &str, positions: &[Point3<f64>]) -> Result<(), WriteError>;

    /// Writes the file.
    ///
    /// # Errors
    ///
    /// Those of `out`.
    fn finish(self: Box<Self>, out: &mut dyn Write) -> Result<(), WriteError>;
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

crate::stage_kind!(Format, "format");
