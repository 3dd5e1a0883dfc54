use std::path::Path;

use mimesh_core::{
    Error, Result,
    mesh::{CornerAttribute, Document, Mesh, MeshSequence},
};
use nalgebra::Point3;

use super::{
    entries::{color_slot, color_type, for_each, unit},
    faces::Faces,
    header::{Element, Header, Property, Scalar},
    values::Values,
};
use crate::{
    encoding,
    extras::Extras,
    names::{quoted, shown},
    single,
};

/// No more of what is left out is told by name.
const MAX_LEFT_OUT: usize = 40;

/// The entries of a file.
#[derive(Default)]
pub struct Entries {
    vertices: Vertices,
    pub faces: Faces,
    left_out: Vec<String>,
    warnings: Vec<String>,
    double: bool,
    texture: Option<String>,
}

/// Reads the mesh in `bytes`; `path` is for messages.
///
/// # Errors
///
/// [`Error::File`] if the header or an element is damaged, or there are no polygons.
pub fn read(path: &Path, bytes: &[u8]) -> Result<MeshSequence> {
    let Entries { vertices, mut faces, mut left_out, mut warnings, double, texture } = entries(path, bytes)?;
    let damaged = |message: String| Error::file(path, message, "the file is damaged or cut short: export it again");
    let mut mesh = Mesh { positions: vertices.positions(), ..Mesh::default() };
    if faces.short > 0 {
        warnings.push(format!("{} faces of fewer than three corners are left out", faces.short));
    }
    mesh.polygons = faces.polygons(mesh.positions.len()).map_err(damaged)?;
    if mesh.polygons.is_empty() {
        let message = format!("empty mesh: {} vertices, 0 faces", mesh.positions.len());
        let hint = "give a mesh with at least one `face` of three corners, or `tristrips`; point clouds are not read";
        return Err(Error::file(path, message, hint));
    }
    mesh.validate().map_err(|problem| match problem {
        Error::Data { message, hint } => Error::file(path, message, hint),
        other => other,
    })?;
    let by_vertex = |mesh: &Mesh| mesh.polygons.corners().iter().map(|&v| Some(v)).collect::<Vec<_>>();
    let mut unreadable = 0;
    mesh.normals = vertices.columns([3, 4, 5]).map(|values| attribute(values, by_vertex(&mesh), &mut unreadable));
    mesh.texture_coordinates = match faces.texture_coordinates() {
        Some(of_corners) => {
            let indices = (0..).take(of_corners.len()).map(Some).collect();
            Some(attribute(of_corners, indices, &mut unreadable))
        }
        None => vertices.columns([6, 7]).map(|values| attribute(values, by_vertex(&mesh), &mut unreadable)),
    };
    if unreadable > 0 {
        warnings.push(format!("{unreadable} texture coordinates or normals are not finite numbers and were read as 0"));
    }
    if faces.uneven > 0 {
        warnings.push(format!("{} faces have a list `texcoord` of other than two numbers a corner", faces.uneven));
    }
    mesh.vertex_colors = vertices.colors();
    left_out.extend(texture.map(|name| format!("the name of the texture file `{}`", shown(&name))));
    let colors_are_bytes = vertices.colors.or(faces.color).is_none_or(|scalar| scalar == Scalar::U8);
    mesh.document = Document::new(Extras { double, colors_are_bytes, face_colors: faces.colors(), left_out });
    Ok(MeshSequence { rest: mesh, warnings, ..MeshSequence::default() })
}

/// Reads only the positions of vertices, #V × 3; the file may have no faces.
///
/// # Errors
///
/// As [`read`].
pub fn read_positions(path: &Path, bytes: &[u8]) -> Result<Vec<Point3<f64>>> {
    Ok(entries(path, bytes)?.vertices.positions())
}

fn entries(path: &Path, bytes: &[u8]) -> Result<Entries> {
    let text = encoding::from_utf16(bytes);
    let bytes = text.as_deref().unwrap_or(bytes);
    let header = Header::read(path, bytes)?;
    let mut values = Values::new(path, bytes, &header);
    let mut entries = Entries { texture: header.texture.clone(), ..Entries::default() };
    entries.warnings.extend(text.is_some().then(|| encoding::NOTE.into()));
    for element in &header.elements {
        match element.name.as_str() {
            "vertex" => entries.vertices.read(element, &mut values)?,
            "face" => entries.faces.read(element, &mut values)?,
            "tristrips" => entries.faces.read_strips(element, &mut values)?,
            name => {
                if entries.left_out.len() < MAX_LEFT_OUT {
                    entries.left_out.push(format!("the element `{name}`"));
                }
                for_each(element, &mut values, |_, _, _| {})?;
            }
        }
        entries.left_out.extend(unknown(element));
        entries.warnings.extend(floating(element));
    }
    check_coordinates(path, &header, &entries.vertices)?;
    entries.double = header.elements.iter().any(|element| {
        let is_double = |p: &Property| p.name == "x" && p.scalar == Scalar::F64;
        element.name == "vertex" && element.properties.iter().any(is_double)
    });
    values.finish(&mut entries.warnings)?;
    Ok(entries)
}

/// Checks that vertices have three coordinates.
fn check_coordinates(path: &Path, header: &Header, vertices: &Vertices) -> Result<()> {
    let Some(missing) = ["x", "y", "z"].into_iter().zip(0..).find(|(_, slot)| !vertices.given[*slot]) else {
        return Ok(());
    };
    let missing = missing.0;
    let of_name = header.elements.iter().find(|element| element.name == "vertex");
    let message = match of_name {
        Some(element) => {
            let names: Vec<_> = element.properties.iter().map(|property| &property.name).collect();
            let found = if names.is_empty() { "none".into() } else { quoted(&names) };
            format!("the element `vertex` has no property `{missing}`: expected numbers x, y and z, found {found}")
        }
        None => {
            let names: Vec<_> = header.elements.iter().map(|element| &element.name).collect();
            let found = if names.is_empty() { "none".into() } else { quoted(&names) };
            format!("the header has no element `vertex`: expected vertices with x, y and z, found {found}")
        }
    };
    Err(Error::file(path, message, "name coordinates x, y and z in the header, or export the mesh again as PLY"))
}

/// The sentence about lists of a face whose lengths or corners are stored as numbers with a fraction.
fn floating(element: &Element) -> Option<String> {
    if !matches!(&*element.name, "face" | "tristrips") {
        return None;
    }
    let is_float = |scalar: Scalar| matches!(scalar, Scalar::F32 | Scalar::F64);
    let is_wrong = |p: &&Property| {
        p.list.is_some_and(is_float) || p.list.is_some() && is_float(p.scalar) && p.name.starts_with("vertex_ind")
    };
    let names: Vec<_> = element.properties.iter().filter(is_wrong).map(|property| &property.name).collect();
    (!names.is_empty()).then(|| {
        format!(
            "lists of {} whose lengths or vertices are `float`, where whole numbers belong: {}",
            element.name,
            quoted(&names)
        )
    })
}

/// The names of the properties of vertices and faces that are not read.
fn unknown(element: &Element) -> Option<String> {
    let is_known: fn(&Property) -> bool = match element.name.as_str() {
        "vertex" => |property| property.list.is_none() && slot_of(&property.name).is_some(),
        "face" => Faces::knows,
        _ => return None,
    };
    let names: Vec<_> = element.properties.iter().filter(|p| !is_known(p)).map(|property| &property.name).collect();
    (!names.is_empty()).then(|| format!("the {} properties {}", element.name, quoted(&names)))
}

/// An attribute of corners; what is not finite as a 32-bit number is 0, since no stage depends on it and no PLY could have it again.
///
/// How many that were is added to `unreadable`.
fn attribute<const N: usize>(
    mut values: Vec<[f64; N]>,
    indices: Vec<Option<u32>>,
    unreadable: &mut usize,
) -> CornerAttribute<[f64; N]> {
    let is_readable = |x: &f64| x.abs() <= single::MAX;
    for value in values.iter_mut().filter(|value| !value.iter().all(is_readable)) {
        *unreadable += 1;
        value.iter_mut().filter(|x| !is_readable(x)).for_each(|x| *x = 0.0);
    }
    CornerAttribute { values, indices }
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
        name => 8 + color_slot(name)?,
    })
}

/// The vertices, by [`slot_of`] the names of their properties.
#[derive(Default)]
struct Vertices {
    /// The numbers of each slot that the file has, by vertex.
    slots: [Vec<f64>; 12],
    count: usize,
    /// Which slots the file has.
    given: [bool; 12],
    /// The type of colours.
    colors: Option<Scalar>,
}

impl Vertices {
    fn read(&mut self, element: &Element, values: &mut Values<'_>) -> Result<()> {
        let place = |property: &Property| slot_of(&property.name).filter(|_| property.list.is_none());
        let places: Vec<_> = element.properties.iter().map(place).collect();
        places.iter().flatten().for_each(|&slot| self.given[slot] = true);
        self.colors = color_type(element);
        values.check_room(element)?;
        self.count = element.count;
        for (slot, _) in self.slots.iter_mut().zip(self.given).filter(|(_, given)| *given) {
            *slot = vec![0.0; element.count];
        }
        for_each(element, values, |entry, property, numbers| {
            if let Some(slot) = places[property] {
                self.slots[slot][entry] = numbers[0];
            }
        })
    }

    fn has(&self, slots: &[usize]) -> bool {
        slots.iter().all(|&slot| self.given[slot])
    }

    fn columns<const N: usize>(&self, slots: [usize; N]) -> Option<Vec<[f64; N]>> {
        self.has(&slots).then(|| (0..self.count).map(|vertex| slots.map(|slot| self.slots[slot][vertex])).collect())
    }

    fn positions(&self) -> Vec<Point3<f64>> {
        let [x, y, z, ..] = &self.slots;
        x.iter().zip(y).zip(z).map(|((x, y), z)| Point3::new(*x, *y, *z)).collect()
    }

    fn colors(&self) -> Option<Vec<[f64; 4]>> {
        let full = self.colors?.full()?;
        // Opaque, where a file has no opacity.
        let part = |slot: usize, vertex: usize| self.slots[slot].get(vertex).map_or(1.0, |x| unit(x / full));
        Some((0..self.count).map(|vertex| [8, 9, 10, 11].map(|slot| part(slot, vertex))).collect())
    }
}
