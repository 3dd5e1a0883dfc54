use nalgebra::{Matrix3, Point3};

use crate::linalg::OuterSum;

/// A tetrahedron over four unknown points with a constant deformation gradient F = Σ xᵢ gᵢᵀ.
///
/// It serves energies that compare deformation gradients of triangles in different planes, which the 3 × 2 edge form cannot: a
/// triangle becomes a tetrahedron by a fourth vertex, which is an unknown of its own (Sumner and Popović 2004).
#[derive(Clone, Debug)]
pub struct Tetrahedron {
    /// Its points, as unknowns of a system.
    pub unknowns: [u32; 4],
    /// The vectors gᵢ, per unit of length; they sum to 0.
    pub gradient: [[f64; 3]; 4],
}

impl Tetrahedron {
    /// The tetrahedron whose edges from its first point are the columns of `frame`; it must not be flat.
    pub fn new(unknowns: [u32; 4], frame: &Matrix3<f64>) -> Self {
        let inverse = frame.try_inverse().unwrap_or_default();
        let row = |k: usize| [inverse[(k, 0)], inverse[(k, 1)], inverse[(k, 2)]];
        let first = std::array::from_fn(|j| -(0..3).map(|k| inverse[(k, j)]).sum::<f64>());
        Self { unknowns, gradient: [first, row(0), row(1), row(2)] }
    }

    /// The tetrahedron over a triangle with an area, whose point `fourth` stands on the first corner along the normal, at the
    /// square root of twice the area.
    pub fn over([i, j, k]: [u32; 3], fourth: u32, [a, b, c]: &[Point3<f64>; 3]) -> Self {
        let normal = (b - a).cross(&(c - a));
        Self::new([i, j, k, fourth], &Matrix3::from_columns(&[b - a, c - a, normal / normal.norm().sqrt()]))
    }

    /// F when coordinate c of unknown i is `at(i, c)`.
    pub fn deformation_gradient(&self, at: impl Fn(u32, usize) -> f64) -> Matrix3<f64> {
        Matrix3::from_fn(|c, j| (0..4).map(|k| at(self.unknowns[k], c) * self.gradient[k][j]).sum::<f64>())
    }

    /// Adds weight ‖F − target‖² to the quadratic energy xᵀ A x − 2 bᵀ x of n unknowns; `rhs` is b, n × 3 by columns.
    pub fn add_target(&self, target: &Matrix3<f64>, weight: f64, assembly: &mut impl OuterSum, rhs: &mut [f64]) {
        assembly.add_outer(&self.unknowns, &self.gradient, weight);
        self.add_target_rhs(target, weight, rhs);
    }

    /// The part of [`add_target`](Self::add_target) that depends on the target.
    pub fn add_target_rhs(&self, target: &Matrix3<f64>, weight: f64, rhs: &mut [f64]) {
        let n = rhs.len() / 3;
        for (&i, g) in self.unknowns.iter().zip(&self.gradient) {
            for c in 0..3 {
                rhs[c * n + i as usize] += weight * (0..3).map(|j| target[(c, j)] * g[j]).sum::<f64>();
            }
        }
    }

    /// Adds weight ‖F − F_other‖² to a quadratic energy.
    pub fn add_smoothness(&self, other: &Self, weight: f64, assembly: &mut impl OuterSum) {
        let indices: [u32; 8] = std::array::from_fn(|k| if k < 4 { self.unknowns[k] } else { other.unknowns[k - 4] });
        let rows: [[f64; 3]; 8] =
            std::array::from_fn(|k| if k < 4 { self.gradient[k] } else { other.gradient[k - 4].map(|x| -x) });
        assembly.add_outer(&indices, &rows, weight);
    }
}
