//! Minimises the energy over maps and rotations in turn, at a price that does not grow with #V.
//!
//! In the handle space q = p + M X, with rotations R_g, the energy minimised is
//!
//! J(X, R) = λ E_arap + E_diff + ‖X − X̂‖²_ρ,
//!
//! E_arap = 2 ⟨X, A X⟩ − 2 Σ_g ⟨R_g − I, (K X)_gᵀ⟩ + Σ_g ⟨R_g − I, (R_g − I) Ŝ_g⟩ with A = Mᵀ L M,
//! E_diff = ⟨X, B X⟩ − 2 ⟨X, Mᵀ D δ⟩ + ⟨δ, D δ⟩ with B = Mᵀ D M,
//!
//! where δ is the pose minus the rest, X̂ are rigid motions and ρ is small. The maps that minimise it for given rotations are
//! X = X₀ + P (R − I), and the rotations for given maps are polar factors of (Ŝ + K X)_gᵀ.

use mimesh_core::{Error, Result, operators};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn, Matrix3};

use crate::covariances::Covariances;

/// The parts of J that do not depend on the pose.
#[derive(Clone, Debug)]
pub(crate) struct Energy {
    /// λ.
    pub lambda: f64,
    /// 2 λ A + B, 4h × 4h.
    pub quadratic: DMatrix<f64>,
    /// Kᵀ and Ŝ.
    pub covariances: Covariances,
    /// ρ, 4h.
    pub ridge: DVector<f64>,
}

/// The linear system of the global step.
#[derive(Clone, Debug)]
pub(crate) struct GlobalSystem {
    /// The factor of the matrix plus ρ: that of J, or of eq. 18.
    factor: Cholesky<f64, Dyn>,
    /// P, 4h × 3g.
    of_rotations: DMatrix<f64>,
}

impl GlobalSystem {
    /// Factors `matrix` + ρ; `response` (4h × 3g) is what the right-hand side gains for a unit of R − I.
    ///
    /// # Errors
    ///
    /// [`Error::Singular`] if weights are so large or small that the matrix is not positive definite in floating point.
    pub(crate) fn new(matrix: DMatrix<f64>, ridge: &DVector<f64>, response: &DMatrix<f64>) -> Result<Self> {
        let mut matrix = matrix;
        matrix.set_diagonal(&(matrix.diagonal() + ridge));
        let factor = Cholesky::new(matrix).ok_or_else(|| Error::Singular {
            what: "the system of the maps of handles",
            hint: "raise `regularisation`, and look for weights that are not bounded".into(),
        })?;
        let of_rotations = factor.solve(response);
        Ok(Self { factor, of_rotations })
    }

    /// X that solves for the right-hand side `rhs` where all rotations are the identity.
    pub(crate) fn solve(&self, rhs: &DMatrix<f64>) -> DMatrix<f64> {
        self.factor.solve(rhs)
    }
}

/// The parts of J that depend on the pose.
#[derive(Clone, Debug)]
pub(crate) struct Goal {
    /// Mᵀ D δ, 4h × 3.
    pub projected: DMatrix<f64>,
    /// ⟨δ, D δ⟩.
    pub constant: f64,
    /// X̂, 4h × 3.
    pub reference: DMatrix<f64>,
}

impl Goal {
    /// ρ X̂.
    pub(crate) fn ridge_rhs(&self, ridge: &DVector<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(ridge.len(), 3, |i, c| ridge[i] * self.reference[(i, c)])
    }
}

/// The rule by which the alternation stops.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stop {
    /// The relative decrease of J in an iteration below which it stops.
    pub tolerance: f64,
    pub max_iterations: usize,
}

/// The end of the alternation.
#[derive(Clone, Debug)]
pub(crate) struct Minimum {
    /// X.
    pub maps: DMatrix<f64>,
    /// J after the first global step and after each iteration.
    pub energies: Vec<f64>,
    /// The part of the last of them that is not λ E_arap + E_diff.
    pub ridge_energy: f64,
    /// Whether the last decrease was within the tolerance.
    pub converged: bool,
}

/// Starts from `rotations` (one a region) and alternates.
pub(crate) fn alternate(
    energy: &Energy,
    system: &GlobalSystem,
    goal: &Goal,
    mut rotations: Vec<Matrix3<f64>>,
    stop: Stop,
) -> Minimum {
    let start = system.solve(&(&goal.projected + &goal.ridge_rhs(&energy.ridge)));
    let step = |rotations: &[Matrix3<f64>]| {
        let mut maps = start.clone();
        maps.gemm(1.0, &system.of_rotations, &turns(rotations), 1.0);
        maps
    };
    let mut maps = step(&rotations);
    let mut moved = energy.covariances.of_maps.tr_mul(&maps);
    let mut energies = vec![energy.at(&maps, &moved, &rotations, goal)];
    let mut converged = energy.lambda == 0.0;
    while !converged && energies.len() <= stop.max_iterations {
        let at_rest = energy.covariances.at_rest.iter().enumerate();
        let covariances: Vec<_> =
            at_rest.map(|(g, rest)| (rest + moved.fixed_view::<3, 3>(3 * g, 0)).transpose()).collect();
        rotations = operators::rotations(&covariances);
        maps = step(&rotations);
        moved = energy.covariances.of_maps.tr_mul(&maps);
        let (before, now) = (energies[energies.len() - 1], energy.at(&maps, &moved, &rotations, goal));
        energies.push(now);
        // A pose that is met leaves rounding, which may go up as well as down.
        converged = (before - now).abs() <= stop.tolerance * before.abs() + f64::EPSILON * goal.constant;
    }
    Minimum { ridge_energy: energy.of_ridge(&maps, goal), maps, energies, converged }
}

impl Energy {
    /// J, with `moved` = K X.
    fn at(&self, maps: &DMatrix<f64>, moved: &DMatrix<f64>, rotations: &[Matrix3<f64>], goal: &Goal) -> f64 {
        let quadratic = maps.dot(&(&self.quadratic * maps));
        let turns: f64 = rotations
            .iter()
            .zip(&self.covariances.at_rest)
            .enumerate()
            .map(|(g, (rotation, rest))| {
                let turn = rotation - Matrix3::identity();
                turn.dot(&(turn * rest)) - 2.0 * turn.transpose().dot(&moved.fixed_view::<3, 3>(3 * g, 0))
            })
            .sum();
        quadratic - 2.0 * maps.dot(&goal.projected) + goal.constant + self.lambda * turns + self.of_ridge(maps, goal)
    }

    /// ‖X − X̂‖²_ρ.
    fn of_ridge(&self, maps: &DMatrix<f64>, goal: &Goal) -> f64 {
        let row = |i: usize| (maps.row(i) - goal.reference.row(i)).norm_squared();
        self.ridge.iter().enumerate().map(|(i, ridge)| ridge * row(i)).sum()
    }
}

/// R − I of each region, transposed, one below the other: 3g × 3.
fn turns(rotations: &[Matrix3<f64>]) -> DMatrix<f64> {
    let mut result = DMatrix::zeros(3 * rotations.len(), 3);
    for (g, rotation) in rotations.iter().enumerate() {
        result.fixed_view_mut::<3, 3>(3 * g, 0).copy_from(&(rotation.transpose() - Matrix3::identity()));
    }
    result
}
