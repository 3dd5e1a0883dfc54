use serde::{Deserialize, Serialize};

use super::{Surface, SurfacePoint};

/// A point of a [`Mesh`](super::Mesh) as its file counts: a vertex, or a place on a triangle.
///
/// Triangles count the fan triangles of all polygons in order, so they have the same numbers in the mesh and in its
/// [`Surface`]. Vertices have other numbers there, since seams are welded.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum MeshPoint {
    /// A vertex of the file.
    Vertex(u32),
    /// A place on a triangle: the triangle, and barycentric coordinates of its corners, which sum to 1.
    Triangle(u32, [f64; 3]),
}

impl Surface {
    /// The point of the surface for a point of its mesh; `None` if the mesh has no such vertex or triangle, or no face uses the
    /// vertex.
    pub fn point(&self, point: MeshPoint) -> Option<SurfacePoint> {
        match point {
            MeshPoint::Vertex(vertex) => {
                self.vertex_of.get(vertex as usize).copied().flatten().map(SurfacePoint::Vertex)
            }
            MeshPoint::Triangle(triangle, barycentric) => {
                ((triangle as usize) < self.triangle_count()).then_some(SurfacePoint::Triangle(triangle, barycentric))
            }
        }
    }

    /// The point of the mesh for a point of the surface; a welded vertex is the first of its copies.
    ///
    /// # Panics
    ///
    /// If the surface has no such vertex.
    pub fn mesh_point(&self, point: SurfacePoint) -> MeshPoint {
        match point {
            SurfacePoint::Vertex(vertex) => MeshPoint::Vertex(self.representative[vertex as usize]),
            SurfacePoint::Triangle(triangle, barycentric) => MeshPoint::Triangle(triangle, barycentric),
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use super::*;
    use crate::mesh::Mesh;

    #[test]
    fn points_of_the_mesh_and_of_its_welded_surface_correspond() {
        let p = |x: f64, y: f64| Point3::new(x, y, 0.0);
        let mesh = Mesh::from_triangles(
            vec![p(0., 0.), p(1., 0.), p(0., 1.), p(0., 1.), p(1., 0.), p(1., 1.)],
            &[[0, 1, 2], [3, 4, 5]],
        );
        let surface = Surface::new(&mesh).unwrap();
        let inside = [0.2, 0.3, 0.5];
        assert_eq!(surface.point(MeshPoint::Vertex(5)), Some(SurfacePoint::Vertex(3)));
        assert_eq!(surface.point(MeshPoint::Vertex(6)), None);
        assert_eq!(surface.point(MeshPoint::Triangle(1, inside)), Some(SurfacePoint::Triangle(1, inside)));
        assert_eq!(surface.point(MeshPoint::Triangle(2, inside)), None);
        // Vertices 3 and 4 are copies of 2 and 1.
        let first_copies = [0, 1, 2, 2, 1, 5].map(MeshPoint::Vertex);
        for (vertex, first) in (0..).zip(first_copies) {
            assert_eq!(surface.mesh_point(surface.point(MeshPoint::Vertex(vertex)).unwrap()), first);
        }
    }
}
