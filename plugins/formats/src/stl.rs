//! STL, in: triangles without names, joined where their corners have the same coordinates.

use std::io::Cursor;

use mimesh_core::{
    Error, Result,
    mesh::{Mesh, MeshSequence},
    register,
    stage::{FileInput, Format, Selection},
};
use nalgebra::Point3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

register!(Format: Stl);

/// STL, binary or ASCII, for reading.
///
/// Vertices are numbered by first use. A pose can be read only if the same corners coincide in it as at rest.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Stl {}

#[typetag::serde(name = "stl")]
impl Format for Stl {
    fn extensions(&self) -> &'static [&'static str] {
        &["stl"]
    }

    fn read(&self, input: &dyn FileInput, _: &Selection) -> Result<MeshSequence> {
        let path = input.path();
        let bytes = input.contents()?.into_owned();
        let hint = "the file is damaged or cut short: export it again";
        let stl = stl_io::read_stl(&mut Cursor::new(uniform(bytes)))
            .map_err(|problem| Error::file(path, format!("not an STL: {problem}"), hint))?;
        let mut mesh = Mesh::default();
        mesh.positions.extend(stl.vertices.iter().map(|v| Point3::from(v.0.map(f64::from))));
        stl.faces.iter().for_each(|face| mesh.polygons.push(&face.vertices.map(|v| v as u32)));
        match mesh.validate() {
            Err(Error::Data { message, hint }) => Err(Error::file(path, message, hint)),
            Err(other) => Err(other),
            Ok(()) => Ok(MeshSequence { rest: mesh, ..MeshSequence::default() }),
        }
    }
}

/// The file in the form that `stl_io` knows: a binary header may begin with `solid` as ASCII files do, an ASCII file may
/// hold several solids, a name may be missing or no UTF-8, and words may be in capitals.
fn uniform(mut bytes: Vec<u8>) -> Vec<u8> {
    let triangles = bytes.get(80..84).map(|n| u32::from_le_bytes(n.try_into().expect("the slice has four bytes")));
    let is_binary = triangles.is_some_and(|n| bytes.len() as u64 == 84 + 50 * u64::from(n));
    let starts_as_text = bytes.trim_ascii_start().get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    if is_binary || !starts_as_text {
        bytes.iter_mut().take(80).for_each(|byte| *byte = b' ');
        return bytes;
    }
    let mut text = b"solid \n".to_vec();
    for line in bytes.split(|&b| b == b'\n') {
        let line = line.trim_ascii().to_ascii_lowercase();
        if !line.starts_with(b"solid") && !line.starts_with(b"endsolid") {
            text.extend_from_slice(&line);
            text.push(b'\n');
        }
    }
    text.extend_from_slice(b"endsolid\n");
    text
}
