use mimesh_core::{Result, mesh::Polygons};

use super::{
    entries::{color_slot, color_type, for_each, unit},
    header::{Element, Property, Scalar},
    values::Values,
};

/// The faces of a file, and triangles that it holds as strips.
#[derive(Default)]
pub struct Faces {
    polygons: Polygons,
    /// The first face with a corner that is no vertex of any file, and that corner.
    wrong: Option<(usize, f64)>,
    /// Texture coordinates of the corners, from the first face with such on those of all.
    wedges: Vec<[f64; 2]>,
    /// Those of faces, if these have colours.
    color_slots: Vec<[f64; 4]>,
    /// The type of colours.
    pub color: Option<Scalar>,
    /// The faces of fewer than three corners, which are left out.
    pub short: usize,
    /// The faces with texture coordinates whose list is of another length than their corners ask for.
    pub uneven: usize,
    /// The face at hand.
    vertices: Vec<u32>,
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
        if !face.wedges.is_empty() || !self.wedges.is_empty() {
            self.wedges.resize(self.polygons.corner_count(), [0.0; 2]);
            self.uneven += usize::from(!face.wedges.is_empty() && face.wedges.len() != 2 * face.corners.len());
            let wedge = |k: usize| face.wedges.get(2 * k..2 * k + 2).map_or([0.0; 2], |uv| [uv[0], uv[1]]);
            self.wedges.extend((0..face.corners.len()).map(wedge));
        }
        if self.color.is_some() {
            self.color_slots.resize(self.polygons.len(), [0.0; 4]);
            self.color_slots.push(face.color);
        }
        self.add_polygon(face.corners.iter().copied());
    }

    fn add_polygon(&mut self, corners: impl Iterator<Item = f64>) {
        let face = self.polygons.len();
        let is_vertex = |corner: f64| corner.fract() == 0.0 && (0.0..f64::from(u32::MAX)).contains(&corner);
        let wrong = &mut self.wrong;
        self.vertices.clear();
        self.vertices.extend(corners.map(|corner| {
            if !is_vertex(corner) {
                wrong.get_or_insert((face, corner));
            }
            corner as u32
        }));
        self.polygons.push(&self.vertices);
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
                        self.add_polygon([a, b, c].into_iter());
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
    pub fn polygons(&mut self, vertices: usize) -> Result<Polygons, String> {
        let is_wrong = |face: &usize| self.polygons.get(*face).iter().any(|&corner| corner as usize >= vertices);
        let beyond = (0..self.polygons.len()).find(is_wrong).map(|face| {
            let corners = self.polygons.get(face).iter();
            (face, f64::from(corners.copied().find(|&corner| corner as usize >= vertices).unwrap_or_default()))
        });
        match [self.wrong, beyond].into_iter().flatten().min_by_key(|(face, _)| *face) {
            Some((face, corner)) => {
                Err(format!("face {face} (from 0) refers to vertex {corner}: there are {vertices} (from 0)"))
            }
            None => {
                // The last faces may have neither.
                if !self.wedges.is_empty() {
                    self.wedges.resize(self.polygons.corner_count(), [0.0; 2]);
                }
                self.color_slots.resize(self.color.map_or(0, |_| self.polygons.len()), [0.0; 4]);
                Ok(std::mem::take(&mut self.polygons))
            }
        }
    }

    /// The texture coordinates of all corners, if any face has them; 0 where a face has not as many as corners.
    pub fn texture_coordinates(&mut self) -> Option<Vec<[f64; 2]>> {
        (!self.wedges.is_empty()).then(|| std::mem::take(&mut self.wedges))
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
