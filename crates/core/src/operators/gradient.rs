use nalgebra::{Matrix3, Point3, Vector3};

use super::degenerate::is_degenerate;

/// The gradient of piecewise linear functions on one triangle: ∇u = Σᵢ uᵢ gᵢ, in the plane of the triangle.
#[derive(Clone, Copy, Debug)]
pub struct Gradient {
    /// The vectors gᵢ as columns, one a corner; they sum to 0 and have the unit 1 / length.
    pub of_corners: Matrix3<f64>,
    /// Area of the triangle.
    pub area: f64,
}

impl Gradient {
    /// The gradient on a triangle, or `None` if it [is degenerate](is_degenerate).
    pub fn new(corners: &[Point3<f64>; 3]) -> Option<Self> {
        if is_degenerate(corners) {
            return None;
        }
        let [a, b, c] = corners;
        let normal = (b - a).cross(&(c - a));
        let double_area = normal.norm();
        // gᵢ is the opposite edge turned into the triangle, over twice the area.
        let along = normal / (double_area * double_area);
        let of_corners = Matrix3::from_columns(&[along.cross(&(c - b)), along.cross(&(a - c)), along.cross(&(b - a))]);
        Some(Self { of_corners, area: double_area / 2.0 })
    }

    /// F P = Σᵢ x̃ᵢ gᵢᵀ: the deformation gradient of posed corners restricted to the plane of the triangle
    /// (the 3 × 2 edge form; P projects onto the plane).
    ///
    /// Botsch et al. 2006, "Deformation transfer for detail-preserving surface editing", show that the fourth vertex of
    /// Sumner and Popović 2004 drops out this way.
    pub fn of_posed(&self, posed: &[Point3<f64>; 3]) -> Matrix3<f64> {
        let g = &self.of_corners;
        // The gᵢ sum to 0: subtracting the first corner changes nothing but rounding far from the origin.
        (posed[1] - posed[0]) * g.column(1).transpose() + (posed[2] - posed[0]) * g.column(2).transpose()
    }

    /// ∇u of corner values `u`.
    pub fn of_values(&self, u: [f64; 3]) -> Vector3<f64> {
        self.of_corners * Vector3::from(u)
    }
}

/// The gradient on every triangle; `None` for degenerate ones.
pub fn gradients(positions: &[Point3<f64>], triangles: &[[u32; 3]]) -> Vec<Option<Gradient>> {
    triangles.iter().map(|t| Gradient::new(&t.map(|v| positions[v as usize]))).collect()
}
