use std::io::Write;

use mimesh_core::mesh::{CornerAttribute, Mesh, Part};
use nalgebra::Point3;

use crate::{normals::PosedNormals, number::Decimals};

/// An OBJ of a mesh that did not come from one, with its vertices at `positions` (#V × 3).
pub fn write(mesh: &Mesh, positions: &[Point3<f64>], turn_normals: bool) -> Vec<u8> {
    let mut out = Vec::with_capacity(48 * positions.len() + 32 * mesh.polygons.corner_count());
    out.extend_from_slice(b"# written by mimesh\n");
    let decimals = Decimals::for_positions(mesh.diagonal_of(positions).max(mesh.diagonal()), 6);
    let colors = mesh.vertex_colors.as_ref().filter(|colors| colors.len() == positions.len());
    for (v, position) in positions.iter().enumerate() {
        line(&mut out, "v", position.coords.as_slice(), decimals);
        if let Some([r, g, b, _]) = colors.map(|colors| colors[v]) {
            out.pop();
            line(&mut out, "", &[r, g, b], Decimals::fixed(6));
        }
    }
    if let Some(texture) = &mesh.texture_coordinates {
        texture.values.iter().for_each(|value| line(&mut out, "vt", value, Decimals::fixed(8)));
    }
    if let Some(normals) = &mesh.normals {
        let values = if turn_normals {
            PosedNormals::new(mesh, &mesh.positions).of_values(mesh, positions)
        } else {
            normals.values.clone()
        };
        values.iter().for_each(|value| line(&mut out, "vn", value, Decimals::fixed(6)));
    }
    faces(&mut out, mesh);
    out
}

fn line(out: &mut Vec<u8>, keyword: &str, numbers: &[f64], decimals: Decimals) {
    out.extend_from_slice(keyword.as_bytes());
    for &number in numbers {
        out.push(b' ');
        decimals.push(out, number);
    }
    out.push(b'\n');
}

fn faces(out: &mut Vec<u8>, mesh: &Mesh) {
    let mut parts = mesh.parts.iter().peekable();
    let mut last = Part::default();
    for polygon in 0..mesh.polygons.len() {
        while let Some(part) = parts.next_if(|part| part.polygons.start <= polygon) {
            names(out, &last, part);
            last = part.clone();
        }
        out.push(b'f');
        for corner in mesh.polygons.corner_range(polygon) {
            let vertex = mesh.polygons.corners()[corner] + 1;
            let texture = index(&mesh.texture_coordinates, corner);
            let normal = index(&mesh.normals, corner);
            let written = match (texture, normal) {
                (None, None) => write!(out, " {vertex}"),
                (Some(texture), None) => write!(out, " {vertex}/{texture}"),
                (None, Some(normal)) => write!(out, " {vertex}//{normal}"),
                (Some(texture), Some(normal)) => write!(out, " {vertex}/{texture}/{normal}"),
            };
            written.expect("a vector takes what is written to it");
        }
        out.push(b'\n');
    }
}

/// The names of `part` that `last` did not have; line ends in a name would make two lines of it.
fn names(out: &mut Vec<u8>, last: &Part, part: &Part) {
    let mut name = |keyword: &str, name: &str| {
        out.extend_from_slice(format!("{keyword} {}\n", name.replace(['\n', '\r'], " ")).as_bytes());
    };
    if part.object != last.object {
        name("o", part.object.as_deref().unwrap_or("default"));
    }
    if part.groups != last.groups {
        let groups: Vec<_> = part.groups.iter().map(|group| group.replace(char::is_whitespace, "_")).collect();
        name("g", if groups.is_empty() { "default".into() } else { groups.join(" ") }.as_str());
    }
    if part.material != last.material
        && let Some(material) = &part.material
    {
        name("usemtl", material);
    }
}

fn index<T>(attribute: &Option<CornerAttribute<T>>, corner: usize) -> Option<u32> {
    Some(attribute.as_ref()?.indices.get(corner).copied().flatten()? + 1)
}
