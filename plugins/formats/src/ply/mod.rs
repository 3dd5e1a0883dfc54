//! Stanford PLY, in and out: ASCII and both binary encodings.
//!
//! In: positions, polygons and strips, normals and colours of vertices, colours of faces, texture coordinates of vertices or of corners.
//! The numbers are read here, since the crates at hand want every entry of a text on a line of its own.

mod entries;
mod faces;
mod header;
mod reader;
mod values;
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

use crate::{counts, lost, single};

register!(Format: Ply);

/// Stanford PLY: polygons, normals, texture coordinates, colours of vertices and faces; one file a pose.
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

    fn recognises(&self, start: &[u8], _: u64) -> Option<bool> {
        let bytes = start.strip_prefix(b"\xef\xbb\xbf").unwrap_or(start);
        Some(bytes.strip_prefix(b"ply").is_some_and(|rest| rest.starts_with(b"\n") || rest.starts_with(b"\r")))
    }

    fn vertex_count(&self, input: &dyn FileInput) -> Option<usize> {
        counts::of_ply(input)
    }

    fn read(&self, input: &dyn FileInput, _: &Selection) -> Result<MeshSequence> {
        reader::read(input.path(), &input.contents()?)
    }

    fn read_pose(&self, input: &dyn FileInput, selection: &Selection, rest: &Mesh) -> Result<Vec<Point3<f64>>> {
        let path = input.path();
        if selection.same_vertices {
            let positions = reader::read_positions(path, &input.contents()?)?;
            check_vertices(path, rest, positions.len())?;
            return Ok(positions);
        }
        let pose = self.read(input, selection)?.rest;
        check_pose(path, rest, pose.positions.len(), &pose.polygons)?;
        Ok(pose.positions)
    }

    fn writer(&self) -> Option<MeshWriter<'_>> {
        Some(MeshWriter::Pose(self))
    }
}

impl PoseWriter for Ply {
    fn write(&self, mesh: &Mesh, positions: &[Point3<f64>], out: &mut dyn Write) -> Result<(), WriteError> {
        Error::check_shape("posed vertices (#V)", mesh.positions.len(), positions.len())?;
        check_finite(positions)?;
        single::check_textures(mesh, "PLY")?;
        let size = positions.iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
        if self.precision == Precision::Float && size > f64::from(f32::MAX) {
            let message = format!("a coordinate of {size:e} is beyond the numbers of `float`");
            return Err(Error::data(message, "set `precision: double`, or scale the mesh down").into());
        }
        Ok(out.write_all(&writer::write(self, mesh, positions))?)
    }

    fn warnings(&self, _: &Path, mesh: &Mesh) -> Vec<String> {
        use lost::Content::{FaceColors, Polygons, TextureCoordinates, VertexColors};
        let mut kept = vec![Polygons, TextureCoordinates, VertexColors, FaceColors];
        // Normals of corners have no place in a PLY.
        kept.extend(writer::keeps_normals(mesh).then_some(lost::Content::Normals));
        lost::sentence("PLY", mesh, &kept).into_iter().collect()
    }
}

impl Encoding {
    /// The encoding that a header calls `name`.
    fn named(name: &str) -> Option<Self> {
        [Self::Ascii, Self::BinaryLittleEndian, Self::BinaryBigEndian].into_iter().find(|other| other.name() == name)
    }

    fn name(self) -> &'static str {
        match self {
            Self::Ascii => "ascii",
            Self::BinaryLittleEndian => "binary_little_endian",
            Self::BinaryBigEndian => "binary_big_endian",
        }
    }
}
