//! A V-cycle: smoothing by Gauss and Seidel on every level, forwards on the way down and backwards on the way up, so that it is
//! symmetric.

use super::rows::{Row, Rows};

/// A matrix of at most so many rows is not coarsened, but factored.
pub(super) const COARSEST: usize = 600;

/// Takes solutions from a coarse level to a fine one, and residuals back.
#[derive(Clone, Debug)]
pub(super) struct Prolongation {
    to_fine: Rows,
    to_coarse: Rows,
}

impl Prolongation {
    /// That of P, with `count` columns.
    pub fn new(to_fine: Rows, count: usize) -> Self {
        Self { to_coarse: to_fine.transposed(count), to_fine }
    }

    /// Pᵀ A P.
    pub fn coarse(&self, matrix: &Rows) -> Rows {
        let count = self.to_coarse.count();
        let mut coarse = self.to_coarse.times(&matrix.times(&self.to_fine, count), count);
        coarse.sort();
        coarse
    }
}

/// The levels of one matrix, and room to solve with them.
#[derive(Clone, Debug)]
pub struct Grids {
    levels: Vec<Level>,
    /// The dense factor of the coarsest matrix, by rows; empty if that is too large.
    factor: Vec<f64>,
}

#[derive(Clone, Debug)]
struct Level {
    matrix: Rows,
    inverse_diagonal: Vec<f32>,
    right: Vec<Row>,
    x: Vec<Row>,
    residual: Vec<Row>,
}

impl Level {
    fn new(matrix: Rows) -> Self {
        let zeros = || vec![[0.0; 4]; matrix.count()];
        Self { inverse_diagonal: matrix.inverse_diagonal(), right: zeros(), x: zeros(), residual: zeros(), matrix }
    }

    /// x from 0, and what it leaves.
    fn smooth_forwards(&mut self) {
        let Self { matrix, inverse_diagonal, right, x, residual } = self;
        for i in 0..matrix.count() {
            let before = matrix.row(i).take_while(|&(j, _)| j < i);
            x[i] = matrix.subtract_row(right[i], before, x).map(|sum| sum * inverse_diagonal[i]);
        }
        // Rows up to the diagonal are met; others were 0 when they were looked at.
        for (i, residual) in residual.iter_mut().enumerate() {
            let behind = matrix.row(i).rev().take_while(|&(j, _)| j > i);
            *residual = matrix.subtract_row([0.0; 4], behind, x);
        }
    }

    fn smooth_backwards(&mut self) {
        let Self { matrix, inverse_diagonal, right, x, .. } = self;
        for i in (0..matrix.count()).rev() {
            let others = matrix.row(i).filter(|&(j, _)| j != i);
            x[i] = matrix.subtract_row(right[i], others, x).map(|sum| sum * inverse_diagonal[i]);
        }
    }
}

impl Grids {
    pub(super) fn new(matrices: Vec<Rows>) -> Self {
        let levels: Vec<Level> = matrices.into_iter().map(Level::new).collect();
        let factor = factor(&levels[levels.len() - 1].matrix);
        Self { levels, factor }
    }

    /// The matrix of the finest level.
    pub(super) fn finest(&mut self) -> &mut Rows {
        &mut self.levels[0].matrix
    }

    /// Computes the coarse matrices of the finest one.
    pub(super) fn update(&mut self, prolongations: &[Prolongation]) {
        for (l, prolongation) in prolongations.iter().enumerate() {
            self.levels[l].inverse_diagonal = self.levels[l].matrix.inverse_diagonal();
            self.levels[l + 1].matrix = prolongation.coarse(&self.levels[l].matrix);
        }
        let last = self.levels.len() - 1;
        self.levels[last].inverse_diagonal = self.levels[last].matrix.inverse_diagonal();
        self.factor = factor(&self.levels[last].matrix);
    }

    /// z for `residual` over `size`, and the products of residual and size · z. The [`solution`](Self::solution) is z.
    pub(super) fn precondition(
        &mut self,
        prolongations: &[Prolongation],
        residual: &[[f64; 3]],
        size: f64,
    ) -> [f64; 3] {
        let scale = 1.0 / size;
        for (to, r) in self.levels[0].right.iter_mut().zip(residual) {
            *to = [(r[0] * scale) as f32, (r[1] * scale) as f32, (r[2] * scale) as f32, 0.0];
        }
        self.cycle(prolongations);
        let mut products = [0.0; 3];
        for (r, z) in residual.iter().zip(self.solution()) {
            (0..3).for_each(|c| products[c] += r[c] * size * f64::from(z[c]));
        }
        products
    }

    /// The last solution on the finest level.
    pub(super) fn solution(&self) -> &[Row] {
        &self.levels[0].x
    }

    fn cycle(&mut self, prolongations: &[Prolongation]) {
        let last = prolongations.len();
        for (l, Prolongation { to_coarse, .. }) in prolongations.iter().enumerate() {
            self.levels[l].smooth_forwards();
            let (fine, coarse) = self.levels.split_at_mut(l + 1);
            to_coarse.multiply(&fine[l].residual, &mut coarse[0].right);
        }
        if self.factor.is_empty() {
            self.levels[last].smooth_forwards();
            self.levels[last].smooth_backwards();
        } else {
            let Level { right, x, .. } = &mut self.levels[last];
            solve(&self.factor, right, x);
        }
        for (l, Prolongation { to_fine, .. }) in prolongations.iter().enumerate().rev() {
            let (fine, coarse) = self.levels.split_at_mut(l + 1);
            for (i, x) in fine[l].x.iter_mut().enumerate() {
                for (j, value) in to_fine.row(i) {
                    (0..4).for_each(|c| x[c] += value * coarse[0].x[j][c]);
                }
            }
            fine[l].smooth_backwards();
        }
    }
}

/// The dense Cholesky factor of a small matrix, by rows; empty for a large one.
fn factor(matrix: &Rows) -> Vec<f64> {
    let n = matrix.count();
    if n > COARSEST {
        return vec![];
    }
    let mut l = vec![0.0; n * n];
    for i in 0..n {
        matrix.row(i).filter(|&(j, _)| j <= i).for_each(|(j, value)| l[i * n + j] = f64::from(value));
    }
    for i in 0..n {
        let diagonal = l[i * n + i];
        for j in 0..=i {
            let (a, b) = (&l[i * n..i * n + j], &l[j * n..j * n + j]);
            let rest = l[i * n + j] - a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            l[i * n + j] = match j == i {
                // What rounding has left of a pivot draws to 0.
                true => rest.max(1e-6 * diagonal).max(f64::MIN_POSITIVE).sqrt(),
                false => rest / l[j * n + j],
            };
        }
    }
    l
}

/// x for the dense factor `l`.
fn solve(l: &[f64], right: &[Row], x: &mut [Row]) {
    let n = right.len();
    let mut y: Vec<[f64; 4]> = right.iter().map(|row| row.map(f64::from)).collect();
    for i in 0..n {
        let mut sum = y[i];
        for (factor, y) in l[i * n..i * n + i].iter().zip(&y) {
            (0..4).for_each(|c| sum[c] -= factor * y[c]);
        }
        y[i] = sum.map(|sum| sum / l[i * n + i]);
    }
    for i in (0..n).rev() {
        y[i] = y[i].map(|y| y / l[i * n + i]);
        let at = y[i];
        for (factor, y) in l[i * n..i * n + i].iter().zip(&mut y) {
            (0..4).for_each(|c| y[c] -= factor * at[c]);
        }
    }
    x.iter_mut().zip(y).for_each(|(x, y)| *x = y.map(|y| y as f32));
}
