//! The two meshes that markers lie on, as far as markers need them.

use std::fmt;

use nalgebra::{Point3, Vector3};

use mimesh_core::mesh::{Mesh, MeshPoint, Surface};

/// Positions nearer to each other than this, relative to the diagonal, are one place: files keep six digits or so.
pub const POSITION_TOLERANCE: f64 = 1e-5;

/// One of the two meshes of a transfer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshRole {
    /// The mesh that gives its motion.
    Source,
    /// The mesh that takes it.
    Target,
}

impl MeshRole {
    /// Source and target, in this order wherever both occur.
    pub const BOTH: [Self; 2] = [Self::Source, Self::Target];

    /// `source` or `target`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Source => "source",
            Self::Target => "target",
        }
    }

    /// 0 for the source, 1 for the target.
    pub fn index(self) -> usize {
        self as usize
    }
}

impl fmt::Display for MeshRole {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// One of the two meshes with its surface.
#[derive(Clone, Copy, Debug)]
pub struct MarkerMesh<'a> {
    /// Which of the two it is.
    pub role: MeshRole,
    /// The mesh whose vertices files of markers count.
    pub mesh: &'a Mesh,
    /// Its surface.
    pub surface: &'a Surface,
}

impl MarkerMesh<'_> {
    /// The length of the diagonal of the bounding box, to which distances are relative; never 0.
    pub fn diagonal(self) -> f64 {
        self.surface.diagonal().max(f64::MIN_POSITIVE)
    }

    /// The position of `point`; `None` if the mesh has no such vertex or triangle.
    pub fn position(self, point: MeshPoint) -> Option<Point3<f64>> {
        match point {
            MeshPoint::Vertex(vertex) => self.mesh.positions.get(vertex as usize).copied(),
            MeshPoint::Triangle(..) => Some(self.surface.point(point)?.position(self.surface, &self.surface.positions)),
        }
    }

    /// The vertex nearest to `point` among the corners of its triangle, and its distance relative to the diagonal; `None` if
    /// the mesh has no such vertex or triangle.
    pub fn nearest_vertex(self, point: MeshPoint) -> Option<(u32, f64)> {
        let position = self.position(point)?;
        let triangle = match point {
            MeshPoint::Vertex(vertex) => return Some((vertex, 0.0)),
            MeshPoint::Triangle(triangle, _) => triangle,
        };
        let (surface, diagonal) = (self.surface, self.diagonal());
        let corners = surface.triangles[triangle as usize].map(|corner| {
            let distance = (surface.positions[corner as usize] - position).norm() / diagonal;
            (surface.representative[corner as usize], distance)
        });
        corners.into_iter().min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// The normal at `point`, of any length: at a vertex the sum over the triangles around it. Zero if the mesh has no such
    /// vertex or triangle.
    pub fn normal(self, point: MeshPoint) -> Vector3<f64> {
        let surface = self.surface;
        match point {
            MeshPoint::Triangle(triangle, _) if (triangle as usize) < surface.triangle_count() => {
                self.triangle_normal(triangle as usize)
            }
            MeshPoint::Triangle(..) => Vector3::zeros(),
            MeshPoint::Vertex(vertex) => {
                let Some(Some(vertex)) = surface.vertex_of.get(vertex as usize) else { return Vector3::zeros() };
                let around = (0..surface.triangle_count()).filter(|t| surface.triangles[*t].contains(vertex));
                around.map(|triangle| self.triangle_normal(triangle)).sum()
            }
        }
    }

    fn triangle_normal(self, triangle: usize) -> Vector3<f64> {
        let [a, b, c] = self.surface.corners(&self.surface.positions, triangle);
        (b - a).cross(&(c - a))
    }
}
