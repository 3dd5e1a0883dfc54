//! E1: the deformation gradients of triangles that correspond.

use mimesh_core::{mesh::Surface, operators::Gradient};
use nalgebra::{Matrix3, Point3, Vector3};

/// Where a field has the edges of a triangle.
pub type EdgeGoals = [Vector3<f64>; 2];

/// Σ w_t ‖(F̂_t − F_t) P_t‖² over triangles that correspond.
#[derive(Debug)]
pub struct GradientTerm {
    triangles: Vec<Triangle>,
}

/// A triangle, in terms of its edges e₁ and e₂ from its first corner.
#[derive(Debug)]
struct Triangle {
    number: u32,
    corners: [u32; 3],
    /// e₁ and e₂ at rest.
    edges: [Vector3<f64>; 2],
    /// w ‖F P‖² is the sum of (a ẽ₁ + b ẽ₂)² and (c ẽ₂)² over the coordinates; a, b and c.
    norm: [f64; 3],
}

impl Triangle {
    fn new(target: &Surface, t: usize, gradient: &Gradient, weight: f64) -> Self {
        let points = target.corners(&target.positions, t);
        let edges = [points[1] - points[0], points[2] - points[0]];
        let [first, second] = [gradient.of_corners.column(1), gradient.of_corners.column(2)];
        let root = weight.sqrt();
        // The gradient g₁ is at right angles to e₂, along which g₂ is 1 / ‖e₂‖.
        let norm = [root * first.norm(), root * first.dot(&second) / first.norm(), root / edges[1].norm()];
        Self { number: t as u32, corners: target.triangles[t], edges, norm }
    }
}

impl GradientTerm {
    /// The term of the triangles of `target` for which `gradient` gives a gradient and a weight.
    pub fn new(target: &Surface, gradient: impl Fn(usize) -> Option<(Gradient, f64)>) -> Self {
        let triangle = |t: usize| gradient(t).map(|(gradient, weight)| Triangle::new(target, t, &gradient, weight));
        Self { triangles: (0..target.triangle_count()).filter_map(triangle).collect() }
    }

    /// Where the gradients `field` (#F) have the edges of the triangles of the term.
    pub fn goals(&self, field: &[Matrix3<f64>]) -> Vec<EdgeGoals> {
        self.triangles
            .iter()
            .map(|triangle| triangle.edges.map(|edge| field[triangle.number as usize] * edge))
            .collect()
    }

    /// The energy at `positions`, for the `goals` of a field.
    pub fn energy(&self, positions: &[Point3<f64>], goals: &[EdgeGoals]) -> f64 {
        let energy = |(triangle, goals): (&Triangle, &EdgeGoals)| {
            let [i, j, k] = triangle.corners.map(|v| positions[v as usize]);
            let (first, second) = (goals[0] - (j - i), goals[1] - (k - i));
            let [a, b, c] = triangle.norm;
            (first * a + second * b).norm_squared() + (second * c).norm_squared()
        };
        self.triangles.iter().zip(goals).map(energy).sum()
    }
}

#[cfg(test)]
mod tests {
    use mimesh_core::testkit::{meshes, random::Random};

    use super::*;

    #[test]
    fn the_energy_is_that_of_gradients() {
        let sphere = meshes::icosphere(2);
        let mut random = Random::new(3);
        let posed: Vec<_> = sphere.positions.iter().map(|p| p + random.vector() * 0.1).collect();
        let field: Vec<_> = (0..sphere.triangle_count()).map(|_| random.matrix()).collect();
        let gradient = |t: usize| Gradient::new(&sphere.corners(&sphere.positions, t)).map(|g| (g, 1.0 + t as f64));
        let term = GradientTerm::new(&sphere, |t| gradient(t).filter(|_| t % 5 > 0));
        let expected: f64 = (0..sphere.triangle_count())
            .filter(|t| t % 5 > 0)
            .map(|t| {
                let (gradient, weight) = gradient(t).unwrap();
                let projection = gradient.of_posed(&sphere.corners(&sphere.positions, t));
                weight * (field[t] * projection - gradient.of_posed(&sphere.corners(&posed, t))).norm_squared()
            })
            .sum();
        let energy = term.energy(&posed, &term.goals(&field));
        // Rounding of a sum of some hundred terms.
        assert!((energy / expected - 1.0).abs() < 1e-12, "{energy} and {expected}");
    }
}
