//! Stanford PLY, in and out: ASCII and both binary encodings.
//!
//! Read through `ply-rs-bw`: positions, polygons, and of vertices normals, texture coordinates and colours.

mod reader;
mod writer;

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

register!(Format: Ply);

/// Stanford PLY: polygons, normals, texture coordinates and colours of vertices; one file a pose.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Ply {
    /// How numbers are stored in written files.
    pub encoding: Encoding,
    /// Numbers of positions in written files.
    pub precision: Precision,
}

/// How a PLY stores its numbers.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Encoding {
    /// Text.
    Ascii,
    /// Bytes, the lowest first.
    #[default]
    BinaryLittleEndian,
    /// Bytes, the highest first.
    BinaryBigEndian,
}

/// The type of coordinates in a PLY.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Precision {
    /// `float`, which every program reads, unless the mesh came from a PLY with `double` or lies so far from the origin
    /// that `float` would move vertices by more than 1e-6 of its diagonal.
    #[default]
    Auto,
    /// 32 bits.
    Float,
    /// 64 bits.
    Double,
}

#[typetag::serde(name = "ply")]
impl Format for Ply {
    fn extensions(&self) -> &'static [&'static str] {
        &["ply"]
    }

    fn read(&self, input: &dyn FileInput, _: &Selection) -> Result<MeshSequence> {
        reader::read(input.path(), &input.contents()?)
    }

    fn writer(&self) -> Option<MeshWriter<'_>> {
        Some(MeshWriter::Pose(self))
    }
}

impl PoseWriter for Ply {
    fn write(&self, mesh: &Mesh, positions: &[Point3<f64>], out: &mut dyn Write) -> Result<(), WriteError> {
        Error::check_shape("posed vertices (#V)", mesh.positions.len(), positions.len())?;
        check_finite(positions)?;
        let size = positions.iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
        if self.precision == Precision::Float && size > f64::from(f32::MAX) {
            let message = format!("a coordinate of {size:e} is beyond the numbers of `float`");
            return Err(Error::data(message, "set `precision: double`, or scale the mesh down").into());
        }
        Ok(out.write_all(&writer::write(self, mesh, positions))?)
    }
}

/// Data of a PLY that a mesh has no place for.
#[derive(Debug)]
struct PlyDocument {
    /// Whether coordinates are `double`.
    double: bool,
    /// Red, green, blue and opacity of vertices.
    colors: Option<Vec<[u8; 4]>>,
}
