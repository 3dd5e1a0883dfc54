//! The program of all handles of a group together, whose weights sum to 1 at each vertex: eq. 1 as the paper prints it.
//!
//! min Σₕ ½ xₕᵀ Q xₕ over x ≥ 0 with Σₕ xₕ = 1; x ≤ 1 follows. By the interior point method of [`BoxProgram`], whose Newton
//! steps share a multiplier y of the sums: S y = r with S = Σₕ (Q + Dₕ)⁻¹. That is solved by conjugate gradients,
//! preconditioned by m^(−½) Q m^(−½) + (Σₕ Dₕ⁻¹)⁻¹, where m is about the number of handles that are free at a vertex: 20 to
//! 300 steps, each a solve a handle.

use mimesh_core::{Result, linalg::Cholesky, stage::Work};
use rayon::prelude::*;

use super::qp::{BoxProgram, MAX_STALLED_STEPS, MAX_STEP_TO_BOUND};

/// Most conjugate gradient steps of a direction.
const MAX_STEPS: usize = 1000;

/// Weights near the minimum.
#[derive(Clone, Debug)]
pub struct Coupled {
    /// xₕ; sums are 1 to rounding.
    pub x: Vec<Vec<f64>>,
    /// ½ xₕᵀ Q xₕ of each handle.
    pub energies: Vec<f64>,
    /// The most that the sum of energies can lie above the least possible, over that sum.
    pub relative_gap: f64,
    /// Interior point steps, each a factorisation a handle.
    pub iterations: usize,
}

/// x and the multipliers of x ≥ 0, a list a handle.
struct Iterate {
    x: Vec<Vec<f64>>,
    z: Vec<Vec<f64>>,
}

impl BoxProgram<'_> {
    /// Minimises the sum of energies from `starts`, one a handle, whose held unknowns have the values they keep, until the gap
    /// is at most `tolerance` × the sum or there is no more progress; the caller looks at the gap.
    pub fn minimise_coupled(
        &self,
        starts: &[Vec<f64>],
        tolerance: f64,
        max_iterations: usize,
        work: Work<'_>,
    ) -> Coupled {
        let (n, count) = (starts[0].len(), starts.len());
        let mut at = Iterate { x: starts.to_vec(), z: vec![vec![0.0; n]; count] };
        let least = 0.3 / count as f64;
        at.x.iter_mut().for_each(|x| self.free.iter().for_each(|&i| x[i] = x[i].max(least)));
        self.divide(&mut at.x);
        let mut best = self.measure(&at.x);
        let mean = best.energies.iter().sum::<f64>() / (self.free.len() * count).max(1) as f64;
        for (x, z) in at.x.iter().zip(&mut at.z) {
            self.free.iter().for_each(|&i| z[i] = mean / x[i]);
        }
        let mut factors = vec![self.factored.clone(); count];
        let mut y = vec![0.0; n];
        let mut stalled = 0;
        let first = best.relative_gap;
        while best.relative_gap > tolerance && best.iterations + stalled < max_iterations && stalled < MAX_STALLED_STEPS
        {
            let refactored = factors.par_iter_mut().zip(&at.x).zip(&at.z).map(|((factor, x), z)| {
                let starts = self.energy.matrix.col_offsets();
                factor.refactor(|values| {
                    values.copy_from_slice(&self.values);
                    self.free.iter().for_each(|&i| values[starts[i]] += z[i] / x[i]);
                })
            });
            // What cannot be factored any more is as near to the bounds as rounding allows.
            if refactored.collect::<Result<Vec<()>>>().is_err() {
                break;
            }
            // Sums that are off by more would show in the gap, since Q magnifies what is not smooth.
            let accuracy = (1e-5 * best.relative_gap).clamp(1e-11, 1e-7);
            self.advance_coupled(&mut at, &factors, &mut y, accuracy);
            stalled += 1;
            let found = self.measure(&at.x);
            if found.relative_gap < best.relative_gap {
                best = Coupled { iterations: best.iterations + stalled, ..found };
                stalled = 0;
                // The gap falls by about the same factor a step.
                work.done((first / best.relative_gap).ln() / (first / tolerance).ln());
            }
        }
        best
    }

    /// Energies and gap after rows are divided by their sums.
    fn measure(&self, x: &[Vec<f64>]) -> Coupled {
        let mut x = x.to_vec();
        self.divide(&mut x);
        let (energies, gradients): (Vec<f64>, Vec<Vec<f64>>) =
            x.par_iter().map(|x| self.energy.energy_and_gradient(x)).unzip();
        // What the linear model loses to the best corner of the simplex at each vertex.
        let loss = |&i: &usize| {
            let now: f64 = x.iter().zip(&gradients).map(|(x, g)| x[i] * g[i]).sum();
            now - gradients.iter().map(|g| g[i]).fold(f64::INFINITY, f64::min)
        };
        let gap: f64 = self.free.iter().map(loss).sum();
        let relative_gap = gap / energies.iter().sum::<f64>().max(f64::MIN_POSITIVE);
        Coupled { x, energies, relative_gap, iterations: 0 }
    }

    fn divide(&self, x: &mut [Vec<f64>]) {
        for &i in &self.free {
            let sum: f64 = x.iter().map(|x| x[i]).sum();
            x.iter_mut().for_each(|x| x[i] /= sum);
        }
    }

    /// One predictor and corrector step.
    fn advance_coupled(&self, at: &mut Iterate, factors: &[Cholesky], y: &mut [f64], accuracy: f64) {
        let (n, count) = (y.len(), factors.len());
        let terms = (self.free.len() * count).max(1) as f64;
        let product = |at: &Iterate, d: Option<&Iterate>, step: f64| {
            let of = |h: usize, i: usize| match d {
                Some(d) => (at.x[h][i] + step * d.x[h][i]) * (at.z[h][i] + step * d.z[h][i]),
                None => at.x[h][i] * at.z[h][i],
            };
            (0..count).flat_map(|h| self.free.iter().map(move |&i| (h, i))).map(|(h, i)| of(h, i)).sum::<f64>() / terms
        };
        let mean = product(at, None, 0.0);
        let mut goal = vec![vec![0.0; n]; count];
        let gradients: Vec<Vec<f64>> = at.x.par_iter().map(|x| self.energy.energy_and_gradient(x).1).collect();
        // The predictor only says how far to aim.
        let affine = self.direction_coupled(at, &gradients, &goal, factors, y, accuracy.max(1e-5));
        let after = product(at, Some(&affine), self.longest_coupled(at, &affine).min(1.0));
        let centre = mean * (after / mean).powi(3);
        for (goal, (dx, dz)) in goal.iter_mut().zip(affine.x.iter().zip(&affine.z)) {
            self.free.iter().for_each(|&i| goal[i] = centre - dx[i] * dz[i]);
        }
        let direction = self.direction_coupled(at, &gradients, &goal, factors, y, accuracy);
        let step = (MAX_STEP_TO_BOUND * self.longest_coupled(at, &direction)).min(1.0);
        for h in 0..count {
            for &i in &self.free {
                at.x[h][i] += step * direction.x[h][i];
                at.z[h][i] += step * direction.z[h][i];
            }
        }
    }

    /// The Newton direction towards stationarity, sums of 1 within `accuracy` and the products `goal`; `y` is where the multiplier
    /// of the sums starts and ends.
    fn direction_coupled(
        &self,
        at: &Iterate,
        gradients: &[Vec<f64>],
        goal: &[Vec<f64>],
        factors: &[Cholesky],
        y: &mut [f64],
        accuracy: f64,
    ) -> Iterate {
        let n = y.len();
        let solve = |h: usize, right: &dyn Fn(usize) -> f64| {
            let mut d = vec![0.0; n];
            self.free.iter().for_each(|&i| d[i] = right(i));
            factors[h].solve_in_place(&mut d, 1);
            d
        };
        let alone: Vec<Vec<f64>> = (0..factors.len())
            .into_par_iter()
            .map(|h| solve(h, &|i| goal[h][i] / at.x[h][i] - gradients[h][i]))
            .collect();
        // Summed in the order of handles, whatever thread they were solved on.
        let summed = |v: &[f64]| {
            let each: Vec<_> = (0..factors.len()).into_par_iter().map(|h| solve(h, &|i| v[i])).collect();
            let mut sum = vec![0.0; n];
            each.iter().for_each(|d| sum.iter_mut().zip(d).for_each(|(s, d)| *s += d));
            sum
        };
        let mut right = vec![0.0; n];
        for &i in &self.free {
            right[i] = 1.0 - at.x.iter().zip(&alone).map(|(x, d)| x[i] + d[i]).sum::<f64>();
        }
        self.conjugate_gradients(at, summed, &right, y, accuracy);
        let x: Vec<Vec<f64>> = (0..factors.len())
            .into_par_iter()
            .map(|h| solve(h, &|i| goal[h][i] / at.x[h][i] - gradients[h][i] + y[i]))
            .collect();
        let mut z = vec![vec![0.0; n]; x.len()];
        for (h, z) in z.iter_mut().enumerate() {
            self.free.iter().for_each(|&i| z[i] = (goal[h][i] - at.z[h][i] * x[h][i]) / at.x[h][i] - at.z[h][i]);
        }
        Iterate { x, z }
    }

    /// Solves S y = `right` from y, until no entry of the residual exceeds `accuracy`; `apply` gives S v.
    fn conjugate_gradients(
        &self,
        at: &Iterate,
        apply: impl Fn(&[f64]) -> Vec<f64>,
        right: &[f64],
        y: &mut [f64],
        accuracy: f64,
    ) {
        let n = y.len();
        let (starts, values) = (self.energy.matrix.col_offsets(), &self.values);
        let (mut root, mut diagonal) = (vec![0.0; n], vec![0.0; n]);
        for &i in &self.free {
            let added = || at.x.iter().zip(&at.z).map(|(x, z)| z[i] / x[i]);
            let own = values[starts[i]];
            root[i] = 1.0 / added().map(|d| own / (own + d)).sum::<f64>().sqrt();
            diagonal[i] = 1.0 / added().map(|d| 1.0 / d).sum::<f64>();
        }
        let precondition = |r: &[f64]| {
            let scaled: Vec<f64> = r.iter().zip(&root).map(|(r, t)| r * t).collect();
            let (_, product) = self.energy.energy_and_gradient(&scaled);
            (0..n).map(|i| root[i] * product[i] + diagonal[i] * r[i]).collect::<Vec<f64>>()
        };
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let mut r: Vec<f64> = right.iter().zip(apply(y)).map(|(b, s)| b - s).collect();
        let mut z = precondition(&r);
        let mut p = z.clone();
        let mut rz = dot(&r, &z);
        for _ in 0..MAX_STEPS {
            if r.iter().all(|r| r.abs() <= accuracy) || rz <= 0.0 {
                return;
            }
            let s = apply(&p);
            let step = rz / dot(&p, &s);
            y.iter_mut().zip(&p).for_each(|(y, p)| *y += step * p);
            r.iter_mut().zip(&s).for_each(|(r, s)| *r -= step * s);
            z = precondition(&r);
            let next = dot(&r, &z);
            p.iter_mut().zip(&z).for_each(|(p, z)| *p = z + next / rz * *p);
            rz = next;
        }
    }

    /// The step along `direction` at which the first of x and its multipliers is 0.
    fn longest_coupled(&self, at: &Iterate, direction: &Iterate) -> f64 {
        let limit = |value: f64, change: f64| if change < 0.0 { -value / change } else { f64::INFINITY };
        let of = |h: usize, i: usize| limit(at.x[h][i], direction.x[h][i]).min(limit(at.z[h][i], direction.z[h][i]));
        let all = (0..at.x.len()).flat_map(|h| self.free.iter().map(move |&i| (h, i)));
        all.map(|(h, i)| of(h, i)).fold(f64::INFINITY, f64::min)
    }
}
