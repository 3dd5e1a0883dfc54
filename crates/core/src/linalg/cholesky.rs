use std::{fmt, sync::Arc};

use dyn_stack::{MemBuffer, MemStack};
use faer::{
    Conj, MatMut, Par, Side,
    sparse::linalg::{
        SupernodalThreshold,
        cholesky::{
            LltRef, SymbolicCholesky, SymbolicCholeskyRaw,
            supernodal::{SupernodalLltRef, factorize_supernodal_numeric_llt},
        },
    },
};
use nalgebra_sparse::CscMatrix;

use super::{
    residual::subtract_product,
    symbolic::{analyse, analyse_in_given_order, singular, view},
};
use crate::{
    Error, Result,
    memory::{bytes_of, need},
};

/// A sparse Cholesky factorisation A = L Lᵀ, ordered by approximate minimum degree.
///
/// The symbolic part depends on the pattern alone and is shared by clones and by [`refactor`](Self::refactor).
#[derive(Clone)]
pub struct Cholesky {
    symbolic: Arc<SymbolicCholesky<usize>>,
    factor: Vec<f64>,
    /// The lower triangle, for residuals.
    matrix: CscMatrix<f64>,
    /// The lower triangle in the order of the factor, where the columns of the factor are gathered into blocks.
    reordered: Option<Reordered>,
    what: &'static str,
}

/// A lower triangle in another order of rows and columns, which faer would make anew at every factorisation.
#[derive(Clone)]
struct Reordered {
    matrix: CscMatrix<f64>,
    /// For each of its values the place among the values of the original.
    places: Arc<[usize]>,
}

impl Reordered {
    /// `inverse` gives the new row of each row.
    fn new(lower: &CscMatrix<f64>, inverse: &[usize]) -> Self {
        let n = lower.ncols();
        let entry = |(place, (i, j, _)): (usize, (usize, usize, &f64))| {
            let (i, j) = (inverse[i], inverse[j]);
            (i.min(j), i.max(j), place)
        };
        let mut entries: Vec<_> = lower.triplet_iter().enumerate().map(entry).collect();
        entries.sort_unstable();
        let mut starts = vec![0; n + 1];
        entries.iter().for_each(|&(j, ..)| starts[j + 1] += 1);
        (0..n).for_each(|j| starts[j + 1] += starts[j]);
        let rows = entries.iter().map(|e| e.1).collect();
        let places: Arc<[usize]> = entries.iter().map(|e| e.2).collect();
        let matrix = CscMatrix::try_from_csc_data(n, n, starts, rows, vec![0.0; places.len()])
            .expect("each entry of a lower triangle is there once");
        Self { matrix, places }
    }

    /// Takes over the values of the original.
    fn update(&mut self, values: &[f64]) {
        self.matrix.values_mut().iter_mut().zip(&*self.places).for_each(|(value, &place)| *value = values[place]);
    }
}

impl Cholesky {
    /// Factors the symmetric matrix whose lower triangle is `lower`; entries above the diagonal are not looked at.
    ///
    /// `what` names the system in errors.
    ///
    /// # Errors
    ///
    /// [`Error::Singular`] if the matrix is not positive definite.
    pub fn new(lower: CscMatrix<f64>, what: &'static str) -> Result<Self> {
        Self::with_threshold(lower, what, SupernodalThreshold::AUTO)
    }

    /// Like [`new`](Self::new), for a matrix whose values will change often: columns are gathered into dense blocks whatever the
    /// size.
    ///
    /// On bilaplacians of 2,000 and 13,000 vertices a factorisation took 0.7 and 0.4 of the time, and a solve as long or 1.3
    /// times as long.
    ///
    /// # Errors
    ///
    /// The errors of [`new`](Self::new).
    pub fn for_refactoring(lower: CscMatrix<f64>, what: &'static str) -> Result<Self> {
        Self::with_threshold(lower, what, SupernodalThreshold::FORCE_SUPERNODAL)
    }

    /// Like [`for_refactoring`](Self::for_refactoring), with unknowns eliminated in the order they stand in: for parts of a matrix
    /// whose own [`order`](Self::order) is known, since a part of a good order is a good order.
    ///
    /// Dense blocks are columns that follow each other in a postorder of the elimination tree; in other orders they are small.
    ///
    /// # Errors
    ///
    /// The errors of [`new`](Self::new).
    pub fn in_given_order(lower: CscMatrix<f64>, what: &'static str) -> Result<Self> {
        let symbolic = analyse_in_given_order(&lower, what)?;
        need(what, bytes_of::<f64>(symbolic.len_val()))?;
        let factor = vec![0.0; symbolic.len_val()];
        let mut result = Self { symbolic: Arc::new(symbolic), factor, matrix: lower, reordered: None, what };
        result.factor_numerically()?;
        Ok(result)
    }

    fn with_threshold(lower: CscMatrix<f64>, what: &'static str, threshold: SupernodalThreshold) -> Result<Self> {
        let symbolic = analyse(&lower, threshold, what)?;
        need(what, bytes_of::<f64>(symbolic.len_val()))?;
        let factor = vec![0.0; symbolic.len_val()];
        let reordered = match (symbolic.raw(), symbolic.perm()) {
            (SymbolicCholeskyRaw::Supernodal(_), Some(order)) => Some(Reordered::new(&lower, order.arrays().1)),
            _ => None,
        };
        let mut result = Self { symbolic: Arc::new(symbolic), factor, matrix: lower, reordered, what };
        result.factor_numerically()?;
        Ok(result)
    }

    /// Factors again after `change` has set new values on the same pattern (lower triangle, CSC order).
    ///
    /// # Errors
    ///
    /// [`Error::Singular`] if the matrix is not positive definite any more.
    pub fn refactor(&mut self, change: impl FnOnce(&mut [f64])) -> Result<()> {
        change(self.matrix.values_mut());
        self.factor_numerically()
    }

    /// The factorisation of another matrix of the same pattern (lower triangle, CSC order), sharing the symbolic part.
    ///
    /// # Errors
    ///
    /// [`Error::Singular`] if that matrix is not positive definite.
    pub fn with_values(&self, values: &[f64]) -> Result<Self> {
        need(self.what, bytes_of::<f64>(self.factor.len()))?;
        let mut matrix = self.matrix.clone();
        matrix.values_mut().copy_from_slice(values);
        let factor = vec![0.0; self.factor.len()];
        let mut result = Self {
            symbolic: self.symbolic.clone(),
            factor,
            matrix,
            reordered: self.reordered.clone(),
            what: self.what,
        };
        result.factor_numerically()?;
        Ok(result)
    }

    /// Solves A x = b in place for `columns` right-hand sides, stored one after another (column-major, n × columns).
    ///
    /// # Panics
    ///
    /// If `rhs` is not n × columns long.
    pub fn solve_in_place(&self, rhs: &mut [f64], columns: usize) {
        let n = self.size();
        assert_eq!(rhs.len(), n * columns, "right-hand sides of {n} rows");
        let mut memory = MemBuffer::new(self.symbolic.solve_in_place_scratch::<f64>(columns, Par::Seq));
        LltRef::new(&self.symbolic, &self.factor).solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(rhs, n, columns),
            Par::Seq,
            MemStack::new(&mut memory),
        );
    }

    /// Like [`solve_in_place`](Self::solve_in_place), with one step of iterative refinement.
    ///
    /// Worth its price where A squares a badly conditioned operator, as a bilaplacian does.
    ///
    /// # Panics
    ///
    /// If `rhs` is not n × columns long.
    pub fn solve_refined_in_place(&self, rhs: &mut [f64], columns: usize) {
        let mut residual = rhs.to_vec();
        self.solve_in_place(rhs, columns);
        for (r, x) in residual.chunks_mut(self.size()).zip(rhs.chunks(self.size())) {
            subtract_product(&self.matrix, x, r);
        }
        self.solve_in_place(&mut residual, columns);
        rhs.iter_mut().zip(&residual).for_each(|(x, dx)| *x += dx);
    }

    /// n.
    pub fn size(&self) -> usize {
        self.matrix.ncols()
    }

    /// The number of entries of the lower triangle of A.
    pub fn entry_count(&self) -> usize {
        self.matrix.nnz()
    }

    /// The unknowns in the order in which they are eliminated.
    pub fn order(&self) -> Vec<usize> {
        self.symbolic.perm().map_or_else(|| (0..self.size()).collect(), |order| order.arrays().0.to_vec())
    }

    /// Where each column of the lower triangle starts among its values.
    pub(super) fn column_starts(&self) -> &[usize] {
        self.matrix.col_offsets()
    }

    fn factor_numerically(&mut self) -> Result<()> {
        let symbolic = &self.symbolic;
        let mut memory = MemBuffer::new(symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default()));
        let memory = MemStack::new(&mut memory);
        let factored = match (symbolic.raw(), &mut self.reordered) {
            (SymbolicCholeskyRaw::Supernodal(symbolic), reordered) => {
                let lower = match reordered {
                    Some(reordered) => {
                        reordered.update(self.matrix.values());
                        view(&reordered.matrix)
                    }
                    None => view(&self.matrix),
                };
                let (regularisation, parameters) = Default::default();
                let factor = &mut self.factor;
                factorize_supernodal_numeric_llt(factor, lower, regularisation, symbolic, Par::Seq, memory, parameters)
                    .is_ok()
            }
            _ => {
                let lower = view(&self.matrix);
                let (regularisation, parameters) = Default::default();
                let factor = &mut self.factor;
                symbolic
                    .factorize_numeric_llt(factor, lower, Side::Lower, regularisation, Par::Seq, memory, parameters)
                    .is_ok()
            }
        };
        if !factored {
            return Err(singular(self.what));
        }
        // A semi-definite matrix may leave a pivot of rounding instead of none.
        let smallest = 16.0 * f64::EPSILON * (self.size() as f64).sqrt();
        let (starts, _, values) = self.matrix.csc_data();
        // The diagonal comes first in each column of a sorted lower triangle.
        if self.pivots().into_iter().all(|(j, pivot)| pivot > smallest * values[starts[j]]) {
            Ok(())
        } else {
            Err(singular(self.what))
        }
    }

    /// The error of a matrix that is not positive definite; it names the system.
    pub fn singular(&self) -> Error {
        singular(self.what)
    }

    /// For each column of the factor the row of the matrix it eliminates and its pivot, the square of the diagonal of L.
    fn pivots(&self) -> Vec<(usize, f64)> {
        let row = |k: usize| self.symbolic.perm().map_or(k, |perm| perm.arrays().0[k]);
        match self.symbolic.raw() {
            SymbolicCholeskyRaw::Simplicial(symbolic) => {
                let starts = &symbolic.col_ptr()[..symbolic.ncols()];
                starts.iter().enumerate().map(|(k, &start)| (row(k), self.factor[start].powi(2))).collect()
            }
            SymbolicCholeskyRaw::Supernodal(symbolic) => {
                let factor = SupernodalLltRef::new(symbolic, &self.factor);
                let mut pivots = Vec::with_capacity(self.size());
                for s in 0..symbolic.n_supernodes() {
                    let supernode = factor.supernode(s);
                    let values = supernode.val();
                    let columns = symbolic.supernode_end()[s] - symbolic.supernode_begin()[s];
                    pivots.extend((0..columns).map(|k| (row(supernode.start() + k), values[(k, k)].powi(2))));
                }
                pivots
            }
        }
    }
}

impl fmt::Debug for Cholesky {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Cholesky({}: n = {}, {} entries)", self.what, self.size(), self.factor.len())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::Assembly;

    #[test]
    fn dense_blocks_give_the_same_solution() {
        let n = 60;
        let mut assembly = Assembly::new(n);
        (0..n as u32 - 2).for_each(|i| assembly.add_outer(&[i, i + 1, i + 2], &[[1.0], [-2.0], [1.0]], 1.0));
        (0..n).for_each(|i| assembly.add(i, i, 0.1));
        let lower = assembly.finish();
        let plain = Cholesky::new(lower.clone(), "the test").unwrap();
        let mut blocks = Cholesky::for_refactoring(lower.clone(), "the test").unwrap();
        let right: Vec<f64> = (0..n).map(|i| (i as f64).sin()).collect();
        let solve = |cholesky: &Cholesky| {
            let mut x = right.clone();
            cholesky.solve_in_place(&mut x, 1);
            x
        };
        let far = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
        // Rounding at a condition of 160.
        assert!(far(&solve(&plain), &solve(&blocks)) < 1e-12);
        blocks.refactor(|values| values.iter_mut().for_each(|v| *v *= 2.0)).unwrap();
        let halved: Vec<f64> = solve(&plain).iter().map(|x| x / 2.0).collect();
        assert!(far(&halved, &solve(&blocks)) < 1e-12);
        let given = Cholesky::in_given_order(lower, "the test").unwrap();
        assert!(far(&solve(&plain), &solve(&given)) < 1e-12);
        assert!(given.order().into_iter().eq(0..n) && !blocks.order().into_iter().eq(0..n));
    }
}
