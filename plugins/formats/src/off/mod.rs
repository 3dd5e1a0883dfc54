//! OFF, in and out: Geomview's text format, with normals, texture coordinates and colours.

mod reader;
mod writer;

use std::{io::Write, path::Path};

use mimesh_core::{
    Error, Result,
    mesh::{Mesh, MeshSequence, check_finite},
    register,
    stage::{FileInput, Format, MeshWriter, PoseWriter, Selection, WriteError, check_pose, check_vertices},
};
use nalgebra::Point3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{counts, encoding::utf8, lost};

register!(Format: Off);

/// OFF as text: polygons, normals, texture coordinates, colours of vertices and faces; one file a pose.
///
/// The kinds OFF, COFF, NOFF, STOFF and their combinations are read, and that of the mesh is written.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Off {}

#[typetag::serde(name = "off")]
impl Format for Off {
    fn extensions(&self) -> &'static [&'static str] {
        &["off", "coff", "noff", "cnoff"]
    }

    fn recognises(&self, start: &[u8], _: u64) -> Option<bool> {
        Some(reader::is_off(start))
    }

    fn vertex_count(&self, input: &dyn FileInput) -> Option<usize> {
        counts::of_off(input)
    }

    fn read(&self, input: &dyn FileInput, _: &Selection) -> Result<MeshSequence> {
        let (bytes, mut warnings) = utf8(input.contents()?);
        let rest = reader::read(input.path(), &bytes, &mut warnings)?;
        Ok(MeshSequence { rest, warnings, ..MeshSequence::default() })
    }

    fn read_pose(&self, input: &dyn FileInput, selection: &Selection, rest: &Mesh) -> Result<Vec<Point3<f64>>> {
        let (path, (bytes, _)) = (input.path(), utf8(input.contents()?));
        if selection.same_vertices {
            let positions = reader::read_positions(path, &bytes)?;
            check_vertices(path, rest, positions.len())?;
            return Ok(positions);
        }
        let pose = reader::read(path, &bytes, &mut Vec::new())?;
        check_pose(path, rest, pose.positions.len(), &pose.polygons)?;
        Ok(pose.positions)
    }

    fn writer(&self) -> Option<MeshWriter<'_>> {
        Some(MeshWriter::Pose(self))
    }
}

impl PoseWriter for Off {
    fn write(&self, mesh: &Mesh, positions: &[Point3<f64>], out: &mut dyn Write) -> Result<(), WriteError> {
        Error::check_shape("posed vertices (#V)", mesh.positions.len(), positions.len())?;
        check_finite(positions)?;
        Ok(out.write_all(&writer::write(mesh, positions))?)
    }

    fn warnings(&self, _: &Path, mesh: &Mesh) -> Vec<String> {
        lost::sentence("OFF", mesh, &writer::kept(mesh)).into_iter().collect()
    }
}
