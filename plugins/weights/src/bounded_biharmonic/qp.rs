//! The quadratic program of one handle, by an interior point method.
//!
//! min ½ xᵀ Q x over 0 ≤ x ≤ 1 with some unknowns held. Mehrotra's predictor and corrector [Mehrotra 1992] with Gondzio's
//! further correctors [Gondzio 1996], which cost a solve each and spare factorisations; x stays within the bounds
//! throughout. To a relative gap of 1e-6 it took 13 to 15 factorisations of Q plus a diagonal on 2,161 vertices, 14 to 17 on
//! 13,348 and up to 28 on a camel of 21,887; they all share one pattern.
//!
//! A primal-dual active set comes as fast to a rough answer and then changes a ring of vertices a step: 40 to 80
//! factorisations to its end.

use mimesh_core::{Result, linalg::Cholesky};
use rayon::prelude::*;

use crate::bilaplacian::Bilaplacian;

/// The start keeps this distance from the bounds.
pub(super) const MARGIN: f64 = 0.05;

/// The part of the way to the nearest bound that a step goes at most.
pub(super) const MAX_STEP_TO_BOUND: f64 = 0.995;

/// Steps without a smaller gap after which there is no more to come.
pub(super) const MAX_STALLED_STEPS: usize = 8;

/// Further correctors of a step: the first takes the factorisations down by 12 %, others by 1 to 2 %.
const MAX_CORRECTORS: usize = 1;

/// How much longer than the last step a further corrector aims to make its step.
pub(super) const STEP_INCREASE: f64 = 0.3;

/// min ½ xᵀ Q x over 0 ≤ x ≤ 1, where some unknowns are held.
#[derive(Debug)]
pub struct BoxProgram<'a> {
    pub(super) energy: &'a Bilaplacian,
    /// Q without the held unknowns.
    pub(super) values: Vec<f64>,
    pub(super) factored: Cholesky,
    pub(super) free: Vec<usize>,
}

/// A point near the minimum.
#[derive(Clone, Debug)]
pub struct Minimum {
    /// x; entries that lie at a bound are exactly there.
    pub x: Vec<f64>,
    /// ½ xᵀ Q x.
    pub energy: f64,
    /// The most that the energy can lie above the least possible.
    pub gap: f64,
    /// Factorisations done.
    pub iterations: usize,
}

/// An iterate of the method: x, and the multipliers of x ≥ 0 and of x ≤ 1.
struct Iterate {
    x: Vec<f64>,
    lower: Vec<f64>,
    upper: Vec<f64>,
}

impl<'a> BoxProgram<'a> {
    /// Prepares with the unknowns that are `held`; `pattern` is a factorisation of a matrix of the pattern of Q.
    ///
    /// # Errors
    ///
    /// [`Error::Singular`](mimesh_core::Error::Singular) if Q without the held unknowns is not positive definite.
    pub fn new(energy: &'a Bilaplacian, held: &[bool], pattern: &Cholesky) -> Result<Self> {
        let values = energy.without(held);
        let factored = pattern.with_values(&values)?;
        Ok(Self { energy, values, factored, free: (0..held.len()).filter(|&i| !held[i]).collect() })
    }

    /// The minima without bounds for each of `unknowns`, which are held, being 1 and the other held ones 0.
    pub fn all_unbounded(&self, unknowns: &[usize]) -> Vec<Vec<f64>> {
        unknowns.par_iter().map(|&unknown| self.unbounded(unknown)).collect()
    }

    /// The minimum without bounds for `unknown`, which is held, being 1 and the other held ones 0.
    pub fn unbounded(&self, unknown: usize) -> Vec<f64> {
        let mut held = vec![0.0; self.energy.inverse_mass.len()];
        held[unknown] = 1.0;
        let gradient = self.energy.energy_and_gradient(&held).1;
        let mut step = vec![0.0; held.len()];
        self.free.iter().for_each(|&i| step[i] = -gradient[i]);
        self.factored.solve_refined_in_place(&mut step, 1);
        held.iter().zip(&step).map(|(x, d)| x + d).collect()
    }

    /// Minimises from `start`, whose held unknowns have the values they keep, until the gap is at most `tolerance` × the energy
    /// or rounding allows no progress; the caller looks at the gap.
    pub fn minimise(&self, start: &[f64], tolerance: f64, max_iterations: usize) -> Minimum {
        let mut at = Iterate { x: start.to_vec(), lower: vec![0.0; start.len()], upper: vec![0.0; start.len()] };
        self.free.iter().for_each(|&i| at.x[i] = at.x[i].clamp(MARGIN, 1.0 - MARGIN));
        let (mut energy, mut gradient) = self.energy.energy_and_gradient(&at.x);
        let mean = energy / self.free.len().max(1) as f64;
        for &i in &self.free {
            (at.lower[i], at.upper[i]) = (mean / at.x[i], mean / (1.0 - at.x[i]));
        }
        let mut cholesky = self.factored.clone();
        let starts = self.energy.matrix.col_offsets();
        let mut best = self.at_bounds(&at.x, energy, &gradient);
        let mut stalled = 0;
        while best.gap > tolerance * best.energy
            && best.iterations + stalled < max_iterations
            && stalled < MAX_STALLED_STEPS
        {
            let factored = cholesky.refactor(|values| {
                values.copy_from_slice(&self.values);
                for &i in &self.free {
                    values[starts[i]] += at.lower[i] / at.x[i] + at.upper[i] / (1.0 - at.x[i]);
                }
            });
            // What cannot be factored any more is as near to the bounds as rounding allows.
            if factored.is_err() {
                break;
            }
            self.advance(&mut at, &gradient, &cholesky);
            (energy, gradient) = self.energy.energy_and_gradient(&at.x);
            stalled += 1;
            let found = self.at_bounds(&at.x, energy, &gradient);
            if found.gap * best.energy < best.gap * found.energy {
                best = Minimum { iterations: best.iterations + stalled, ..found };
                stalled = 0;
            }
        }
        best
    }

    /// x with those entries put at a bound whose own Newton step would pass it, if that keeps the gap as small.
    fn at_bounds(&self, x: &[f64], energy: f64, gradient: &[f64]) -> Minimum {
        let gap = self.gap(x, gradient);
        let starts = self.energy.matrix.col_offsets();
        let mut put = x.to_vec();
        for &i in &self.free {
            let next = x[i] - gradient[i] / self.values[starts[i]];
            if next <= 0.0 || next >= 1.0 {
                put[i] = next.clamp(0.0, 1.0);
            }
        }
        let (put_energy, put_gradient) = self.energy.energy_and_gradient(&put);
        let put_gap = self.gap(&put, &put_gradient);
        if put_gap * energy <= 2.0 * gap * put_energy {
            return Minimum { x: put, energy: put_energy, gap: put_gap, iterations: 0 };
        }
        Minimum { x: x.to_vec(), energy, gap, iterations: 0 }
    }

    /// The most that the energy at x can lie above the minimum: what its linear model loses to the best point of the box.
    pub(super) fn gap(&self, x: &[f64], gradient: &[f64]) -> f64 {
        self.free.iter().map(|&i| (gradient[i] * x[i]).max(gradient[i] * (x[i] - 1.0))).sum()
    }

    /// One step of the method.
    fn advance(&self, at: &mut Iterate, gradient: &[f64], cholesky: &Cholesky) {
        let n = at.x.len();
        let mean = self.complementarity(at, None, 0.0);
        // The products x z that a direction aims at.
        let mut goal = [vec![0.0; n], vec![0.0; n]];
        let affine = self.direction(at, gradient, &goal, cholesky);
        let after = self.complementarity(at, Some(&affine), self.longest(at, &affine).min(1.0));
        let centre = mean * (after / mean).powi(3);
        for &i in &self.free {
            goal[0][i] = centre - affine.x[i] * affine.lower[i];
            goal[1][i] = centre + affine.x[i] * affine.upper[i];
        }
        let mut best = self.direction(at, gradient, &goal, cholesky);
        let mut step = (MAX_STEP_TO_BOUND * self.longest(at, &best)).min(1.0);
        for _ in 0..MAX_CORRECTORS {
            let further = (step + STEP_INCREASE).min(1.0);
            // Products that would stray from the centre after a longer step are aimed at its neighbourhood.
            let nearer = |value: f64, slope: f64, z: f64, dz: f64| {
                let product = (value + further * slope) * (z + further * dz);
                (product.clamp(0.1 * centre, 10.0 * centre) - product).max(-10.0 * centre)
            };
            let mut corrected = goal.clone();
            for &i in &self.free {
                corrected[0][i] += nearer(at.x[i], best.x[i], at.lower[i], best.lower[i]);
                corrected[1][i] += nearer(1.0 - at.x[i], -best.x[i], at.upper[i], best.upper[i]);
            }
            let direction = self.direction(at, gradient, &corrected, cholesky);
            let length = (MAX_STEP_TO_BOUND * self.longest(at, &direction)).min(1.0);
            if length < step + 0.1 * STEP_INCREASE {
                break;
            }
            (goal, best, step) = (corrected, direction, length);
        }
        for &i in &self.free {
            at.x[i] += step * best.x[i];
            at.lower[i] += step * best.lower[i];
            at.upper[i] += step * best.upper[i];
        }
    }

    /// The Newton direction towards stationarity and the products `goal`.
    fn direction(&self, at: &Iterate, gradient: &[f64], goal: &[Vec<f64>; 2], cholesky: &Cholesky) -> Iterate {
        let n = at.x.len();
        let mut d = Iterate { x: vec![0.0; n], lower: vec![0.0; n], upper: vec![0.0; n] };
        for &i in &self.free {
            d.x[i] = goal[0][i] / at.x[i] - goal[1][i] / (1.0 - at.x[i]) - gradient[i];
        }
        cholesky.solve_in_place(&mut d.x, 1);
        for &i in &self.free {
            let (x, rest) = (at.x[i], 1.0 - at.x[i]);
            d.lower[i] = (goal[0][i] - at.lower[i] * d.x[i]) / x - at.lower[i];
            d.upper[i] = (goal[1][i] + at.upper[i] * d.x[i]) / rest - at.upper[i];
        }
        d
    }

    /// The mean of the products x z after a step.
    fn complementarity(&self, at: &Iterate, direction: Option<&Iterate>, step: f64) -> f64 {
        let product = |&i: &usize| {
            let (dx, dl, du) = direction.map_or((0.0, 0.0, 0.0), |d| (d.x[i], d.lower[i], d.upper[i]));
            let x = at.x[i] + step * dx;
            x * (at.lower[i] + step * dl) + (1.0 - x) * (at.upper[i] + step * du)
        };
        self.free.iter().map(product).sum::<f64>() / (2 * self.free.len().max(1)) as f64
    }

    /// The step along `direction` at which the first of x, 1 − x and the multipliers is 0.
    fn longest(&self, at: &Iterate, direction: &Iterate) -> f64 {
        let limit = |value: f64, change: f64| if change < 0.0 { -value / change } else { f64::INFINITY };
        let of = |&i: &usize| {
            let x = limit(at.x[i], direction.x[i]).min(limit(1.0 - at.x[i], -direction.x[i]));
            x.min(limit(at.lower[i], direction.lower[i])).min(limit(at.upper[i], direction.upper[i]))
        };
        self.free.iter().map(of).fold(f64::INFINITY, f64::min)
    }
}
