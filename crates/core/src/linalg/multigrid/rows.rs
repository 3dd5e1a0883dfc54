//! Sparse matrices by rows, in single precision: a preconditioner needs no more.

/// Numbers of the three right-hand sides, and one to fill a vector.
pub(super) type Row = [f32; 4];

/// A sparse matrix by rows.
#[derive(Clone, Debug)]
pub(super) struct Rows {
    pub starts: Vec<u32>,
    pub columns: Vec<u32>,
    pub values: Vec<f32>,
}

impl Rows {
    /// Number of rows.
    pub fn count(&self) -> usize {
        self.starts.len() - 1
    }

    /// The entries of row `i`: columns and values.
    pub fn row(&self, i: usize) -> impl DoubleEndedIterator<Item = (usize, f32)> + '_ {
        let range = self.starts[i] as usize..self.starts[i + 1] as usize;
        self.columns[range.clone()].iter().zip(&self.values[range]).map(|(&j, &value)| (j as usize, value))
    }

    /// For each row 1 over the entry on the diagonal; 0 where that is not positive.
    pub fn inverse_diagonal(&self) -> Vec<f32> {
        let diagonal = |i: usize| self.row(i).find(|&(j, _)| j == i).map_or(0.0, |(_, value)| value);
        (0..self.count()).map(diagonal).map(|d| if d > 0.0 { 1.0 / d } else { 0.0 }).collect()
    }

    /// The sum of a row of x by the entries of row `i`, taken from `start`.
    pub fn subtract_row(&self, start: Row, entries: impl Iterator<Item = (usize, f32)>, x: &[Row]) -> Row {
        let mut sum = start;
        for (j, value) in entries {
            let x = &x[j];
            (0..4).for_each(|c| sum[c] -= value * x[c]);
        }
        sum
    }

    /// y ← A x.
    pub fn multiply(&self, x: &[Row], y: &mut [Row]) {
        for (i, y) in y.iter_mut().enumerate() {
            let mut sum = [0.0; 4];
            for (j, value) in self.row(i) {
                let x = &x[j];
                (0..4).for_each(|c| sum[c] += value * x[c]);
            }
            *y = sum;
        }
    }

    /// The transpose, of `count` rows.
    pub fn transposed(&self, count: usize) -> Self {
        let mut starts = vec![0; count + 1];
        self.columns.iter().for_each(|&j| starts[j as usize + 1] += 1);
        (0..count).for_each(|j| starts[j + 1] += starts[j]);
        let mut next = starts.clone();
        let (mut columns, mut values) = (vec![0; self.columns.len()], vec![0.0; self.columns.len()]);
        for i in 0..self.count() {
            for (j, value) in self.row(i) {
                let next = &mut next[j];
                (columns[*next as usize], values[*next as usize]) = (i as u32, value);
                *next += 1;
            }
        }
        Self { starts, columns, values }
    }

    /// The product with `other`, which has `count` columns; columns of a row stand in no order.
    pub fn times(&self, other: &Self, count: usize) -> Self {
        let mut place = vec![u32::MAX; count];
        let mut product = Self { starts: vec![0], columns: vec![], values: vec![] };
        for i in 0..self.count() {
            let start = product.columns.len();
            for (k, a) in self.row(i) {
                for (j, b) in other.row(k) {
                    let place = &mut place[j];
                    if *place == u32::MAX {
                        *place = product.columns.len() as u32;
                        product.columns.push(j as u32);
                        product.values.push(a * b);
                    } else {
                        product.values[*place as usize] += a * b;
                    }
                }
            }
            product.columns[start..].iter().for_each(|&j| place[j as usize] = u32::MAX);
            product.starts.push(product.columns.len() as u32);
        }
        product
    }

    /// Sorts the columns of each row.
    pub fn sort(&mut self) {
        let mut row = vec![];
        for ends in self.starts.windows(2) {
            let range = ends[0] as usize..ends[1] as usize;
            row.clear();
            row.extend(self.columns[range.clone()].iter().copied().zip(self.values[range.clone()].iter().copied()));
            row.sort_unstable_by_key(|&(j, _)| j);
            for (k, &(j, value)) in range.zip(&row) {
                (self.columns[k], self.values[k]) = (j, value);
            }
        }
    }
}
