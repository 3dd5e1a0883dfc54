//! STL, in and out: triangles without names, joined where their corners have the same coordinates.

mod reader;
mod writer;

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

use crate::{encoding::utf8, lost};

register!(Format: Stl);

/// STL: binary or ASCII in, binary out with one file a pose; it holds triangles only.
///
/// Vertices that are read are numbered by first use. A pose can be read only if the same corners coincide in it as at rest. Polygons
/// are written as fans of triangles from their first corner, in 32-bit numbers.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Stl {}

#[typetag::serde(name = "stl")]
impl Format for Stl {
    fn extensions(&self) -> &'static [&'static str] {
        &["stl"]
    }

    fn recognises(&self, start: &[u8], length: u64) -> Option<bool> {
        Some(reader::is_stl(start, length))
    }

    fn keeps_vertices(&self) -> bool {
        false
    }

    fn read(&self, input: &dyn FileInput, _: &Selection) -> Result<MeshSequence> {
        let path = input.path();
        let (bytes, mut warnings) = utf8(input.contents()?);
        let rest = reader::read(path, &bytes, &mut warnings)?;
        Ok(MeshSequence { rest, warnings, ..MeshSequence::default() })
    }

    fn writer(&self) -> Option<MeshWriter<'_>> {
        Some(MeshWriter::Pose(self))
    }
}

impl PoseWriter for Stl {
    fn write(&self, mesh: &Mesh, positions: &[Point3<f64>], out: &mut dyn Write) -> Result<(), WriteError> {
        Error::check_shape("posed vertices (#V)", mesh.positions.len(), positions.len())?;
        check_finite(positions)?;
        Ok(out.write_all(&writer::write(mesh, positions)?)?)
    }

    fn warnings(&self, _: &Path, mesh: &Mesh) -> Vec<String> {
        let rounded = writer::rounding_warning(mesh);
        lost::sentence("STL", mesh, &[]).into_iter().chain(rounded).collect()
    }
}
