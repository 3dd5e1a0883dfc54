use nalgebra::Point3;
use parry3d_f64::{
    math::Vector,
    partitioning::BvhNode,
    query::{PointQuery as _, PointQueryWithLocation as _},
    shape::{TriMesh, TriMeshBuilderError},
};

use crate::{Error, Result};

/// Finds the closest point of a surface, by a bounding volume hierarchy over its triangles.
pub struct ClosestPoint {
    mesh: TriMesh,
}

/// A point found on a surface.
#[derive(Clone, Copy, Debug)]
pub struct OnSurface {
    /// The triangle.
    pub triangle: u32,
    /// Barycentric coordinates of its corners.
    pub barycentric: [f64; 3],
    /// The point.
    pub point: Point3<f64>,
    /// Its distance to the query.
    pub distance: f64,
}

impl ClosestPoint {
    /// Prepares to search the triangles over `positions`.
    ///
    /// # Errors
    ///
    /// [`Error::Data`] if there is no triangle.
    pub fn new(positions: &[Point3<f64>], triangles: &[[u32; 3]]) -> Result<Self> {
        let vertices = positions.iter().map(|p| Vector::new(p.x, p.y, p.z)).collect();
        match TriMesh::new(vertices, triangles.to_vec()) {
            Ok(mesh) => Ok(Self { mesh }),
            Err(TriMeshBuilderError::EmptyIndices) => {
                Err(Error::data("a surface without triangles has no closest point", "give a mesh with triangles"))
            }
            Err(error) => Err(Error::Other(Box::new(error))),
        }
    }

    /// The closest point of the triangles that `accept` takes, if there is one nearer than `max_distance`.
    pub fn find(&self, query: &Point3<f64>, max_distance: f64, accept: impl Fn(u32) -> bool) -> Option<OnSurface> {
        let query = Vector::new(query.x, query.y, query.z);
        let found = self.mesh.bvh().find_best(
            max_distance,
            |node: &BvhNode, _| node.aabb().distance_to_local_point(query, true),
            |triangle, _| {
                if !accept(triangle) {
                    return None;
                }
                let (projection, location) =
                    self.mesh.triangle(triangle).project_local_point_and_get_location(query, true);
                let barycentric = location.barycentric_coordinates().unwrap_or([1.0, 0.0, 0.0]);
                Some(((projection.point - query).length(), (projection.point, barycentric)))
            },
        );
        found.map(|(triangle, (distance, (point, barycentric)))| OnSurface {
            triangle,
            barycentric,
            point: Point3::new(point.x, point.y, point.z),
            distance,
        })
    }
}
