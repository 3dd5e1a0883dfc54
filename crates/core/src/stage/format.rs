use std::{fmt::Debug, path::Path};

use nalgebra::Point3;

use super::{FileInput, MeshWriter, Selection};
use crate::{
    Error, Result,
    mesh::{Mesh, MeshSequence, Polygons},
    spatial::MeshUnits,
};

/// A named node of a scene that may stand for a point of its mesh, such as an empty of Blender.
#[derive(Clone, Debug, PartialEq)]
pub struct ScenePoint {
    /// The name of the node.
    pub name: String,
    /// Where it stands, in the unit and axes in which the mesh is read.
    pub position: Point3<f64>,
    /// Whether the node may be there for others: it has nodes below it, or stands below a joint.
    pub is_doubtful: bool,
}

/// A file format, found by the extension of a path.
///
/// # Contract
///
/// - what it writes it reads back: positions to the format's precision, polygons and their order exactly;
/// - vertex order and count are those of the mesh, unless [`keeps_vertices`](Self::keeps_vertices) says otherwise;
/// - damaged input gives an error that names file and line or element, never a panic.
#[typetag::serde(tag = "type")]
pub trait Format: Debug + Send + Sync {
    /// Extensions in lower case without the dot, e.g. `["obj"]`.
    fn extensions(&self) -> &'static [&'static str];

    /// Whether a file of `length` bytes that begins with `start` is certainly of this format, whatever it is called.
    ///
    /// `start` has the first 4096 bytes, or all of a shorter file. `None` if this format cannot tell: then every file with its extension
    /// counts as its own.
    fn recognises(&self, _start: &[u8], _length: u64) -> Option<bool> {
        None
    }

    /// Whether written files keep vertices and polygons as the mesh has them; false if they hold nothing but triangles.
    fn keeps_vertices(&self) -> bool {
        true
    }

    /// Reads the selected part of a file: a mesh, and its poses.
    ///
    /// # Errors
    ///
    /// [`Error::Io`] if a file cannot be read, [`Error::File`] if its contents are not understood, or have no such part.
    fn read(&self, input: &dyn FileInput, selection: &Selection) -> Result<MeshSequence>;

    /// Reads only the positions of a pose of `rest` (#V × 3), and checks that the file has its vertices, and its polygons unless the
    /// selection has [`same_vertices`](Selection::same_vertices).
    ///
    /// # Errors
    ///
    /// The errors of [`read`](Self::read), and [`Error::File`] that names the counts, or the first polygon, in which the file
    /// differs from `rest`.
    fn read_pose(&self, input: &dyn FileInput, selection: &Selection, rest: &Mesh) -> Result<Vec<Point3<f64>>> {
        let pose = self.read(input, selection)?.rest;
        match selection.same_vertices {
            true => check_vertices(input.path(), rest, pose.positions.len())?,
            false => check_pose(input.path(), rest, pose.positions.len(), &pose.polygons)?,
        }
        Ok(pose.positions)
    }

    /// How many vertices [`read`](Self::read) would give of the whole file, as far as a look at its header or its lines tells.
    fn vertex_count(&self, _input: &dyn FileInput) -> Option<usize> {
        None
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

    /// Whether a file may hold named points, so that one named as markers is asked for them.
    fn holds_points(&self) -> bool {
        false
    }

    /// Reads the named nodes of the scene that stand for nothing else: no mesh, camera, light or joint.
    ///
    /// # Errors
    ///
    /// The errors of [`read`](Self::read).
    fn read_points(&self, _input: &dyn FileInput) -> Result<Vec<ScenePoint>> {
        Ok(Vec::new())
    }

    /// Whether a file holds polygons. A point cache has positions alone: its poses are those of a mesh in another file.
    fn holds_faces(&self) -> bool {
        true
    }

    /// Whether files are read; a format that only writes gives an error in [`read`](Self::read).
    fn reads(&self) -> bool {
        true
    }

    /// How this format writes; `None` if it only reads.
    fn writer(&self) -> Option<MeshWriter<'_>> {
        None
    }

    /// The unit and the upward axis in which [`read`](Self::read) gives every mesh, as far as files say them.
    fn reads_in(&self) -> MeshUnits {
        MeshUnits::default()
    }

    /// This format for meshes in `units`, where its files say in which unit and axes they are. `None` for a format of bare numbers:
    /// these are converted before they are written.
    fn with_units(&self, _units: MeshUnits) -> Option<Box<dyn Format>> {
        None
    }
}

/// Checks that a pose read from `path` has as many vertices as `rest`.
///
/// # Errors
///
/// [`Error::File`] that names both counts.
pub fn check_vertices(path: &Path, rest: &Mesh, vertices: usize) -> Result<()> {
    if vertices == rest.positions.len() {
        return Ok(());
    }
    let message = format!("pose has {vertices} vertices, the rest mesh {}", rest.positions.len());
    let hint = "a pose has the vertices and polygons of the rest mesh in the same order; export both with one setting";
    Err(Error::file(path, message, hint))
}

/// Checks that a pose read from `path`, of `vertices` vertices and of `polygons`, is a pose of `rest`.
///
/// # Errors
///
/// [`Error::File`] that names the counts, or the first polygon (from 0), in which they differ.
pub fn check_pose(path: &Path, rest: &Mesh, vertices: usize, polygons: &Polygons) -> Result<()> {
    let differ = |message: String| {
        let hint = "a pose has the vertices and polygons of the rest mesh in the same order; export both with one setting, \
             or write `poses: { files: …, same_vertices: true }` if its vertices are in that order";
        Err(Error::file(path, message, hint))
    };
    check_vertices(path, rest, vertices)?;
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
