//! Wavefront OBJ, in and out.
//!
//! A file that was read is written back as it stands: only the coordinates on `v` lines change, and the `vn` lines that
//! follow the surface. Comments, names, materials, texture coordinates, line ends and unknown lines stay byte for byte.
//! Coordinates are read as f64 and keep their order; `tobj` reads the material libraries only, because it numbers vertices
//! anew.

mod corner;
mod document;
mod lexer;
mod materials;
mod plain;
mod reader;

use std::io::Write;

use mimesh_core::{
    Error, Result,
    mesh::{Mesh, MeshSequence, check_finite},
    register,
    stage::{FileInput, Format, MeshWriter, PoseWriter, Selection, WriteError},
};
use nalgebra::Point3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use document::ObjDocument;

register!(Format: Obj);

/// Wavefront OBJ: polygons, texture coordinates, normals, groups and materials; one file a pose.
///
/// A pose is the rest file with new vertex coordinates, each coordinate to at least 5e-10 of the diagonal.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Obj {
    /// Let the normals of the file turn with the surface; false keeps those of the rest pose.
    pub turn_normals: bool,
}

impl Default for Obj {
    fn default() -> Self {
        Self { turn_normals: true }
    }
}

#[typetag::serde(name = "obj")]
impl Format for Obj {
    fn extensions(&self) -> &'static [&'static str] {
        &["obj"]
    }

    fn read(&self, input: &dyn FileInput, _: &Selection) -> Result<MeshSequence> {
        reader::read(input, input.contents()?.into_owned())
    }

    fn read_pose(&self, input: &dyn FileInput, _: &Selection, rest: &Mesh) -> Result<Vec<Point3<f64>>> {
        reader::read_pose(input.path(), &input.contents()?, rest)
    }

    fn writer(&self) -> Option<MeshWriter<'_>> {
        Some(MeshWriter::Pose(self))
    }
}

impl PoseWriter for Obj {
    fn write(&self, mesh: &Mesh, positions: &[Point3<f64>], out: &mut dyn Write) -> Result<(), WriteError> {
        Error::check_shape("posed vertices (#V)", mesh.positions.len(), positions.len())?;
        check_finite(positions)?;
        let bytes = match mesh.document.get::<ObjDocument>().filter(|document| document.describes(mesh)) {
            Some(document) => document.with_positions(mesh, positions, self.turn_normals),
            None => plain::write(mesh, positions, self.turn_normals),
        };
        Ok(out.write_all(&bytes)?)
    }
}
