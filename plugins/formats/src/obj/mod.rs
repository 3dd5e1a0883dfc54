//! Wavefront OBJ, in and out.
//!
//! A file that was read is written back as it stands: only the coordinates on `v` lines change, and the `vn` lines that
//! follow the surface. Comments, names, materials, texture coordinates, line ends and unknown lines stay byte for byte.
//! Coordinates are read as f64 and keep their order; `tobj` reads the material libraries only, because it numbers vertices
//! anew.

mod colors;
mod corner;
mod document;
mod lexer;
mod libraries;
mod materials;
mod plain;
mod reader;
mod signature;
mod unknown;

use std::{io::Write, path::Path};

use mimesh_core::{
    Error, Result,
    mesh::{Mesh, MeshSequence, check_finite},
    register,
    stage::{FileInput, Format, MeshWriter, PoseWriter, Selection, WriteError},
};
use nalgebra::Point3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{counts, encoding::utf8, lost};
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

    fn recognises(&self, start: &[u8], _: u64) -> Option<bool> {
        Some(signature::is_obj(start))
    }

    fn vertex_count(&self, input: &dyn FileInput) -> Option<usize> {
        counts::of_obj(input)
    }

    fn read(&self, input: &dyn FileInput, selection: &Selection) -> Result<MeshSequence> {
        let (bytes, warnings) = utf8(input.contents()?);
        let mut read = reader::read(input, bytes.into_owned(), selection.keep_document)?;
        read.warnings.extend(warnings);
        Ok(read)
    }

    fn read_pose(&self, input: &dyn FileInput, selection: &Selection, rest: &Mesh) -> Result<Vec<Point3<f64>>> {
        reader::read_pose(input.path(), &utf8(input.contents()?).0, rest, selection.same_vertices)
    }

    fn writer(&self) -> Option<MeshWriter<'_>> {
        Some(MeshWriter::Pose(self))
    }
}

impl PoseWriter for Obj {
    fn write(&self, mesh: &Mesh, positions: &[Point3<f64>], out: &mut dyn Write) -> Result<(), WriteError> {
        self.write_as_from(None, mesh, positions, out)
    }

    fn write_in(
        &self,
        folder: &Path,
        mesh: &Mesh,
        positions: &[Point3<f64>],
        out: &mut dyn Write,
    ) -> Result<(), WriteError> {
        self.write_as_from(Some(folder), mesh, positions, out)
    }

    fn warnings(&self, folder: &Path, mesh: &Mesh) -> Vec<String> {
        use lost::Content::{Groups, Materials, Normals, Objects, Polygons, TextureCoordinates, VertexColors};
        let kept = [Polygons, TextureCoordinates, Normals, VertexColors, Objects, Groups, Materials];
        let warning = match document(mesh) {
            Some(document) => document.libraries.warning(folder),
            None => lost::sentence("OBJ", mesh, &kept),
        };
        warning.into_iter().collect()
    }
}

impl Obj {
    /// Writes a file; material libraries are named as from `folder`, if that is given.
    fn write_as_from(
        &self,
        folder: Option<&Path>,
        mesh: &Mesh,
        positions: &[Point3<f64>],
        out: &mut dyn Write,
    ) -> Result<(), WriteError> {
        Error::check_shape("posed vertices (#V)", mesh.positions.len(), positions.len())?;
        check_finite(positions)?;
        let bytes = match document(mesh) {
            Some(document) => document.with_positions(folder, mesh, positions, self.turn_normals),
            None => plain::write(mesh, positions, self.turn_normals),
        };
        Ok(out.write_all(&bytes)?)
    }
}

/// The file that `mesh` was read from, if it still has its vertices and corners.
fn document(mesh: &Mesh) -> Option<&ObjDocument> {
    mesh.document.get::<ObjDocument>().filter(|document| document.describes(mesh))
}
