//! Positions whose deformation gradients come closest to a given field.

use mimesh_core::{
    Result,
    linalg::{Assembly, FixedUnknowns},
    mesh::Surface,
    operators::{Gradient, gradients},
};
use nalgebra::{Matrix3, Point3};

/// How strongly the edges of triangles without area are held, in units of cotangent weight: enough to tie a vertex that has
/// no other triangle, too little to be felt by one that has.
const DEGENERATE_WEIGHT: f64 = 1e-4;

/// Minimises Σ_t w_t ‖(F̂_t − F_t) P_t‖² over the posed vertices of a connected surface, for any number of fields F̂.
///
/// In the 3 × 2 edge form (Botsch et al. 2006): P_t projects onto the plane of triangle t, and the fourth vertex of Sumner
/// and Popović 2004 drops out. With w_t the area, the matrix is the cotangent Laplacian.
#[derive(Debug)]
pub struct Poisson {
    system: FixedUnknowns,
    triangles: Vec<[u32; 3]>,
    gradients: Vec<Option<Gradient>>,
    /// w_t, #F; 0 for triangles without area.
    weights: Vec<f64>,
    /// What a field multiplies into the right-hand side of each corner: w_t gᵢ as columns.
    pull: Vec<Matrix3<f64>>,
    rest: Vec<Point3<f64>>,
    /// The anchor, and vertices without a triangle.
    fixed: Vec<u32>,
}

impl Poisson {
    /// Factors the system of `target`; `weight` gives w_t from a triangle's area.
    ///
    /// # Errors
    ///
    /// [`Error::Singular`](mimesh_core::Error::Singular) if the target is not connected.
    pub fn new(target: &Surface, weight: impl Fn(f64) -> f64) -> Result<Self> {
        let n = target.vertex_count();
        let mut assembly = Assembly::new(n);
        let gradients = gradients(&target.positions, &target.triangles);
        // Relative to their mean, so that ties have the same effect at any size of mesh.
        let mut weights: Vec<f64> = gradients.iter().map(|g| g.map_or(0.0, |g| weight(g.area))).collect();
        let scale: f64 = gradients.iter().flatten().map(|g| g.area).sum::<f64>() / weights.iter().sum::<f64>();
        weights.iter_mut().for_each(|w| *w *= scale);
        let mut pull = Vec::with_capacity(gradients.len());
        for ((gradient, t), &w) in gradients.iter().zip(&target.triangles).zip(&weights) {
            match gradient {
                Some(Gradient { of_corners: g, .. }) => {
                    let rows: [[f64; 3]; 3] = std::array::from_fn(|i| g.column(i).into_owned().into());
                    assembly.add_outer(t, &rows, w);
                    pull.push(g * w);
                }
                None => pull.push(tie(target, t, &mut assembly)),
            }
        }
        let mut solved = vec![false; n];
        target.triangles.iter().flatten().for_each(|&v| solved[v as usize] = true);
        if let Some(anchor) = target.triangles.first().map(|t| t[0]) {
            solved[anchor as usize] = false;
        }
        let fixed: Vec<u32> = (0..n as u32).filter(|&v| !solved[v as usize]).collect();
        let system = FixedUnknowns::new(&assembly.finish(), &fixed, "the system of the target's deformation gradients")?;
        let (triangles, rest) = (target.triangles.clone(), target.positions.clone());
        Ok(Self { system, triangles, gradients, weights, pull, rest, fixed })
    }

    /// The posed vertices for the field `field` (#F); the first corner of the first triangle stays where it is at rest, and
    /// so do vertices without a triangle.
    pub fn solve(&self, field: &[Matrix3<f64>]) -> Vec<Point3<f64>> {
        let n = self.rest.len();
        let mut rhs = vec![0.0; 3 * n];
        for ((t, pull), f) in self.triangles.iter().zip(&self.pull).zip(field) {
            let b = f * pull;
            for (k, &v) in t.iter().enumerate() {
                (0..3).for_each(|c| rhs[c * n + v as usize] += b[(c, k)]);
            }
        }
        let values: Vec<f64> = (0..3).flat_map(|c| self.fixed.iter().map(move |&v| self.rest[v as usize][c])).collect();
        let x = self.system.solve(&rhs, &values, 3);
        (0..n).map(|i| Point3::new(x[i], x[n + i], x[2 * n + i])).collect()
    }

    /// √(Σ w_t ‖(F̂_t − F_t) P_t‖² / Σ w_t): how far the gradients at `posed` are from the field, without unit.
    pub fn residual(&self, field: &[Matrix3<f64>], posed: &[Point3<f64>]) -> f64 {
        let (mut sum, mut total) = (0.0, 0.0);
        for (((t, gradient), &w), f) in self.triangles.iter().zip(&self.gradients).zip(&self.weights).zip(field) {
            let Some(gradient) = gradient else { continue };
            let at_rest = gradient.of_posed(&t.map(|v| self.rest[v as usize]));
            let now = gradient.of_posed(&t.map(|v| posed[v as usize]));
            // of_posed at rest is the projection P.
            sum += w * (f * at_rest - now).norm_squared();
            total += w;
        }
        (sum / total).sqrt()
    }
}

/// Holds the edges of a triangle without area; returns what a field multiplies into the right-hand side.
fn tie(target: &Surface, t: &[u32; 3], assembly: &mut Assembly) -> Matrix3<f64> {
    let mut pull = Matrix3::zeros();
    for (i, j) in [(0, 1), (1, 2), (2, 0)] {
        if t[i] != t[j] {
            assembly.add_outer(&[t[i], t[j]], &[[1.0], [-1.0]], DEGENERATE_WEIGHT);
            let edge = (target.positions[t[i] as usize] - target.positions[t[j] as usize]) * DEGENERATE_WEIGHT;
            let (a, b) = (pull.column(i) + edge, pull.column(j) - edge);
            pull.set_column(i, &a);
            pull.set_column(j, &b);
        }
    }
    pull
}
