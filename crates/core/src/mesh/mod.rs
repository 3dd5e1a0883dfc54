//! Meshes: what a file gives, and what stages compute on.
//!
//! [`Mesh`] keeps the user's file: polygons, vertex order and count, texture coordinates, normals, parts and materials.
//! [`Surface`] is the view that stages solve on: polygons cut into triangles (a fan from the first corner), seams welded.
//! Results on a surface go back to every vertex of the mesh through [`Surface::to_mesh`].

mod attributes;
mod polygons;
mod sequence;
mod statistics;
mod surface;
mod surface_point;
mod topology;
mod weld;

use std::{any::Any, fmt, sync::Arc};

use nalgebra::Point3;

pub use attributes::{CornerAttribute, Material, Part};
pub use polygons::Polygons;
pub use sequence::{Animation, Landmark, MeshSequence, Pose};
pub use statistics::Statistics;
pub use surface::Surface;
pub use surface_point::SurfacePoint;
pub use topology::{Components, Topology};

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
    /// Runs of polygons with one object, group and material name; they cover the polygons in order.
    pub parts: Vec<Part>,
    /// The materials that parts name, as far as they are known.
    pub materials: Vec<Material>,
    /// What else the reader of the file wants its writer to know.
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
                "give a mesh with at least one triangle; point clouds and curves cannot take a deformation",
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

    /// Length of the diagonal of the bounding box; 0 for no vertices.
    pub fn diagonal(&self) -> f64 {
        diagonal(&self.positions)
    }
}

/// Checks that coordinates are finite.
///
/// # Errors
///
/// [`Error::Data`] that names the first vertex that is not, counted from 0.
pub fn check_finite(positions: &[Point3<f64>]) -> Result<()> {
    match positions.iter().position(|p| !p.coords.iter().all(|x| x.is_finite())) {
        None => Ok(()),
        Some(vertex) => {
            let p = positions[vertex];
            Err(Error::data(
                format!("vertex {vertex} (from 0) has coordinates {} {} {}: expected finite numbers", p.x, p.y, p.z),
                "repair the file or export it again without NaN and infinity",
            ))
        }
    }
}

/// Smallest and largest corner of the box around `positions`; both at the origin if there are none.
pub fn bounding_box(positions: &[Point3<f64>]) -> (Point3<f64>, Point3<f64>) {
    let Some(&first) = positions.first() else { return (Point3::origin(), Point3::origin()) };
    positions.iter().fold((first, first), |(low, high), p| (low.inf(p), high.sup(p)))
}

/// Length of the diagonal of the box around `positions`.
pub fn diagonal(positions: &[Point3<f64>]) -> f64 {
    let (low, high) = bounding_box(positions);
    (high - low).norm()
}

/// Whatever a reader keeps of a file so that its own writer can give the file back, e.g. the lines of an OBJ.
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
