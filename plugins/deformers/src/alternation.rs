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
//!
//! So rotations follow from rotations: K X = K X₀ + K P (R − I), and J along them is a quadratic function of R − I. An iteration
//! takes a product of the size of the regions alone; maps are made at the end.

use mimesh_core::{Error, Result, operators};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn, Matrix3};

use crate::{covariances::Covariances, handle_space::transposed_product};

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

/// J over rotations, with the maps that follow them.
#[derive(Clone, Debug)]
pub(crate) struct Reduced {
    /// K P, 3g × 3g.
    moved: DMatrix<f64>,
    /// Where maps do not minimise J itself.
    stacked: Option<Stacked>,
}

/// J for maps X₀ + P (R − I) that minimise something else.
#[derive(Clone, Debug)]
struct Stacked {
    /// Pᵀ (2 λ A + B + ρ), 3g × 4h.
    slope: DMatrix<f64>,
    /// Pᵀ (2 λ A + B + ρ) P − 2 λ K P, 3g × 3g.
    quadratic: DMatrix<f64>,
}

impl Reduced {
    /// The function of `energy` along the maps of `system`; `is_exact` says that these minimise it.
    pub(crate) fn new(energy: &Energy, system: &GlobalSystem, is_exact: bool) -> Self {
        let moved = transposed_product(&energy.covariances.of_maps, &system.of_rotations);
        let stacked = (!is_exact).then(|| {
            let slope = transposed_product(&system.of_rotations, &energy.with_ridge());
            let quadratic = &slope * &system.of_rotations - &moved * (2.0 * energy.lambda);
            Stacked { slope, quadratic }
        });
        Self { moved, stacked }
    }
}

/// Starts from `rotations` (one a region) and alternates.
pub(crate) fn alternate(
    energy: &Energy,
    system: &GlobalSystem,
    reduced: &Reduced,
    goal: &Goal,
    mut rotations: Vec<Matrix3<f64>>,
    stop: Stop,
) -> Minimum {
    let rhs = &goal.projected + &goal.ridge_rhs(&energy.ridge);
    let start = system.solve(&rhs);
    let at_start = Start::new(energy, system, reduced, goal, &rhs, &start);
    let mut turns = turns(&rotations);
    let mut moved = at_start.moved(reduced, &turns);
    let mut energies = vec![at_start.energy(energy, reduced, &turns, &moved)];
    let mut converged = energy.lambda == 0.0;
    let mut covariances = Vec::with_capacity(rotations.len());
    while !converged && energies.len() <= stop.max_iterations {
        covariances.clear();
        let at_rest = energy.covariances.at_rest.iter().enumerate();
        covariances.extend(at_rest.map(|(g, rest)| (rest + moved.fixed_view::<3, 3>(3 * g, 0)).transpose()));
        rotations = operators::rotations(&covariances);
        turns = self::turns(&rotations);
        moved = at_start.moved(reduced, &turns);
        let (before, now) = (energies[energies.len() - 1], at_start.energy(energy, reduced, &turns, &moved));
        energies.push(now);
        // A pose that is met leaves rounding, which may go up as well as down.
        converged = (before - now).abs() <= stop.tolerance * before.abs() + f64::EPSILON * goal.constant;
    }
    let mut maps = start;
    maps.gemm(1.0, &system.of_rotations, &turns, 1.0);
    Minimum { ridge_energy: energy.of_ridge(&maps, goal), maps, energies, converged }
}

/// J and K X where all rotations are the identity, and how they change from there.
struct Start {
    /// J.
    energy: f64,
    /// K X₀, 3g × 3.
    moved: DMatrix<f64>,
    /// The slope of J over R − I, 3g × 3; without that where maps minimise J, for it is −2 λ K X₀.
    slope: Option<DMatrix<f64>>,
}

impl Start {
    fn new(
        energy: &Energy,
        system: &GlobalSystem,
        reduced: &Reduced,
        goal: &Goal,
        rhs: &DMatrix<f64>,
        maps: &DMatrix<f64>,
    ) -> Self {
        let moved = transposed_product(&energy.covariances.of_maps, maps);
        let constant = goal.constant + goal.reference.dot(&goal.ridge_rhs(&energy.ridge));
        match &reduced.stacked {
            None => Self { energy: constant - maps.dot(rhs), moved, slope: None },
            Some(Stacked { slope, .. }) => {
                let slope =
                    (slope * maps - transposed_product(&system.of_rotations, rhs) - &moved * energy.lambda) * 2.0;
                let product = energy.with_ridge() * maps;
                Self { energy: constant + maps.dot(&(product - rhs * 2.0)), moved, slope: Some(slope) }
            }
        }
    }

    /// K X for R − I.
    fn moved(&self, reduced: &Reduced, turns: &DMatrix<f64>) -> DMatrix<f64> {
        let mut moved = self.moved.clone();
        moved.gemm(1.0, &reduced.moved, turns, 1.0);
        moved
    }

    /// J for R − I, with `moved` = K X.
    fn energy(&self, energy: &Energy, reduced: &Reduced, turns: &DMatrix<f64>, moved: &DMatrix<f64>) -> f64 {
        let of_rest = |(g, rest): (usize, &Matrix3<f64>)| {
            let turn = turns.fixed_view::<3, 3>(3 * g, 0).transpose();
            turn.dot(&(turn * rest))
        };
        let at_rest: f64 = energy.covariances.at_rest.iter().enumerate().map(of_rest).sum();
        let of_maps = match (&reduced.stacked, &self.slope) {
            (Some(stacked), Some(slope)) => turns.dot(slope) + turns.dot(&(&stacked.quadratic * turns)),
            _ => -energy.lambda * (turns.dot(&self.moved) + turns.dot(moved)),
        };
        self.energy + energy.lambda * at_rest + of_maps
    }
}

impl Energy {
    /// 2 λ A + B + ρ.
    fn with_ridge(&self) -> DMatrix<f64> {
        let mut matrix = self.quadratic.clone();
        matrix.set_diagonal(&(matrix.diagonal() + &self.ridge));
        matrix
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

#[cfg(test)]
mod tests;
