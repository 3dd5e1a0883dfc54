use nalgebra_sparse::{CooMatrix, CscMatrix};

use super::OuterSum;

/// Sums small dense blocks into a sparse symmetric matrix, of which it keeps the lower triangle.
#[derive(Clone, Debug)]
pub struct Assembly {
    lower: CooMatrix<f64>,
}

impl Assembly {
    /// An n × n matrix of zeros whose diagonal is stored, so that it can be changed later without a new pattern.
    pub fn new(n: usize) -> Self {
        let mut lower = CooMatrix::new(n, n);
        (0..n).for_each(|i| lower.push(i, i, 0.0));
        Self { lower }
    }

    /// Adds `value` at (i, j) and at (j, i); once if i = j.
    pub fn add(&mut self, i: usize, j: usize, value: f64) {
        self.lower.push(i.max(j), i.min(j), value);
    }

    /// Adds weight · Σₖ aₖ aₖᵀ, where row k of the gradient-like `rows` holds aₖ for the unknowns `indices`.
    ///
    /// `rows[a]` has the entries of unknown `indices[a]` in each of the K rows; an unknown may be listed twice.
    pub fn add_outer<const K: usize>(&mut self, indices: &[u32], rows: &[[f64; K]], weight: f64) {
        for (a, (&i, row_i)) in indices.iter().zip(rows).enumerate() {
            for (b, (&j, row_j)) in indices.iter().zip(rows).enumerate().take(a + 1) {
                let product: f64 = row_i.iter().zip(row_j).map(|(x, y)| x * y).sum();
                // Off the block's diagonal an unknown listed twice meets itself twice.
                let times = if a != b && i == j { 2.0 } else { 1.0 };
                self.add(i as usize, j as usize, times * weight * product);
            }
        }
    }

    /// The lower triangle, duplicates summed.
    pub fn finish(self) -> CscMatrix<f64> {
        CscMatrix::from(&self.lower)
    }
}

impl OuterSum for Assembly {
    fn add_outer<const K: usize>(&mut self, indices: &[u32], rows: &[[f64; K]], weight: f64) {
        Self::add_outer(self, indices, rows, weight);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_listed_twice_acts_as_the_sum_of_its_rows() {
        let mut twice = Assembly::new(2);
        twice.add_outer(&[0, 1, 0], &[[1.0, 2.0], [3.0, -1.0], [0.5, 0.25]], 2.0);
        let mut once = Assembly::new(2);
        once.add_outer(&[0, 1], &[[1.5, 2.25], [3.0, -1.0]], 2.0);
        let (twice, once) = (twice.finish(), once.finish());
        for (a, b) in twice.values().iter().zip(once.values()) {
            assert!((a - b).abs() < 1e-14, "{a} and {b}: a few roundings apart");
        }
    }
}
