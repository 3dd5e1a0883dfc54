//! How far above the least possible the energy of given weights may lie.
//!
//! For feasible y = x + d, E(y) = E(x) + gᵀd + ½ dᵀ Q d with g = Q x. Two bounds on what d may gain:
//!
//! - the Frank-Wolfe gap, what gᵀd can lose within the box: it is about the multipliers times how far x is off, and large where
//!   g at free vertices is not small to rounding;
//! - ½ rᵀ Q⁻¹ r, where r is −g without what points out of the box, Q is without held vertices and
//!   the box is ignored. Where x g > 0 is negligible, its part of the first bound is taken instead.
//!
//! Both hold whatever method x is from, and overstate: 1e-6 to 1e-3 of the energy where the truth is below 1e-6.

use rayon::prelude::*;

use super::qp::BoxProgram;

/// Products of weight and gradient below this part of the energy over the free vertices are negligible.
const NEGLIGIBLE: f64 = 1e-9;

/// Right-hand sides of a solve: a fixed number, so that threads do not change results.
const COLUMNS: usize = 8;

impl BoxProgram<'_> {
    /// For each of `weights` its energy and the most that this can lie above the minimum.
    pub fn certify(&self, weights: &[Vec<f64>]) -> Vec<(f64, f64)> {
        weights.par_chunks(COLUMNS).flat_map_iter(|some| self.certify_some(some)).collect()
    }

    fn certify_some(&self, weights: &[Vec<f64>]) -> Vec<(f64, f64)> {
        let n = self.energy.inverse_mass.len();
        let mut residuals = vec![0.0; n * weights.len()];
        let mut found = Vec::with_capacity(weights.len());
        for (x, r) in weights.iter().zip(residuals.chunks_mut(n)) {
            let (energy, gradient) = self.energy.energy_and_gradient(x);
            let negligible = NEGLIGIBLE * energy / self.free.len().max(1) as f64;
            let mut linear = 0.0;
            for &i in &self.free {
                let (x, g) = (x[i], gradient[i]);
                if g * x > 0.0 && g * x < negligible {
                    linear += g * x;
                } else if g * x > 0.0 || g < 0.0 && x < 1.0 {
                    r[i] = -g;
                }
            }
            found.push((energy, self.gap(x, &gradient), linear));
        }
        let mut solved = residuals.clone();
        self.factored.solve_in_place(&mut solved, weights.len());
        let products = residuals.chunks(n).zip(solved.chunks(n));
        let products = products.map(|(r, s)| 0.5 * r.iter().zip(s).map(|(r, s)| r * s).sum::<f64>());
        found.into_iter().zip(products).map(|((energy, gap, linear), p)| (energy, gap.min(p + linear))).collect()
    }
}
