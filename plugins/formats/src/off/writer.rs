use std::io::Write;

use mimesh_core::mesh::Mesh;
use nalgebra::Point3;

use crate::{
    attributes::by_vertex,
    extras::{Extras, byte},
    lost::Content,
    normals::PosedNormals,
    number::Decimals,
};

/// What files of `mesh` keep; normals and texture coordinates only where every vertex has one.
pub fn kept(mesh: &Mesh) -> Vec<Content> {
    let mut kept = vec![Content::Polygons, Content::VertexColors, Content::FaceColors];
    let normals = mesh.normals.as_ref().is_some_and(|normals| by_vertex(mesh, normals).is_some());
    let textures = mesh.texture_coordinates.as_ref().is_some_and(|textures| by_vertex(mesh, textures).is_some());
    kept.extend(normals.then_some(Content::Normals));
    kept.extend(textures.then_some(Content::TextureCoordinates));
    kept
}

/// An OFF of `mesh` with its vertices at `positions` (#V × 3).
pub fn write(mesh: &Mesh, positions: &[Point3<f64>]) -> Vec<u8> {
    let normals = mesh.normals.as_ref().and_then(|normals| {
        let of_vertex = by_vertex(mesh, normals)?;
        let values = PosedNormals::new(mesh, &mesh.positions).of_values(mesh, positions);
        Some(of_vertex.into_iter().map(|v| v.map_or([0.0; 3], |v| values[v as usize])).collect::<Vec<_>>())
    });
    let textures = mesh.texture_coordinates.as_ref().and_then(|textures| {
        let of_vertex = by_vertex(mesh, textures)?;
        Some(of_vertex.into_iter().map(|v| v.map_or([0.0; 2], |v| textures.values[v as usize])).collect::<Vec<_>>())
    });
    let colors = mesh.vertex_colors.as_ref().filter(|colors| colors.len() == positions.len());
    let face_colors = Extras::face_colors(mesh);
    let bytes = Extras::of(mesh).is_none_or(|extras| extras.colors_are_bytes);

    let prefix = [(textures.is_some(), "ST"), (colors.is_some(), "C"), (normals.is_some(), "N")];
    let prefix: String = prefix.iter().filter(|(is_there, _)| *is_there).map(|(_, letters)| *letters).collect();
    let header = format!("{prefix}OFF\n# written by mimesh\n{} {} 0\n", positions.len(), mesh.polygons.len());
    let mut out = Out { bytes: header.into_bytes(), colors_are_bytes: bytes };
    let decimals = Decimals::for_positions(mesh.diagonal_of(positions).max(mesh.diagonal()), 6);
    let fine = Decimals::fixed(8);
    for (v, position) in positions.iter().enumerate() {
        out.numbers(position.coords.as_slice(), decimals);
        normals.iter().for_each(|normals| out.numbers(&normals[v], fine));
        colors.iter().for_each(|colors| out.color(colors[v]));
        textures.iter().for_each(|textures| out.numbers(&textures[v], fine));
        out.end();
    }
    for (face, corners) in mesh.polygons.iter().enumerate() {
        out.text(&format!("{} ", corners.len()));
        corners.iter().for_each(|v| out.text(&format!("{v} ")));
        face_colors.iter().for_each(|colors| out.color(colors[face]));
        out.end();
    }
    out.bytes
}

/// The text in the making.
struct Out {
    bytes: Vec<u8>,
    colors_are_bytes: bool,
}

impl Out {
    fn text(&mut self, text: &str) {
        self.bytes.extend_from_slice(text.as_bytes());
    }

    fn numbers(&mut self, numbers: &[f64], decimals: Decimals) {
        for &number in numbers {
            decimals.push(&mut self.bytes, number);
            self.bytes.push(b' ');
        }
    }

    fn color(&mut self, color: [f64; 4]) {
        if !self.colors_are_bytes {
            // A point in every number tells that it is no whole number of 255.
            return self.numbers(&color, Decimals::fixed(8));
        }
        for part in color {
            write!(self.bytes, "{} ", byte(part)).expect("a vector takes what is written to it");
        }
    }

    /// The end of a line, in the place of the last blank.
    fn end(&mut self) {
        self.bytes.pop();
        self.bytes.push(b'\n');
    }
}
