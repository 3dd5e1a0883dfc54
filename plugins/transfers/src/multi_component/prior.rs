//! E5: the result of another transfer, from which the steps start and to which the target is held.

use mimesh_core::{
    Result,
    operators::{DeformationGradients, voronoi_mass},
    stage::{BindInput, BoundTransfer, Transfer},
};
use nalgebra::{Matrix3, Point3, Vector3};

/// The part of binding that goes to the other transfer.
const PRIOR: f64 = 0.9;

/// E5 = Σ βᵢ ρᵢ(‖x̃ᵢ − bᵢ‖), b being the other transfer's result, βᵢ = w5 Aᵢ / D² with the vertex's area and the diagonal.
///
/// ρ(r) = r² / (1 + r²/σ²) (Geman and McClure 1985), since a result that is far from what gradients and gaps say is no measure
/// of them; ρ(r) = r² on orphan components, of which nothing else is known. With y where the vertex is now, ‖x − g‖² + c with
/// g = y + (b − y) / (1 + ‖b − y‖²/σ²)² lies above ρ(‖x − b‖) and touches it at y: so the matrix stays as it is, and no step
/// raises the energy.
#[derive(Debug)]
pub struct Prior {
    transfer: Box<dyn BoundTransfer>,
    gradients: DeformationGradients,
    /// βᵢ.
    pub weights: Vec<f64>,
    /// 1/σ², and 0 for vertices of orphan components.
    nearness: Vec<f64>,
}

impl Prior {
    /// Binds `transfer`, with w5 = `weight` and σ = `radius` diagonals; `is_orphan` says which vertices belong to components that
    /// correspond to nothing.
    pub fn new(
        transfer: &dyn Transfer,
        input: BindInput<'_>,
        [weight, radius]: [f64; 2],
        is_orphan: impl Fn(u32) -> bool,
    ) -> Result<Self> {
        let target = input.pair.target;
        let span = tracing::debug_span!("initial", "type" = transfer.typetag_name());
        // What binds after it takes little.
        let input = BindInput { work: input.work.part(0.0, PRIOR), ..input };
        let transfer = span.in_scope(|| transfer.bind(input))?;
        let mass = voronoi_mass(&target.positions, &target.triangles);
        let diagonal = target.diagonal();
        let nearness = |v: usize| if is_orphan(v as u32) { 0.0 } else { (radius * diagonal).powi(-2) };
        Ok(Self {
            transfer,
            gradients: DeformationGradients::new(&target.positions, &target.triangles),
            nearness: (0..mass.len()).map(nearness).collect(),
            weights: mass.into_iter().map(|mass| weight * mass / diagonal.powi(2)).collect(),
        })
    }

    /// b when the source is at each of `poses`.
    pub fn positions(&self, poses: &[&[Point3<f64>]]) -> Vec<Result<Vec<Point3<f64>>>> {
        let at_once = poses.chunks(self.transfer.at_once()).flat_map(|poses| self.transfer.transfer_all(poses));
        at_once.map(|transferred| Ok(transferred?.positions)).collect()
    }

    /// Gives orphans the deformation gradients of b.
    pub fn fill(&self, b: &[Point3<f64>], field: &mut [Matrix3<f64>], is_orphan: impl Fn(usize) -> bool) {
        for (t, f) in field.iter_mut().enumerate() {
            if is_orphan(t) && self.gradients.is_defined(t) {
                *f = self.gradients.of_triangle(t, b);
            }
        }
    }

    /// g: where E5 draws vertices that are at `now`.
    pub fn goals(&self, b: &[Point3<f64>], now: &[Point3<f64>]) -> Vec<Point3<f64>> {
        let goal = |((b, now), nearness): ((&Point3<f64>, &Point3<f64>), &f64)| {
            let way: Vector3<f64> = b - now;
            now + way / (1.0 + way.norm_squared() * nearness).powi(2)
        };
        b.iter().zip(now).zip(&self.nearness).map(goal).collect()
    }

    /// E5 at `now`.
    pub fn energy(&self, b: &[Point3<f64>], now: &[Point3<f64>]) -> f64 {
        let rho = |((b, now), nearness): ((&Point3<f64>, &Point3<f64>), &f64)| {
            let square = (b - now).norm_squared();
            square / (1.0 + square * nearness)
        };
        let each = b.iter().zip(now).zip(&self.nearness).map(rho);
        each.zip(&self.weights).map(|(rho, weight)| weight * rho).sum()
    }

    /// Whether E5 has a weight.
    pub fn has_weight(&self) -> bool {
        self.weights.iter().sum::<f64>() > 0.0
    }
}
