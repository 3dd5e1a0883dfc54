use std::io::Write;

use mimesh_core::mesh::Mesh;
use nalgebra::Point3;

use super::{Encoding, Ply, Precision};
use crate::{
    attributes::by_vertex,
    extras::{Extras, byte},
    normals::PosedNormals,
    number::Decimals,
};

/// A PLY of `mesh` with its vertices at `positions` (#V × 3).
///
/// Texture coordinates with seams are those of corners, as MeshLab writes them. Normals are written where every vertex has one: hard
/// edges have no place in a PLY.
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
    let wedges = mesh.texture_coordinates.as_ref().filter(|_| textures.is_none());
    let colors = mesh.vertex_colors.as_ref().filter(|colors| colors.len() == positions.len());
    let face_colors = Extras::face_colors(mesh);
    let bytes = Extras::of(mesh).is_none_or(|extras| extras.colors_are_bytes);
    let most = mesh.polygons.iter().map(<[u32]>::len).max().unwrap_or_default();
    let wide = most > 255 || (wedges.is_some() && most > 127);

    let kind = if double { "double" } else { "float" };
    let mut header = format!("ply\nformat {} 1.0\ncomment written by mimesh\n", settings.encoding.name());
    header += &format!("element vertex {}\n", positions.len());
    let mut property = |kind: &str, names: &[&str]| {
        names.iter().for_each(|name| header += &format!("property {kind} {name}\n"));
    };
    let color = if bytes { "uchar" } else { "float" };
    property(kind, &["x", "y", "z"]);
    property("float", if normals.is_some() { &["nx", "ny", "nz"] } else { &[] });
    property("float", if textures.is_some() { &["s", "t"] } else { &[] });
    property(color, if colors.is_some() { &COLOR } else { &[] });
    let count = if wide { "uint" } else { "uchar" };
    let index = if positions.len() > i32::MAX as usize { "uint" } else { "int" };
    header += &format!("element face {}\n", mesh.polygons.len());
    header += &format!("property list {count} {index} vertex_indices\n");
    if wedges.is_some() {
        header += &format!("property list {count} float texcoord\n");
    }
    if face_colors.is_some() {
        COLOR.iter().for_each(|name| header += &format!("property {color} {name}\n"));
    }
    header += "end_header\n";

    let decimals = Decimals::for_positions(mesh.diagonal_of(positions).max(mesh.diagonal()), 6);
    let mut body = Body { out: header.into_bytes(), encoding: settings.encoding };
    for (v, position) in positions.iter().enumerate() {
        position.iter().for_each(|&x| if double { body.double(x, decimals) } else { body.float(x as f32) });
        normals.iter().flat_map(|normals| normals[v]).for_each(|x| body.float(x as f32));
        textures.iter().flat_map(|textures| textures[v]).for_each(|x| body.float(x as f32));
        colors.iter().flat_map(|colors| colors[v]).for_each(|x| body.color(x, bytes));
        body.end();
    }
    for (face, polygon) in mesh.polygons.iter().enumerate() {
        body.length(polygon.len(), wide);
        polygon.iter().for_each(|&v| body.integer(v));
        if let Some(wedges) = wedges {
            body.length(2 * polygon.len(), wide);
            let value = |corner: usize| wedges.indices[corner].map_or([0.0; 2], |value| wedges.values[value as usize]);
            mesh.polygons.corner_range(face).flat_map(value).for_each(|x| body.float(x as f32));
        }
        face_colors.iter().flat_map(|colors| colors[face]).for_each(|x| body.color(x, bytes));
        body.end();
    }
    body.out
}

/// Whether every vertex has one normal.
pub fn keeps_normals(mesh: &Mesh) -> bool {
    mesh.normals.as_ref().is_some_and(|normals| by_vertex(mesh, normals).is_some())
}

/// The parts of a colour.
const COLOR: [&str; 4] = ["red", "green", "blue", "alpha"];

/// Whether the mesh came with doubles, or f32 would move its vertices by more than 1e-6 of its diagonal.
fn needs_double(mesh: &Mesh, positions: &[Point3<f64>]) -> bool {
    let size = mesh.positions.iter().chain(positions).map(|p| p.coords.amax()).fold(0.0, f64::max);
    let rounding = f64::from(f32::EPSILON) / 2.0 * size;
    let given = Extras::of(mesh).is_some_and(|extras| extras.double);
    given || rounding > 1e-6 * mesh.diagonal() || size > f64::from(f32::MAX)
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

    /// The length of a list.
    fn length(&mut self, length: usize, wide: bool) {
        if wide { self.integer(length as u32) } else { self.byte(length as u8) }
    }

    /// A part of a colour, 0 to 1.
    fn color(&mut self, x: f64, as_byte: bool) {
        if as_byte { self.byte(byte(x)) } else { self.float(x as f32) }
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
