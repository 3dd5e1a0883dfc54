use std::{fmt::Debug, path::Path};

use nalgebra::Point3;

use super::{FileInput, MeshWriter, Selection};
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

    /// Reads the selected part of a file: a mesh, and its poses.
    ///
    /// # Errors
    ///
    /// [`Error::Io`] if a file cannot be read, [`Error::File`] if its contents are not understood, or have no such part.
    fn read(&self, input: &dyn FileInput, selection: &Selection) -> Result<MeshSequence>;

    /// Reads only the positions of a pose of `rest` (#V × 3), and checks that the file has its vertices and polygons.
    ///
    /// # Errors
    ///
    /// The errors of [`read`](Self::read), and [`Error::File`] that names the counts, or the first polygon, in which the file
    /// differs from `rest`.
    fn read_pose(&self, input: &dyn FileInput, selection: &Selection, rest: &Mesh) -> Result<Vec<Point3<f64>>> {
        let pose = self.read(input, selection)?.rest;
        check_pose(input.path(), rest, pose.positions.len(), &pose.polygons)?;
        Ok(pose.positions)
    }

    /// The references to other files that [`read`](Self::read) opens, whether these exist or not; none if the file cannot be read.
    ///
    /// A cached result depends on the contents of each of them.
    fn references(&self, _input: &dyn FileInput) -> Vec<String> {
        Vec::new()
    }

    /// Whether a file may hold several poses, so that one named among files of poses is asked for them.
    fn holds_poses(&self) -> bool {
        false
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

crate::stage_kind!(Format, "format");
