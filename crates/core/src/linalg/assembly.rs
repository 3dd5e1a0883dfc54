use nalgebra_sparse::CscMatrix;

use super::OuterSum;

/// Sums small dense blocks into a sparse symmetric matrix, of which it keeps the lower triangle.
#[derive(Clone, Debug)]
pub struct Assembly {
    size: usize,
    /// Row, column and value of entries of the lower triangle.
    entries: Vec<(u32, u32, f64)>,
}

impl Assembly {
    /// An n × n matrix of zeros whose diagonal is stored, so that it can be changed later without a new pattern.
    pub fn new(n: usize) -> Self {
        Self { size: n, entries: (0..n as u32).map(|i| (i, i, 0.0)).collect() }
    }

    /// Adds `value` at (i, j) and at (j, i); once if i = j.
    ///
    /// # Panics
    ///
    /// If the matrix is smaller.
    pub fn add(&mut self, i: usize, j: usize, value: f64) {
        assert!(i.max(j) < self.size, "entry ({i}, {j}) of a matrix of {} rows", self.size);
        self.entries.push((i.max(j) as u32, i.min(j) as u32, value));
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

    /// The lower triangle, duplicates summed in the order in which they were added.
    pub fn finish(self) -> CscMatrix<f64> {
        let n = self.size;
        let mut starts = vec![0; n + 1];
        self.entries.iter().for_each(|&(_, j, _)| starts[j as usize + 1] += 1);
        (0..n).for_each(|j| starts[j + 1] += starts[j]);
        let mut next = starts.clone();
        let mut by_column = vec![(0, 0.0); self.entries.len()];
        for (i, j, value) in self.entries {
            let next = &mut next[j as usize];
            by_column[*next] = (i, value);
            *next += 1;
        }
        let (mut offsets, mut rows, mut values) = (Vec::with_capacity(n + 1), vec![], vec![]);
        offsets.push(0);
        for j in 0..n {
            let column = &mut by_column[starts[j]..starts[j + 1]];
            // Stable, for the order of sums.
            column.sort_by_key(|&(i, _)| i);
            for same in column.chunk_by(|a, b| a.0 == b.0) {
                rows.push(same[0].0 as usize);
                values.push(same.iter().skip(1).fold(same[0].1, |sum, (_, value)| sum + value));
            }
            offsets.push(rows.len());
        }
        CscMatrix::try_from_csc_data(n, n, offsets, rows, values)
            .expect("columns are sorted and each row is there once")
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
