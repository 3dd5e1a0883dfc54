//! From positions in space to points of a mesh.

use nalgebra::Point3;

use mimesh_core::{mesh::MeshPoint, spatial::ClosestPoint};
use mimesh_document::Result;

use crate::{
    diagnose::IntoDiagnostic,
    mesh::{MarkerMesh, POSITION_TOLERANCE},
};

/// Points farther off the surface than this, relative to the diagonal, are refused.
pub const MAX_DISTANCE: f64 = 0.05;

/// The point of a mesh for a position in space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Attached {
    /// The vertex, or the place on a triangle.
    pub point: MeshPoint,
    /// The distance of the position from the surface, relative to the diagonal of the mesh.
    pub distance: f64,
}

impl Attached {
    /// A point that lies on the surface by definition.
    pub fn on_surface(point: MeshPoint) -> Self {
        Self { point, distance: 0.0 }
    }
}

/// A search for points of one mesh.
pub struct Attacher<'a> {
    /// The mesh.
    pub mesh: MarkerMesh<'a>,
    /// The diagonal of its bounding box, never 0.
    pub diagonal: f64,
    closest: ClosestPoint,
}

impl<'a> Attacher<'a> {
    /// Prepares to search `mesh`.
    ///
    /// # Errors
    ///
    /// If it has no triangle.
    pub fn new(mesh: MarkerMesh<'a>) -> Result<Self> {
        let closest = ClosestPoint::new(&mesh.surface.positions, &mesh.surface.triangles)
            .map_err(IntoDiagnostic::into_diagnostic)?;
        Ok(Self { mesh, diagonal: mesh.diagonal(), closest })
    }

    /// The point of the mesh that is nearest to `position`; a vertex where it lies on one.
    pub fn attach(&self, position: &Point3<f64>) -> Attached {
        let surface = self.mesh.surface;
        let Some(found) = self.closest.find(position, f64::INFINITY, |_| true) else {
            // Not reached by finite positions, since a surface has triangles.
            return Attached { point: MeshPoint::Vertex(0), distance: f64::INFINITY };
        };
        let corners = surface.triangles[found.triangle as usize]
            .map(|corner| (corner, (surface.positions[corner as usize] - found.point).norm()));
        let nearest = corners.into_iter().min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or(corners[0]);
        let point = if nearest.1 <= POSITION_TOLERANCE * self.diagonal {
            MeshPoint::Vertex(surface.representative[nearest.0 as usize])
        } else {
            MeshPoint::Triangle(found.triangle, found.barycentric)
        };
        Attached { point, distance: found.distance / self.diagonal }
    }

    /// The point of the mesh nearest to the mean of `vertices`: one of them. All of them exist.
    pub fn nearest_to_mean(&self, vertices: &[u32]) -> Attached {
        let positions = &self.mesh.mesh.positions;
        let sum: nalgebra::Vector3<f64> = vertices.iter().map(|&v| positions[v as usize].coords).sum();
        let mean = Point3::from(sum / vertices.len() as f64);
        let distances = vertices.iter().map(|&v| (v, (positions[v as usize] - mean).norm()));
        let nearest = distances.min_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
        Attached::on_surface(MeshPoint::Vertex(nearest.map_or(0, |(vertex, _)| vertex)))
    }

    /// `point`, which exists, as a place on a triangle: a vertex is a corner of the first triangle around it.
    pub fn place_on_triangle(&self, point: MeshPoint) -> (u32, [f64; 3]) {
        let surface = self.mesh.surface;
        let vertex = match point {
            MeshPoint::Triangle(triangle, barycentric) => return (triangle, barycentric),
            MeshPoint::Vertex(vertex) => vertex as usize,
        };
        let on_surface = surface.vertex_of[vertex];
        let around = |corners: &[u32; 3]| on_surface.is_some_and(|v| corners.contains(&v));
        match surface.triangles.iter().position(around) {
            Some(t) => (t as u32, surface.triangles[t].map(|corner| f64::from(u8::from(Some(corner) == on_surface)))),
            None => {
                // A vertex that no face uses: the nearest place on one.
                let found = self.closest.find(&self.mesh.mesh.positions[vertex], f64::INFINITY, |_| true);
                found.map_or((0, [1.0, 0.0, 0.0]), |found| (found.triangle, found.barycentric))
            }
        }
    }
}

/// Whether a distance, relative to the diagonal, is too large for a point of the mesh; one that is no number is.
pub fn is_too_far(distance: f64) -> bool {
    distance.is_nan() || distance > MAX_DISTANCE
}
