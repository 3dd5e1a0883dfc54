use nalgebra::{Matrix3, Point3, Vector3};

use super::degenerate::is_degenerate;

/// Deformation gradients F, 3 × 3 a triangle, of poses relative to one rest surface.
///
/// F maps the two edges to the posed edges, and the normal scaled by the square root of the area to the posed one
/// (Sumner and Popović 2004; eq. 1 of Zhou et al. 2010), so that the stretch along the normal is the geometric mean of
/// those in the plane.
#[derive(Clone, Debug)]
pub struct DeformationGradients {
    triangles: Vec<[u32; 3]>,
    /// G⁻¹ of each triangle at rest; `None` if it is degenerate.
    inverse: Vec<Option<Matrix3<f64>>>,
}

impl DeformationGradients {
    /// Prepares for poses of the surface with rest positions `rest`.
    pub fn new(rest: &[Point3<f64>], triangles: &[[u32; 3]]) -> Self {
        let inverse = triangles
            .iter()
            .map(|t| {
                let corners = t.map(|v| rest[v as usize]);
                if is_degenerate(&corners) { None } else { frame(&corners).try_inverse() }
            })
            .collect();
        Self { triangles: triangles.to_vec(), inverse }
    }

    /// Whether triangle `triangle` has a deformation gradient, i.e. an area at rest.
    pub fn is_defined(&self, triangle: usize) -> bool {
        self.inverse[triangle].is_some()
    }

    /// F of triangle `triangle` when the vertices are at `posed`; the identity if the triangle has no area at rest.
    pub fn of_triangle(&self, triangle: usize, posed: &[Point3<f64>]) -> Matrix3<f64> {
        let corners = self.triangles[triangle].map(|v| posed[v as usize]);
        self.inverse[triangle].map_or_else(Matrix3::identity, |inverse| frame(&corners) * inverse)
    }

    /// F of every triangle when the vertices are at `posed`, #F.
    pub fn of(&self, posed: &[Point3<f64>]) -> Vec<Matrix3<f64>> {
        (0..self.triangles.len()).map(|t| self.of_triangle(t, posed)).collect()
    }
}

/// G = [v₂ − v₁, v₃ − v₁, n / √|n|] with n = (v₂ − v₁) × (v₃ − v₁).
fn frame(&[a, b, c]: &[Point3<f64>; 3]) -> Matrix3<f64> {
    let normal = (b - a).cross(&(c - a));
    let length = normal.norm();
    let fourth = if length > 0.0 { normal / length.sqrt() } else { Vector3::zeros() };
    Matrix3::from_columns(&[b - a, c - a, fourth])
}
