//! Motions of the vertices between shores that move against each other.

use std::collections::BTreeMap;

use mimesh_core::{
    mesh::Surface,
    operators::{DeformationGradients, Gradient, gradients},
};
use nalgebra::{Cholesky, DMatrix, DVector, Matrix3, Point3, UnitQuaternion, Vector3};

/// Regions between more shores keep rotations alone; their small dense system would cost too much.
const MAX_SHORES: usize = 32;

/// The rigid motions of the shores of one region of orphans, blended over its vertices.
///
/// Rotations that differ from place to place are no gradients of anything: what turns also shears, by the way of each point. So
/// vertices go to x̃ᵥ = exp(wᵥ) xᵥ + V(wᵥ) uᵥ, the screw with rotation vector wᵥ = Σ φₛ(v) wₛ and translation part uᵥ = Σ φₛ(v) uₛ.
/// φₛ is the share of shore s, V(w) the integral of exp(τ w) over τ from 0 to 1, and the uₛ leave the least of Σ A ‖∇x̃ − R‖² over
/// triangles. Between two ends that turn against each other about one axis that is the twist, or the arc, about that axis.
#[derive(Debug)]
pub struct ShoreMotion {
    /// The shores, by their numbers in the extension.
    shores: Vec<u32>,
    /// Rest positions of the vertices, from their mean.
    rest: Vec<Vector3<f64>>,
    /// φ, a row a vertex and a column a shore.
    shares: DMatrix<f64>,
    /// The orphans of the region, by their places in the extension.
    places: Vec<usize>,
    /// The corners of the orphans, as vertices of the region.
    triangles: Vec<[u32; 3]>,
    /// Of each orphan; `None` for one without area.
    operators: Vec<Option<Gradient>>,
    deformation: DeformationGradients,
}

/// The blended motion on an orphan.
#[derive(Clone, Copy, Debug)]
pub struct BlendedMotion {
    /// The place of the orphan in the extension.
    pub place: usize,
    /// ∇x̃.
    pub gradient: Matrix3<f64>,
    /// Rᵀ ∇x̃ − I: what it has beside its rotation.
    pub shear: Matrix3<f64>,
}

impl ShoreMotion {
    /// Prepares a region of `target`: its orphans with their places, the share of each of `shores` in each orphan, and the shore that
    /// a vertex lies on, if any. `None` if there are no two shores, or too many.
    pub fn new(
        target: &Surface,
        orphans: &[(usize, u32)],
        shores: Vec<u32>,
        share: impl Fn(usize, usize) -> f64,
        shore_of: impl Fn(u32) -> Option<u32>,
    ) -> Option<Self> {
        let count = shores.len();
        if !(2..=MAX_SHORES).contains(&count) {
            return None;
        }
        let mut around: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        for &(place, t) in orphans {
            target.triangles[t as usize].iter().for_each(|&v| around.entry(v).or_default().push(place));
        }
        let number: BTreeMap<u32, u32> = around.keys().zip(0..).map(|(&v, k)| (v, k)).collect();
        let mut shares = DMatrix::zeros(number.len(), count);
        for (&v, places) in &around {
            let row = number[&v] as usize;
            match shore_of(v).and_then(|shore| shores.iter().position(|&other| other == shore)) {
                Some(column) => shares[(row, column)] = 1.0,
                None => (0..count).for_each(|column| {
                    let sum: f64 = places.iter().map(|&place| share(place, column)).sum();
                    shares[(row, column)] = sum / places.len() as f64;
                }),
            }
        }
        let positions = || number.keys().map(|&v| target.positions[v as usize].coords);
        let mean = positions().sum::<Vector3<f64>>() / number.len() as f64;
        let rest: Vec<_> = positions().map(|p| p - mean).collect();
        let places = orphans.iter().map(|(place, _)| *place).collect();
        let triangles: Vec<_> =
            orphans.iter().map(|(_, t)| target.triangles[*t as usize].map(|v| number[&v])).collect();
        let points: Vec<_> = rest.iter().map(|p| Point3::from(*p)).collect();
        let operators = gradients(&points, &triangles);
        let deformation = DeformationGradients::new(&points, &triangles);
        Some(Self { shores, rest, shares, places, triangles, operators, deformation })
    }

    /// The place of one of its orphans.
    pub fn first_place(&self) -> usize {
        self.places[0]
    }

    /// The blended motion on each orphan, where the region has turned by `middle` and each shore by the rotation with
    /// the logarithm `logarithm` from there.
    pub fn at(&self, middle: &UnitQuaternion<f64>, logarithm: impl Fn(u32) -> Vector3<f64>) -> Vec<BlendedMotion> {
        let logarithms: Vec<Vector3<f64>> = self.shores.iter().map(|&shore| logarithm(shore)).collect();
        let blend = |v: usize, of: &[Vector3<f64>]| {
            of.iter().enumerate().map(|(s, value)| value * self.shares[(v, s)]).sum::<Vector3<f64>>()
        };
        let turns: Vec<Vector3<f64>> = (0..self.rest.len()).map(|v| blend(v, &logarithms)).collect();
        let turned: Vec<Point3<f64>> = self
            .rest
            .iter()
            .zip(&turns)
            .map(|(p, &turn)| UnitQuaternion::from_scaled_axis(turn) * Point3::from(*p))
            .collect();
        let ways: Vec<Matrix3<f64>> = turns.iter().map(way_of_turning).collect();
        let rotation_of = |corners: &[u32; 3]| {
            let turn = corners.iter().map(|&v| turns[v as usize]).sum::<Vector3<f64>>() / 3.0;
            UnitQuaternion::from_scaled_axis(turn).to_rotation_matrix().into_inner()
        };
        let translations = self.translations(&turned, &ways, rotation_of);
        let middle = middle.to_rotation_matrix();
        let moved: Vec<Point3<f64>> =
            (0..self.rest.len()).map(|v| middle * (turned[v] + ways[v] * blend(v, &translations))).collect();
        let rotation_of = |corners: &[u32; 3]| middle.matrix() * rotation_of(corners);
        let motion = |(k, &place): (usize, &usize)| {
            let gradient = self.deformation.of_triangle(k, &moved);
            let shear = rotation_of(&self.triangles[k]).transpose() * gradient - Matrix3::identity();
            BlendedMotion { place, gradient, shear }
        };
        self.places.iter().enumerate().map(motion).collect()
    }

    /// uₛ of each shore, where vertices have been turned to `turned`, V(w) of each is `ways` and R of each triangle `rotation_of`.
    fn translations(
        &self,
        turned: &[Point3<f64>],
        ways: &[Matrix3<f64>],
        rotation_of: impl Fn(&[u32; 3]) -> Matrix3<f64>,
    ) -> Vec<Vector3<f64>> {
        let count = self.shores.len();
        let mut matrix = DMatrix::zeros(3 * count, 3 * count);
        let mut rhs = DVector::zeros(3 * count);
        for (t, gradient) in self.triangles.iter().zip(&self.operators) {
            let Some(gradient) = gradient else { continue };
            let corners = t.map(|v| v as usize);
            let off = gradient.of_posed(&corners.map(|v| turned[v])) - rotation_of(t);
            // The gradient of what a translation part of each shore moves, a block of three rows a corner.
            for (i, &v) in corners.iter().enumerate() {
                let slope = gradient.of_corners.column(i);
                let pulled = ways[v].transpose() * (off * slope) * gradient.area;
                for r in 0..count {
                    let mut part = rhs.fixed_rows_mut::<3>(3 * r);
                    part -= pulled * self.shares[(v, r)];
                }
                for (j, &w) in corners.iter().enumerate() {
                    let both = gradient.area * slope.dot(&gradient.of_corners.column(j));
                    let block = ways[v].transpose() * ways[w] * both;
                    for r in 0..count {
                        for s in 0..count {
                            let mut part = matrix.fixed_view_mut::<3, 3>(3 * r, 3 * s);
                            part += block * (self.shares[(v, r)] * self.shares[(w, s)]);
                        }
                    }
                }
            }
        }
        // Where nothing turns, all may move as one.
        let size = matrix.trace() / (3 * count) as f64;
        (0..3 * count).for_each(|k| matrix[(k, k)] += 1e-9 * size);
        match Cholesky::new(matrix) {
            Some(system) => {
                let solved = system.solve(&rhs);
                (0..count).map(|s| solved.fixed_rows::<3>(3 * s).into_owned()).collect()
            }
            None => vec![Vector3::zeros(); count],
        }
    }
}

/// V(w) = I + (1 − cos θ) / θ² [w] + (θ − sin θ) / θ³ [w]², θ = ‖w‖: the integral of exp(τ w) over τ from 0 to 1.
fn way_of_turning(w: &Vector3<f64>) -> Matrix3<f64> {
    let angle = w.norm();
    let cross = w.cross_matrix();
    let (first, second) = match angle < 1e-4 {
        // Their series; what is left out is below rounding.
        true => (0.5 - angle * angle / 24.0, 1.0 / 6.0 - angle * angle / 120.0),
        false => ((1.0 - angle.cos()) / angle.powi(2), (angle - angle.sin()) / angle.powi(3)),
    };
    Matrix3::identity() + cross * first + cross * cross * second
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_way_of_turning_is_the_integral_of_the_turn() {
        for w in [Vector3::new(0.3, -0.2, 0.9), Vector3::new(0.0, 4.0, 1.0), Vector3::new(1e-5, 0.0, 2e-5)] {
            let steps = 2000;
            let at = |k: usize| UnitQuaternion::from_scaled_axis(w * ((k as f64 + 0.5) / steps as f64));
            let sum: Matrix3<f64> = (0..steps).map(|k| at(k).to_rotation_matrix().into_inner()).sum();
            // The midpoint rule is off by ‖w‖² / 24 steps² at most.
            assert!((sum / steps as f64 - way_of_turning(&w)).norm() < 1e-6, "{w}");
        }
    }
}
