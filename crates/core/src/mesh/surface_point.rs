use nalgebra::Point3;
use serde::{Deserialize, Serialize};

use super::Surface;

/// A point of a [`Surface`]: a vertex, or a place on a triangle. Files count as [`MeshPoint`](super::MeshPoint) does.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum SurfacePoint {
    /// A vertex of the surface.
    Vertex(u32),
    /// A place on a triangle: the triangle, and barycentric coordinates of its corners, which sum to 1.
    Triangle(u32, [f64; 3]),
}

impl SurfacePoint {
    /// Its vertices with their barycentric coordinates; a vertex is given once with coordinate 1.
    pub fn corners(&self, surface: &Surface) -> Vec<(u32, f64)> {
        match *self {
            Self::Vertex(vertex) => vec![(vertex, 1.0)],
            Self::Triangle(triangle, barycentric) => {
                surface.triangles[triangle as usize].into_iter().zip(barycentric).collect()
            }
        }
    }

    /// Where it lies when the vertices of `surface` are at `positions` (#V).
    pub fn position(&self, surface: &Surface, positions: &[Point3<f64>]) -> Point3<f64> {
        match *self {
            Self::Vertex(vertex) => positions[vertex as usize],
            Self::Triangle(triangle, barycentric) => {
                let corners = surface.triangles[triangle as usize];
                let sum = corners.iter().zip(barycentric).map(|(&v, b)| positions[v as usize].coords * b);
                Point3::from(sum.sum::<nalgebra::Vector3<f64>>())
            }
        }
    }
}
