use nalgebra_sparse::{CooMatrix, CscMatrix};

use super::{Blocks, Cholesky, multifrontal::Multifrontal, symbolic::singular};
use crate::Result;

/// Minimises ½ xᵀ A x − bᵀ x where some unknowns are held at given values; factored once, solved often.
///
/// Fixed unknowns are eliminated, so that they are met exactly: A_ff x_f = b_f − A_fc x_c.
#[derive(Clone, Debug)]
pub struct FixedUnknowns {
    solver: Solver,
    /// For each unknown its number among the free ones, or among the fixed ones.
    place: Vec<Variable>,
    free: Vec<u32>,
    /// A_fc, #free × #fixed.
    coupling: CscMatrix<f64>,
    /// Values that were added to the diagonal, one a free unknown.
    added: Vec<f64>,
}

#[derive(Clone, Debug)]
enum Solver {
    Plain(Cholesky),
    /// The factorisation of `matrix`, a lower triangle.
    Fronts {
        factor: Multifrontal,
        matrix: CscMatrix<f64>,
        what: &'static str,
    },
}

impl Solver {
    fn fronts(matrix: CscMatrix<f64>, what: &'static str) -> Result<Self> {
        let mut factor = Multifrontal::new(&matrix, what)?;
        if !factor.factor(matrix.values()) {
            return Err(singular(what));
        }
        Ok(Self::Fronts { factor, matrix, what })
    }

    /// Factors again after `change` has set new values, given where each column starts, with its diagonal.
    fn refactor(&mut self, change: impl FnOnce(&mut [f64], &[usize])) -> Result<()> {
        match self {
            Self::Plain(cholesky) => {
                let starts = cholesky.column_starts().to_vec();
                cholesky.refactor(|values| change(values, &starts))
            }
            Self::Fronts { factor, matrix, what } => {
                let (starts, _, values) = matrix.csc_data_mut();
                change(values, starts);
                if factor.factor(values) { Ok(()) } else { Err(singular(what)) }
            }
        }
    }

    fn solve_in_place(&self, rhs: &mut [f64], columns: usize) {
        match self {
            Self::Plain(cholesky) => cholesky.solve_in_place(rhs, columns),
            Self::Fronts { factor, .. } => factor.solve_in_place(rhs),
        }
    }
}

#[derive(Clone, Copy, Debug)]
enum Variable {
    Free(usize),
    Fixed(usize),
}

impl FixedUnknowns {
    /// Factors A, given by its lower triangle, without the unknowns `fixed`; `what` names the system in errors.
    ///
    /// # Panics
    ///
    /// If an unknown is fixed twice or does not exist.
    ///
    /// # Errors
    ///
    /// [`Error::Singular`](crate::Error::Singular) if what remains is not positive definite.
    pub fn new(lower: &CscMatrix<f64>, fixed: &[u32], what: &'static str) -> Result<Self> {
        Self::with_solver(lower, fixed, |inner| Ok(Solver::Plain(Cholesky::new(inner, what)?)))
    }

    /// Like [`new`](Self::new), for a matrix whose diagonal will change often: a factorisation takes half the time, and it and
    /// solves use the threads that there are. Results differ by rounding, and do not depend on the number of threads.
    ///
    /// # Panics
    ///
    /// If an unknown is fixed twice or does not exist.
    ///
    /// # Errors
    ///
    /// The errors of [`new`](Self::new).
    pub fn for_refactoring(blocks: Blocks, fixed: &[u32], what: &'static str) -> Result<Self> {
        Self::with_solver(&blocks.finish(), fixed, |inner| match inner.ncols() {
            0 => Ok(Solver::Plain(Cholesky::new(inner, what)?)),
            _ => Solver::fronts(inner, what),
        })
    }

    fn with_solver(
        lower: &CscMatrix<f64>,
        fixed: &[u32],
        solver: impl FnOnce(CscMatrix<f64>) -> Result<Solver>,
    ) -> Result<Self> {
        let n = lower.ncols();
        let mut place = vec![Variable::Free(0); n];
        for (k, &i) in fixed.iter().enumerate() {
            assert!(matches!(place[i as usize], Variable::Free(_)), "unknown {i} is fixed twice");
            place[i as usize] = Variable::Fixed(k);
        }
        let mut free = Vec::with_capacity(n - fixed.len());
        for (i, place) in place.iter_mut().enumerate() {
            if let Variable::Free(number) = place {
                *number = free.len();
                free.push(i as u32);
            }
        }
        let (mut starts, mut rows, mut values) = (Vec::with_capacity(free.len() + 1), vec![], vec![]);
        let mut coupling = CooMatrix::new(free.len(), fixed.len());
        for (j, column) in lower.col_iter().enumerate() {
            if let Variable::Free(_) = place[j] {
                starts.push(rows.len());
            }
            for (&i, &value) in column.row_indices().iter().zip(column.values()).filter(|(i, _)| **i >= j) {
                match (place[i], place[j]) {
                    (Variable::Free(a), Variable::Free(_)) => {
                        rows.push(a);
                        values.push(value);
                    }
                    (Variable::Free(a), Variable::Fixed(b)) | (Variable::Fixed(b), Variable::Free(a)) => {
                        coupling.push(a, b, value)
                    }
                    (Variable::Fixed(_), Variable::Fixed(_)) => {}
                }
            }
        }
        starts.push(rows.len());
        // Numbers of free unknowns ascend as the unknowns do.
        let inner = CscMatrix::try_from_csc_data(free.len(), free.len(), starts, rows, values)
            .expect("entries of a matrix are sorted and each is there once");
        let solver = solver(inner)?;
        let added = vec![0.0; free.len()];
        Ok(Self { solver, place, free, coupling: CscMatrix::from(&coupling), added })
    }

    /// Adds `amount(i)` to the diagonal entry of each free unknown i in place of what the last call added, and factors again.
    ///
    /// The diagonal must be stored in full, as [`Assembly`](super::Assembly) does.
    ///
    /// # Errors
    ///
    /// [`Error::Singular`](crate::Error::Singular) if the matrix is not positive definite any more.
    pub fn set_diagonal(&mut self, amount: impl Fn(usize) -> f64) -> Result<()> {
        let (free, added) = (&self.free, &mut self.added);
        self.solver.refactor(|values, starts| {
            // The diagonal is the first entry of each column of a sorted lower triangle.
            for ((&i, &start), added) in free.iter().zip(starts).zip(added.iter_mut()) {
                let amount = amount(i as usize);
                values[start] += amount - *added;
                *added = amount;
            }
        })
    }

    /// The x that minimises, for `columns` right-hand sides b (column-major, n × columns).
    ///
    /// `values` are those of the fixed unknowns, in their order (column-major, #fixed × columns).
    pub fn solve(&self, b: &[f64], values: &[f64], columns: usize) -> Vec<f64> {
        let (n, inner, fixed) = (self.place.len(), self.free.len(), self.coupling.ncols());
        let mut rhs = Vec::with_capacity(inner * columns);
        for c in 0..columns {
            rhs.extend(self.free.iter().map(|&i| b[c * n + i as usize]));
            let column = &mut rhs[c * inner..];
            for (i, j, &a) in self.coupling.triplet_iter() {
                column[i] -= a * values[c * fixed + j];
            }
        }
        self.solver.solve_in_place(&mut rhs, columns);
        let mut x = Vec::with_capacity(n * columns);
        for c in 0..columns {
            x.extend(self.place.iter().map(|place| match *place {
                Variable::Free(a) => rhs[c * inner + a],
                Variable::Fixed(b) => values[c * fixed + b],
            }));
        }
        x
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};

    use super::*;
    use crate::linalg::{Assembly, OuterSum as _};

    /// A chain of springs: A = tridiagonal(−1, 2, −1) plus a little.
    fn chain(n: usize) -> CscMatrix<f64> {
        let mut assembly = Assembly::new(n);
        (0..n - 1).for_each(|i| assembly.add_outer(&[i as u32, i as u32 + 1], &[[1.0], [-1.0]], 1.0 + i as f64));
        assembly.finish()
    }

    #[test]
    fn a_chain_between_fixed_ends_is_the_dense_solution() {
        let n = 9;
        let system = FixedUnknowns::new(&chain(n), &[0, 8], "chain").unwrap();
        let b: Vec<f64> = (0..n).map(|i| (i as f64).sin()).collect();
        let x = system.solve(&b, &[1.0, 4.0], 1);
        assert_eq!((x[0], x[8]), (1.0, 4.0));
        let lower = DMatrix::from(&chain(n));
        let full = &lower + lower.transpose() - DMatrix::from_diagonal(&lower.diagonal());
        let gradient = full * DVector::from(x) - DVector::from(b);
        // n · eps times the largest stiffness (8).
        assert!(gradient.rows(1, 7).amax() < 1e-13, "gradient vanishes at free unknowns: {gradient}");
    }

    #[test]
    fn a_changed_diagonal_replaces_the_change_before() {
        let n = 6;
        let b = vec![1.0; n];
        let mut once = FixedUnknowns::new(&chain(n), &[0], "chain").unwrap();
        let mut twice = once.clone();
        once.set_diagonal(|i| i as f64).unwrap();
        twice.set_diagonal(|_| 100.0).unwrap();
        twice.set_diagonal(|i| i as f64).unwrap();
        let (a, b) = (once.solve(&b, &[0.0], 1), twice.solve(&b, &[0.0], 1));
        // 100 is added and taken away: its rounding remains.
        assert!(a.iter().zip(&b).all(|(x, y)| (x - y).abs() < 1e-12));
    }

    #[test]
    fn a_system_for_refactoring_has_the_same_solution_and_errors() {
        let n = 40;
        let links = |i: u32| ([i, i + 1, i + 3], [[1.0], [-2.0], [1.0]], 1.0 + f64::from(i));
        let (mut blocks, mut assembly) = (Blocks::new(n), Assembly::new(n));
        for (indices, rows, weight) in (0..n as u32 - 3).map(links) {
            blocks.add_outer(&indices, &rows, weight);
            assembly.add_outer(&indices, &rows, weight);
        }
        let loose = FixedUnknowns::for_refactoring(blocks.clone(), &[3], "chain").unwrap_err();
        assert_eq!(loose.to_string(), "chain is not positive definite");
        let fixed = [3, 20, 39];
        let mut plain = FixedUnknowns::new(&assembly.finish(), &fixed, "chain").unwrap();
        let mut fast = FixedUnknowns::for_refactoring(blocks, &fixed, "chain").unwrap();
        let b: Vec<f64> = (0..2 * n).map(|i| (i as f64).sin()).collect();
        for amount in [0.0, 3.0] {
            plain.set_diagonal(|i| amount * i as f64).unwrap();
            fast.set_diagonal(|i| amount * i as f64).unwrap();
            let values = [1.0, 4.0, -2.0, 0.5, 3.0, 7.0];
            let (x, y) = (plain.solve(&b, &values, 2), fast.solve(&b, &values, 2));
            // Rounding at a condition of some 1e6.
            assert!(x.iter().zip(&y).all(|(x, y)| (x - y).abs() < 1e-8), "{x:?}\n{y:?}");
        }
        let all: Vec<u32> = (0..n as u32).collect();
        let none = FixedUnknowns::for_refactoring(Blocks::new(n), &all, "nothing is free").unwrap();
        assert_eq!(none.solve(&vec![0.0; n], &b[..n], 1), &b[..n]);
    }

    #[test]
    fn a_chain_without_any_fixed_end_is_an_error_at_every_size() {
        for n in 2..200 {
            // Only rounding stands between its last pivot and 0.
            assert!(FixedUnknowns::new(&chain(n), &[], "chain").is_err(), "{n}");
            assert!(FixedUnknowns::new(&chain(n), &[0], "chain").is_ok(), "{n}");
        }
    }

    #[test]
    fn a_loose_system_is_an_error_and_not_nan() {
        let error = FixedUnknowns::new(&Assembly::new(3).finish(), &[0], "nothing").unwrap_err();
        assert_eq!(error.to_string(), "nothing is not positive definite");
    }
}
