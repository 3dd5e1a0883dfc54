//! Conjugate gradients with algebraic multigrid as their preconditioner [Vaněk, Mandel and Brezina 1996], for large Laplacians whose
//! values change often.

mod aggregates;
mod cycle;
mod order;
mod rows;
#[cfg(test)]
mod tests;

use nalgebra_sparse::CscMatrix;

use self::{aggregates::prolongations, cycle::Prolongation, order::waves, rows::Rows};
use super::{Assembly, Cholesky, symbolic::singular};
use crate::{Error, Result};

pub use self::cycle::Grids;

/// So many steps are tried before a matrix is factored.
const MAX_STEPS: usize = 100;

/// Matrices of one pattern near a Laplacian, each solved in time and memory linear in its size.
///
/// Unknowns are joined to some eight times fewer ones again and again, until few are left; how, depends on the first matrix alone. For
/// other values ([`Grids`]) only the coarse matrices are computed anew. On a surface of a million vertices a step takes 0.1 s and
/// lowers the error to some 0.3, where a factorisation takes some seconds.
///
/// Where steps do not get there, the matrix is factored. Everything runs in a fixed order, so that results do not depend on the number
/// of threads.
#[derive(Clone, Debug)]
pub struct Multigrid {
    /// The row of each unknown.
    row_of: Vec<u32>,
    /// The lower triangle by rows; the diagonal is the last entry of each.
    starts: Vec<u32>,
    columns: Vec<u32>,
    /// For each entry of the whole matrix, by rows, that of the lower triangle.
    lower_of: Vec<u32>,
    prolongations: Vec<Prolongation>,
    /// The grids of the first matrix.
    first: Grids,
    /// Its values.
    values: Vec<f64>,
    what: &'static str,
}

impl Multigrid {
    /// Prepares for matrices with the pattern of `lower`, a lower triangle; `what` names the system in errors.
    ///
    /// # Errors
    ///
    /// [`Error::Singular`] if an entry of the diagonal is not positive, or any is not finite.
    pub fn new(lower: &CscMatrix<f64>, what: &'static str) -> Result<Self> {
        let row_of = waves(lower);
        let (starts, columns, values) = by_rows(lower, &row_of);
        let is_positive =
            |i: usize| columns[starts[i + 1] as usize - 1] as usize == i && values[starts[i + 1] as usize - 1] > 0.0;
        if !values.iter().all(|value| value.is_finite()) || !(0..lower.ncols()).all(is_positive) {
            return Err(singular(what));
        }
        let (mut finest, lower_of) = whole(&starts, &columns);
        set_values(&mut finest, &lower_of, &values);
        let (matrices, prolongations) = prolongations(finest);
        let first = Grids::new(matrices);
        Ok(Self { row_of, starts, columns, lower_of, prolongations, first, values, what })
    }

    /// n.
    pub fn size(&self) -> usize {
        self.row_of.len()
    }

    /// The number of entries of a lower triangle.
    pub fn entry_count(&self) -> usize {
        self.columns.len()
    }

    /// The row of unknown `i`.
    pub fn row(&self, i: u32) -> u32 {
        self.row_of[i as usize]
    }

    /// The number of the entry of unknowns `i` and `j` among the values of a lower triangle, if the pattern has it.
    pub fn entry(&self, i: u32, j: u32) -> Option<u32> {
        let (i, j) = (self.row(i), self.row(j));
        let range = self.starts[i.max(j) as usize] as usize..self.starts[i.max(j) as usize + 1] as usize;
        let place = self.columns[range.clone()].binary_search(&i.min(j)).ok()?;
        Some((range.start + place) as u32)
    }

    /// The error of a matrix that is not positive definite; it names the system.
    pub fn singular(&self) -> Error {
        singular(self.what)
    }

    /// The grids of the first matrix, to be [updated](Self::update).
    pub fn grids(&self) -> Grids {
        self.first.clone()
    }

    /// The values of the first matrix.
    pub fn first_values(&self) -> &[f64] {
        &self.values
    }

    /// Makes `grids` those of the matrix with these `values`, by [`entry`](Self::entry).
    pub fn update(&self, grids: &mut Grids, values: &[f64]) {
        set_values(grids.finest(), &self.lower_of, values);
        grids.update(&self.prolongations);
    }

    /// Solves A x = b, by rows, with A of these `values`. `grids` are those of A or of a matrix near it. `x` holds a guess, and
    /// afterwards the solution: steps end once one lowers the square of the error, in the norm of A, by less than `tolerance` of what
    /// all have.
    ///
    /// `false` if the matrix is not positive definite.
    #[must_use]
    pub fn solve(&self, grids: &mut Grids, values: &[f64], b: &[[f64; 3]], x: &mut [[f64; 3]], tolerance: f64) -> bool {
        self.conjugate_gradients(grids, values, b, x, tolerance).is_some() || self.solve_directly(values, b, x)
    }

    /// The number of steps that the solution took, or `None` if it was not found.
    fn conjugate_gradients(
        &self,
        grids: &mut Grids,
        values: &[f64],
        b: &[[f64; 3]],
        x: &mut [[f64; 3]],
        tolerance: f64,
    ) -> Option<usize> {
        let mut product = vec![[0.0; 3]; b.len()];
        self.multiply(values, x, &mut product);
        let mut residual: Vec<[f64; 3]> =
            b.iter().zip(&product).map(|(b, q)| std::array::from_fn(|c| b[c] - q[c])).collect();
        let mut along = vec![[0.0; 3]; b.len()];
        let (mut before, mut decrease) = ([0.0; 3], [0.0; 3]);
        for step in 0..MAX_STEPS {
            let size = residual.iter().flatten().fold(0.0_f64, |most, r| most.max(r.abs()));
            if size == 0.0 {
                return Some(step);
            }
            let squares = grids.precondition(&self.prolongations, &residual, size);
            let share: [f64; 3] = std::array::from_fn(|c| if before[c] > 0.0 { squares[c] / before[c] } else { 0.0 });
            for (along, z) in along.iter_mut().zip(grids.solution()) {
                *along = std::array::from_fn(|c| size * f64::from(z[c]) + share[c] * along[c]);
            }
            self.multiply(values, &along, &mut product);
            let curvature = products(&along, &product);
            let mut is_done = true;
            let mut length = [0.0; 3];
            for c in 0..3 {
                if squares[c] == 0.0 {
                    continue;
                }
                length[c] = squares[c] / curvature[c];
                if !(length[c] > 0.0 && length[c].is_finite()) {
                    return None;
                }
                decrease[c] += length[c] * squares[c];
                is_done &= length[c] * squares[c] <= tolerance * decrease[c];
            }
            for (((x, r), along), q) in x.iter_mut().zip(&mut residual).zip(&along).zip(&product) {
                for c in 0..3 {
                    x[c] += length[c] * along[c];
                    r[c] -= length[c] * q[c];
                }
            }
            if is_done {
                return Some(step + 1);
            }
            before = squares;
        }
        None
    }

    fn solve_directly(&self, values: &[f64], b: &[[f64; 3]], x: &mut [[f64; 3]]) -> bool {
        let mut assembly = Assembly::new(self.size());
        for i in 0..self.size() {
            let row = self.starts[i] as usize..self.starts[i + 1] as usize;
            for (&j, value) in self.columns[row.clone()].iter().zip(&values[row]) {
                assembly.add(i, j as usize, *value);
            }
        }
        let Ok(cholesky) = Cholesky::new(assembly.finish(), self.what) else { return false };
        let mut columns: Vec<f64> = (0..3).flat_map(|c| b.iter().map(move |row| row[c])).collect();
        cholesky.solve_in_place(&mut columns, 3);
        for (c, column) in columns.chunks(self.size().max(1)).enumerate() {
            x.iter_mut().zip(column).for_each(|(x, &value)| x[c] = value);
        }
        true
    }

    /// y ← A x.
    fn multiply(&self, values: &[f64], x: &[[f64; 3]], y: &mut [[f64; 3]]) {
        for i in 0..self.size() {
            let range = self.starts[i] as usize..self.starts[i + 1] as usize - 1;
            let (at, diagonal) = (x[i], values[range.end]);
            let mut sum = at.map(|x| diagonal * x);
            for (&j, value) in self.columns[range.clone()].iter().zip(&values[range]) {
                let j = j as usize;
                for c in 0..3 {
                    sum[c] += value * x[j][c];
                    y[j][c] += value * at[c];
                }
            }
            y[i] = sum;
        }
    }
}

/// Products of columns.
fn products(a: &[[f64; 3]], b: &[[f64; 3]]) -> [f64; 3] {
    let mut sums = [0.0; 3];
    for (a, b) in a.iter().zip(b) {
        (0..3).for_each(|c| sums[c] += a[c] * b[c]);
    }
    sums
}

/// The lower triangle by rows, its unknowns in the order of `row_of`: starts, columns and values.
fn by_rows(lower: &CscMatrix<f64>, row_of: &[u32]) -> (Vec<u32>, Vec<u32>, Vec<f64>) {
    let n = lower.ncols();
    let pair = |i: usize, j: usize| {
        let (i, j) = (row_of[i], row_of[j]);
        (i.max(j), i.min(j))
    };
    let mut starts = vec![0; n + 1];
    lower.triplet_iter().for_each(|(i, j, _)| starts[pair(i, j).0 as usize + 1] += 1);
    (0..n).for_each(|i| starts[i + 1] += starts[i]);
    let mut next = starts.clone();
    let mut entries = vec![(0, 0.0); lower.nnz()];
    for (i, j, &value) in lower.triplet_iter() {
        let (row, column) = pair(i, j);
        let next = &mut next[row as usize];
        entries[*next as usize] = (column, value);
        *next += 1;
    }
    for i in 0..n {
        entries[starts[i] as usize..starts[i + 1] as usize].sort_unstable_by_key(|&(column, _)| column);
    }
    let (columns, values) = entries.into_iter().unzip();
    (starts, columns, values)
}

/// The whole matrix, of zeros, of a lower triangle by rows, and for each of its entries that of the lower triangle.
fn whole(starts: &[u32], columns: &[u32]) -> (Rows, Vec<u32>) {
    let n = starts.len() - 1;
    let mut all = vec![0; n + 1];
    for i in 0..n {
        for &j in &columns[starts[i] as usize..starts[i + 1] as usize] {
            all[i + 1] += 1;
            all[j as usize + 1] += u32::from(j as usize != i);
        }
    }
    (0..n).for_each(|i| all[i + 1] += all[i]);
    let mut next = all.clone();
    let count = all[n] as usize;
    let (mut places, mut lower_of) = (vec![0; count], vec![0; count]);
    let mut put = |row: usize, column: u32, entry: u32| {
        let next = &mut next[row];
        (places[*next as usize], lower_of[*next as usize]) = (column, entry);
        *next += 1;
    };
    // Rows ascend, and so do the columns of each: those of the lower triangle come before those of later rows.
    for i in 0..n {
        for k in starts[i]..starts[i + 1] {
            let j = columns[k as usize];
            put(i, j, k);
            if j as usize != i {
                put(j as usize, i as u32, k);
            }
        }
    }
    (Rows { starts: all, columns: places, values: vec![0.0; count] }, lower_of)
}

/// Sets the values of the whole matrix, relative to the largest: the preconditioner may be of any scale.
fn set_values(whole: &mut Rows, lower_of: &[u32], values: &[f64]) {
    let largest = values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    let scale = if largest > 0.0 { 1.0 / largest } else { 1.0 };
    whole.values.iter_mut().zip(lower_of).for_each(|(to, &from)| *to = (values[from as usize] * scale) as f32);
}
