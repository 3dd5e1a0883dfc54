use std::io::Write;

use mimesh_core::mesh::{CornerAttribute, Mesh};
use nalgebra::Point3;

use super::{Encoding, Ply, PlyDocument, Precision};
use crate::{normals::PosedNormals, number::Decimals};

/// A PLY of `mesh` with its vertices at `positions` (#V × 3).
///
/// Normals and texture coordinates are written where every vertex has one: seams and hard edges have no place in a PLY.
pub fn write(settings: &Ply, mesh: &Mesh, positions: &[Point3<f64>]) -> Vec<u8> {
    let double = match settings.precision {
        Precision::Auto => needs_double(mesh, positions),
        Precision::Float => false,
        Precision::Double => true,
    };
    let normals = mesh.normals.as_ref().and_then(|normals| {
        let of_vertex = by_vertex(mesh, normals)?;
        let values = PosedNormals::new(mesh, &mesh.positions).of_values(mesh, positions);
        Some(of_vertex.into_iter().map(|v| v.map_or([0.0; 3], |v| values[v as usize])).collect::<Vec<_>>())
    });
    let textures = mesh.texture_coordinates.as_ref().and_then(|textures| {
        let of_vertex = by_vertex(mesh, textures)?;
        Some(of_vertex.into_iter().map(|v| v.map_or([0.0; 2], |v| textures.values[v as usize])).collect::<Vec<_>>())
    });
    let colors = mesh.document.get::<PlyDocument>().and_then(|document| document.colors.as_ref());
    let colors = colors.filter(|colors| colors.len() == positions.len());
    let wide = mesh.polygons.iter().any(|polygon| polygon.len() > 255);

    let kind = if double { "double" } else { "float" };
    let mut header = format!("ply\nformat {} 1.0\ncomment written by mimesh\n", name(settings.encoding));
    header += &format!("element vertex {}\n", positions.len());
    let mut property = |kind: &str, names: &[&str]| {
        names.iter().for_each(|name| header += &format!("property {kind} {name}\n"));
    };
    property(kind, &["x", "y", "z"]);
    property("float", if normals.is_some() { &["nx", "ny", "nz"] } else { &[] });
    property("float", if textures.is_some() { &["s", "t"] } else { &[] });
    property("uchar", if colors.is_some() { &["red", "green", "blue", "alpha"] } else { &[] });
    let count = if wide { "uint" } else { "uchar" };
    let index = if positions.len() > i32::MAX as usize { "uint" } else { "int" };
    header += &format!("element face {}\n", mesh.polygons.len());
    header += &format!("property list {count} {index} vertex_indices\nend_header\n");

    let decimals = Decimals::for_positions(mesh.diagonal_of(positions).max(mesh.diagonal()), 6);
    let mut body = Body { out: header.into_bytes(), encoding: settings.encoding };
    for (v, position) in positions.iter().enumerate() {
        position.iter().for_each(|&x| if double { body.double(x, decimals) } else { body.float(x as f32) });
        normals.iter().flat_map(|normals| normals[v]).for_each(|x| body.float(x as f32));
        textures.iter().flat_map(|textures| textures[v]).for_each(|x| body.float(x as f32));
        colors.iter().flat_map(|colors| colors[v]).for_each(|x| body.byte(x));
        body.end();
    }
    for polygon in mesh.polygons.iter() {
        if wide {
            body.integer(polygon.len() as u32)
        } else {
            body.byte(polygon.len() as u8)
        }
        polygon.iter().for_each(|&v| body.integer(v));
        body.end();
    }
    body.out
}

/// Whether the mesh came with doubles, or f32 would move its vertices by more than 1e-6 of its diagonal.
fn needs_double(mesh: &Mesh, positions: &[Point3<f64>]) -> bool {
    let size = mesh.positions.iter().chain(positions).map(|p| p.coords.amax()).fold(0.0, f64::max);
    let rounding = f64::from(f32::EPSILON) / 2.0 * size;
    let given = mesh.document.get::<PlyDocument>().is_some_and(|document| document.double);
    given || rounding > 1e-6 * mesh.diagonal() || size > f64::from(f32::MAX)
}

/// For each vertex the value that all of its corners have; `None` if any vertex has two.
fn by_vertex<T>(mesh: &Mesh, attribute: &CornerAttribute<T>) -> Option<Vec<Option<u32>>> {
    let mut values = vec![None; mesh.positions.len()];
    for (&vertex, &value) in mesh.polygons.corners().iter().zip(&attribute.indices) {
        let known = &mut values[vertex as usize];
        if known.is_some() && *known != value {
            return None;
        }
        *known = value;
    }
    Some(values)
}

fn name(encoding: Encoding) -> &'static str {
    match encoding {
        Encoding::Ascii => "ascii",
        Encoding::BinaryLittleEndian => "binary_little_endian",
        Encoding::BinaryBigEndian => "binary_big_endian",
    }
}

/// Numbers in the encoding of the file.
struct Body {
    out: Vec<u8>,
    encoding: Encoding,
}

impl Body {
    fn float(&mut self, x: f32) {
        self.put(x.to_le_bytes(), |out| write!(out, "{x} "));
    }

    fn double(&mut self, x: f64, decimals: Decimals) {
        self.put(x.to_le_bytes(), |out| {
            decimals.push(out, x);
            write!(out, " ")
        });
    }

    fn integer(&mut self, x: u32) {
        self.put(x.to_le_bytes(), |out| write!(out, "{x} "));
    }

    fn byte(&mut self, x: u8) {
        self.put([x], |out| write!(out, "{x} "));
    }

    /// The end of an element.
    fn end(&mut self) {
        if self.encoding == Encoding::Ascii {
            self.out.pop();
            self.out.push(b'\n');
        }
    }

    fn put<const N: usize>(&mut self, mut bytes: [u8; N], text: impl FnOnce(&mut Vec<u8>) -> std::io::Result<()>) {
        match self.encoding {
            Encoding::Ascii => text(&mut self.out).expect("a vector takes what is written to it"),
            Encoding::BinaryLittleEndian => self.out.extend_from_slice(&bytes),
            Encoding::BinaryBigEndian => {
                bytes.reverse();
                self.out.extend_from_slice(&bytes);
            }
        }
    }
}
