use mimesh_core::{Result, mesh::Polygons};

use super::{
    entries::{color_slot, color_type, for_each, unit},
    header::{Element, Property, Scalar},
    values::Values,
};

/// The faces of a file, and triangles that it holds as strips.
#[derive(Default)]
pub struct Faces {
    /// The vertices of the faces one after another, as the file numbers them.
    corners: Vec<f64>,
    /// Where the corners of each face end.
    ends: Vec<usize>,
    /// Texture coordinates of the corners.
    wedges: Vec<[f64; 2]>,
    has_wedges: bool,
    color_slots: Vec<[f64; 4]>,
    /// The type of colours.
    pub color: Option<Scalar>,
    /// The faces of fewer than three corners, which are left out.
    pub short: usize,
}

/// Lists of vertices have one of these names.
const CORNERS: [&str; 2] = ["vertex_indices", "vertex_index"];

/// Lists of texture coordinates have this name.
const WEDGES: &str = "texcoord";

impl Faces {
    /// Whether a property of faces is read.
    pub fn knows(property: &Property) -> bool {
        match property.list {
            Some(_) => CORNERS.contains(&&*property.name) || property.name == WEDGES,
            None => color_slot(&property.name).is_some(),
        }
    }

    /// Reads the faces.
    ///
    /// # Errors
    ///
    /// If the file ends before.
    pub fn read(&mut self, element: &Element, values: &mut Values<'_>) -> Result<()> {
        self.color = color_type(element);
        let opaque = self.color.and_then(Scalar::full).unwrap_or(1.0);
        let mut face = Face { color: [0.0, 0.0, 0.0, opaque], ..Face::default() };
        let last = element.properties.len().saturating_sub(1);
        for_each(element, values, |_, number, numbers| {
            let property = &element.properties[number];
            match (property.list, &*property.name) {
                (Some(_), name) if CORNERS.contains(&name) => face.corners.extend_from_slice(numbers),
                (Some(_), WEDGES) => face.wedges.extend_from_slice(numbers),
                (None, name) => {
                    if let Some(slot) = color_slot(name) {
                        face.color[slot] = numbers[0];
                    }
                }
                _ => {}
            }
            if number == last {
                self.push(&face);
                face.corners.clear();
                face.wedges.clear();
            }
        })
    }

    fn push(&mut self, face: &Face) {
        if face.corners.len() < 3 {
            self.short += 1;
            return;
        }
        let wedge = |k: usize| face.wedges.get(2 * k..2 * k + 2).map_or([0.0; 2], |uv| [uv[0], uv[1]]);
        self.wedges.extend((0..face.corners.len()).map(wedge));
        self.has_wedges |= !face.wedges.is_empty();
        self.color_slots.push(face.color);
        self.corners.extend_from_slice(&face.corners);
        self.ends.push(self.corners.len());
    }

    /// Reads strips: a triangle from every third vertex on, every second turned over; -1 begins another strip.
    ///
    /// # Errors
    ///
    /// If the file ends before.
    pub fn read_strips(&mut self, element: &Element, values: &mut Values<'_>) -> Result<()> {
        for_each(element, values, |_, number, numbers| {
            let property = &element.properties[number];
            if property.list.is_none() || !CORNERS.contains(&&*property.name) {
                return;
            }
            for strip in numbers.split(|&v| v == -1.0) {
                for (k, window) in strip.windows(3).enumerate() {
                    let [a, b, c] = [window[k % 2], window[1 - k % 2], window[2]];
                    // Strips repeat vertices to turn corners.
                    if a != b && b != c && a != c {
                        self.push(&Face { corners: vec![a, b, c], ..Face::default() });
                    }
                }
            }
        })
    }

    /// The polygons, whose corners are checked against the count of vertices.
    ///
    /// # Errors
    ///
    /// The face that refers to no vertex.
    pub fn polygons(&self, vertices: usize) -> Result<Polygons, String> {
        let mut polygons = Polygons::default();
        let (mut start, mut face) = (0, Vec::new());
        for (index, &end) in self.ends.iter().enumerate() {
            face.clear();
            for &corner in &self.corners[start..end] {
                if !(corner >= 0.0 && corner < vertices as f64 && corner.fract() == 0.0) {
                    return Err(format!(
                        "face {index} (from 0) refers to vertex {corner}: there are {vertices} (from 0)"
                    ));
                }
                face.push(corner as u32);
            }
            polygons.push(&face);
            start = end;
        }
        Ok(polygons)
    }

    /// The texture coordinates of all corners, if any face has them; 0 where a face has not as many as corners.
    pub fn texture_coordinates(&self) -> Option<Vec<[f64; 2]>> {
        self.has_wedges.then(|| self.wedges.clone())
    }

    /// The colours of the faces, each 0 to 1.
    pub fn colors(&self) -> Option<Vec<[f64; 4]>> {
        let full = self.color?.full()?;
        Some(self.color_slots.iter().map(|color| color.map(|x| unit(x / full))).collect())
    }
}

/// A face as it is being read.
#[derive(Default)]
struct Face {
    corners: Vec<f64>,
    wedges: Vec<f64>,
    color: [f64; 4],
}
