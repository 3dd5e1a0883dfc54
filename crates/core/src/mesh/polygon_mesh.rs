use std::{any::Any, fmt, sync::Arc};

use nalgebra::Point3;

use super::{
    attributes::{CornerAttribute, Material, Part},
    bounds::{bounding_box, check_finite, used_by_faces},
    polygons::Polygons,
};
use crate::{Error, Result};

/// A polygon mesh as its file gives it.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// V, #V × 3, in the unit of the file and in the order of the file.
    pub positions: Vec<Point3<f64>>,
    /// The polygons, as corners into `positions`, counter-clockwise seen from outside.
    pub polygons: Polygons,
    /// Texture coordinates of the corners, if there are any.
    pub texture_coordinates: Option<CornerAttribute<[f64; 2]>>,
    /// Normals of the corners, if the file gives them.
    pub normals: Option<CornerAttribute<[f64; 3]>>,
    /// Red, green, blue (sRGB) and opacity of the vertices, #V × 4, each 0 to 1, if the file gives them.
    pub vertex_colors: Option<Vec<[f64; 4]>>,
    /// Runs of polygons with one object, group and material name; they cover the polygons in order.
    pub parts: Vec<Part>,
    /// The materials that parts name, as far as they are known.
    pub materials: Vec<Material>,
    /// Data of the file's reader for a writer of the same format.
    pub document: Document,
}

impl Mesh {
    /// A mesh of triangles and nothing else.
    pub fn from_triangles(positions: Vec<Point3<f64>>, triangles: &[[u32; 3]]) -> Self {
        Self { positions, polygons: triangles.iter().map(|t| &t[..]).collect(), ..Self::default() }
    }

    /// Checks what every stage relies on: there are vertices and polygons, coordinates are finite, corners exist.
    ///
    /// # Errors
    ///
    /// [`Error::Data`] that names the first offending vertex or polygon, counted from 0.
    pub fn validate(&self) -> Result<()> {
        if self.positions.is_empty() || self.polygons.is_empty() {
            return Err(Error::data(
                format!("empty mesh: {} vertices, {} polygons", self.positions.len(), self.polygons.len()),
                "give a mesh with at least one triangle; point clouds and curves cannot take a deformation, and a point cache has poses alone",
            ));
        }
        check_finite(&self.positions)?;
        if let Some(part) = self.parts.iter().find(|part| part.polygons.end > self.polygons.len()) {
            return Err(Error::data(
                format!("a part has polygons up to {}, but there are {}", part.polygons.end, self.polygons.len()),
                "this is a mistake in the program that made the mesh",
            ));
        }
        for (polygon, corners) in self.polygons.iter().enumerate() {
            if let Some(&corner) = corners.iter().find(|&&c| c as usize >= self.positions.len()) {
                return Err(Error::data(
                    format!(
                        "polygon {polygon} refers to vertex {corner}, but there are {} (from 0)",
                        self.positions.len()
                    ),
                    "export the mesh again; the file is damaged or cut short",
                ));
            }
        }
        Ok(())
    }

    /// For each vertex whether a face uses it, i.e. a polygon of three corners or more, #V.
    ///
    /// # Panics
    ///
    /// If a corner does not exist; see [`validate`](Self::validate).
    pub fn used_vertices(&self) -> Vec<bool> {
        used_by_faces(self.positions.len(), self.polygons.iter())
    }

    /// Smallest and largest corner of the box around the faces when the vertices are at `positions` (#V × 3).
    ///
    /// Vertices that no face uses do not count. A mesh without faces has the box around all vertices.
    pub fn bounding_box_of(&self, positions: &[Point3<f64>]) -> (Point3<f64>, Point3<f64>) {
        let used = self.used_vertices();
        let of_faces: Vec<_> = positions.iter().zip(&used).filter(|(_, used)| **used).map(|(p, _)| *p).collect();
        bounding_box(if of_faces.is_empty() { positions } else { &of_faces })
    }

    /// Length of the diagonal of [`bounding_box_of`](Self::bounding_box_of) `positions`; 0 for no vertices.
    pub fn diagonal_of(&self, positions: &[Point3<f64>]) -> f64 {
        let (low, high) = self.bounding_box_of(positions);
        (high - low).norm()
    }

    /// Length of the diagonal of the box around the faces; 0 for no vertices.
    pub fn diagonal(&self) -> f64 {
        self.diagonal_of(&self.positions)
    }
}

/// Data that a reader keeps so that the writer of the same format can give the file back, e.g. the lines of an OBJ.
///
/// Other writers ignore it.
#[derive(Clone, Default)]
pub struct Document(Option<Arc<dyn Any + Send + Sync>>);

impl Document {
    /// Keeps `contents`.
    pub fn new<T: Any + Send + Sync>(contents: T) -> Self {
        Self(Some(Arc::new(contents)))
    }

    /// The contents, if they are a `T`.
    pub fn get<T: Any + Send + Sync>(&self) -> Option<&T> {
        self.0.as_ref()?.downcast_ref()
    }
}

impl fmt::Debug for Document {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.0.is_some() { "Document(..)" } else { "Document(none)" })
    }
}
