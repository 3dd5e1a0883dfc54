use std::{io::Cursor, path::Path};

use mimesh_core::{
    Error, Result,
    mesh::{CornerAttribute, Document, Mesh, MeshSequence},
};
use nalgebra::Point3;
use ply_rs_bw::{
    parser::{ParseError, Parser, Reader},
    ply::{ElementDef, Property, PropertyAccess, PropertyAccessResult, PropertyType, ScalarType},
};

use super::PlyDocument;

/// Reads the mesh in `bytes`; `path` is for messages.
///
/// # Errors
///
/// [`Error::File`] if the header or an element is damaged, or there are no polygons.
pub fn read(path: &Path, bytes: &[u8]) -> Result<MeshSequence> {
    let unreadable = |problem: ParseError| Error::File {
        path: path.into(),
        line: problem.line(),
        message: format!("not a PLY: {}", flat(&problem.to_string())),
        hint: "the file is damaged or cut short: export it again".into(),
    };
    let damaged = |message: String| Error::file(path, message, "the file is damaged or cut short: export it again");
    let mut reader = Reader::new(Cursor::new(bytes));
    let header = Parser::<Skipped>::new().read_header(&mut reader).map_err(unreadable)?;
    let mut vertices = Vec::new();
    let mut faces = Vec::new();
    let mut kept = VertexColumns::default();
    for element in header.elements.values() {
        // Every entry takes at least a byte; without this a damaged count would be counted to its end.
        if element.count > bytes.len() {
            let message = format!("{} {} entries in a file of {} bytes", element.count, element.name, bytes.len());
            return Err(damaged(message));
        }
        match element.name.as_str() {
            "vertex" => {
                kept = VertexColumns::new(element);
                vertices = Parser::<Vertex>::new()
                    .read_payload_for_element(&mut reader, element, &header)
                    .map_err(unreadable)?;
            }
            "face" => {
                faces = Parser::<Face>::new()
                    .read_payload_for_element(&mut reader, element, &header)
                    .map_err(unreadable)?;
            }
            _ => {
                Parser::<Skipped>::new().read_payload_for_element(&mut reader, element, &header).map_err(unreadable)?;
            }
        }
    }

    if !kept.positions {
        return Err(damaged("no vertices with x, y and z".into()));
    }
    let mut mesh =
        Mesh { positions: vertices.iter().map(|v| Point3::from(v.take([0, 1, 2]))).collect(), ..Mesh::default() };
    let mut corners = Vec::new();
    for (index, face) in faces.iter().enumerate() {
        corners.clear();
        for &corner in &face.corners {
            let vertex = u32::try_from(corner).ok().filter(|&v| (v as usize) < vertices.len());
            corners.push(vertex.ok_or_else(|| {
                let count = vertices.len();
                damaged(format!("face {index} (from 0) refers to vertex {corner}: there are {count} (from 0)"))
            })?);
        }
        if corners.len() < 3 {
            return Err(damaged(format!("face {index} (from 0) has {} corners, expected at least 3", corners.len())));
        }
        mesh.polygons.push(&corners);
    }
    if mesh.polygons.is_empty() {
        let message = format!("empty mesh: {} vertices, 0 faces", vertices.len());
        let hint = "give a mesh with at least one `face` element; point clouds and strips are not read";
        return Err(Error::file(path, message, hint));
    }
    mesh.validate().map_err(|problem| match problem {
        Error::Data { message, hint } => Error::file(path, message, hint),
        other => other,
    })?;
    mesh.normals = kept.normals.then(|| attribute(&mesh, vertices.iter().map(|v| v.take([3, 4, 5])).collect()));
    mesh.texture_coordinates =
        kept.texture.then(|| attribute(&mesh, vertices.iter().map(|v| v.take([6, 7])).collect()));
    let color = |v: &Vertex| v.take([8, 9, 10, 11]).map(|x| x as u8);
    let colors = kept.colors.then(|| vertices.iter().map(color).collect());
    mesh.document = Document::new(PlyDocument { double: kept.double, colors });
    Ok(MeshSequence { rest: mesh, ..MeshSequence::default() })
}

/// A value a vertex as an attribute of corners; what is not finite is 0, since no stage depends on it.
fn attribute<const N: usize>(mesh: &Mesh, mut values: Vec<[f64; N]>) -> CornerAttribute<[f64; N]> {
    values.iter_mut().flatten().filter(|x| !x.is_finite()).for_each(|x| *x = 0.0);
    CornerAttribute { values, indices: mesh.polygons.corners().iter().map(|&v| Some(v)).collect() }
}

/// The library's message on one line, without the line number that is told beside it and without its grammar.
fn flat(message: &str) -> String {
    let words: Vec<_> = message.split_whitespace().collect();
    let words = if words.first() == Some(&"Line") { &words[2.min(words.len())..] } else { &words[..] };
    let end = words.iter().position(|word| *word == "Error:").unwrap_or(words.len());
    words[..end].join(" ")
}

/// The properties that the vertices of a file have.
#[derive(Default)]
struct VertexColumns {
    positions: bool,
    double: bool,
    normals: bool,
    texture: bool,
    colors: bool,
}

impl VertexColumns {
    fn new(element: &ElementDef) -> Self {
        let has = |slots: &[usize]| {
            slots.iter().all(|&slot| element.properties.keys().any(|name| slot_of(name) == Some(slot)))
        };
        let is = |name: &str, wanted: ScalarType| {
            element.properties.get(name).is_some_and(|p| p.data_type == PropertyType::Scalar(wanted))
        };
        Self {
            positions: has(&[0, 1, 2]),
            double: is("x", ScalarType::Double),
            normals: has(&[3, 4, 5]),
            texture: has(&[6, 7]),
            colors: ["red", "green", "blue"].iter().all(|name| is(name, ScalarType::UChar)),
        }
    }
}

/// The place of a property of a vertex.
fn slot_of(name: &str) -> Option<usize> {
    Some(match name {
        "x" => 0,
        "y" => 1,
        "z" => 2,
        "nx" => 3,
        "ny" => 4,
        "nz" => 5,
        "s" | "u" | "texture_u" => 6,
        "t" | "v" | "texture_v" => 7,
        "red" => 8,
        "green" => 9,
        "blue" => 10,
        "alpha" => 11,
        _ => return None,
    })
}

/// The properties of a vertex by [`slot_of`] their name.
struct Vertex([f64; 12]);

impl Vertex {
    fn take<const N: usize>(&self, slots: [usize; N]) -> [f64; N] {
        slots.map(|slot| self.0[slot])
    }
}

impl PropertyAccess for Vertex {
    fn new() -> Self {
        let mut slots = [0.0; 12];
        // Opaque, where a file has no opacity.
        slots[11] = 255.0;
        Self(slots)
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let Some(slot) = slot_of(name) else { return PropertyAccessResult::Ignored };
        self.0[slot] = match property {
            Property::Char(x) => x.into(),
            Property::UChar(x) => x.into(),
            Property::Short(x) => x.into(),
            Property::UShort(x) => x.into(),
            Property::Int(x) => x.into(),
            Property::UInt(x) => x.into(),
            Property::Float(x) => x.into(),
            Property::Double(x) => x,
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

/// The vertices of a face, as the file numbers them.
struct Face {
    corners: Vec<i64>,
}

impl PropertyAccess for Face {
    fn new() -> Self {
        Self { corners: Vec::new() }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if !matches!(name, "vertex_indices" | "vertex_index") {
            return PropertyAccessResult::Ignored;
        }
        self.corners = match property {
            Property::ListChar(list) => list.into_iter().map(i64::from).collect(),
            Property::ListUChar(list) => list.into_iter().map(i64::from).collect(),
            Property::ListShort(list) => list.into_iter().map(i64::from).collect(),
            Property::ListUShort(list) => list.into_iter().map(i64::from).collect(),
            Property::ListInt(list) => list.into_iter().map(i64::from).collect(),
            Property::ListUInt(list) => list.into_iter().map(i64::from).collect(),
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

/// An element that is not kept.
struct Skipped;

impl PropertyAccess for Skipped {
    fn new() -> Self {
        Self
    }
}
