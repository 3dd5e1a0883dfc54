//! The order of elimination and the pattern of the factor of a matrix, which faer finds.

use faer::{
    Side,
    sparse::{
        SparseColMatRef, SymbolicSparseColMatRef,
        linalg::{
            SupernodalThreshold,
            cholesky::{CholeskySymbolicParams, SymbolicCholesky, SymmetricOrdering, factorize_symbolic_cholesky},
        },
    },
};
use nalgebra_sparse::CscMatrix;

use crate::{Error, Result};

/// Analyses the pattern of a lower triangle, ordered by approximate minimum degree; `threshold` says whether columns of the factor are
/// gathered into dense blocks. `what` names the system in errors.
///
/// # Errors
///
/// [`Error::Other`] if there is no memory for it, or the factor has more entries than can be counted.
pub(super) fn analyse(
    lower: &CscMatrix<f64>,
    threshold: SupernodalThreshold,
    what: &'static str,
) -> Result<SymbolicCholesky<usize>> {
    let pattern = view(lower);
    symbolic(pattern.symbolic(), Side::Lower, SymmetricOrdering::Amd, threshold, what)
}

/// Like [`analyse`] with dense blocks, in the order in which the unknowns stand.
///
/// # Errors
///
/// The errors of [`analyse`].
pub(super) fn analyse_in_given_order(lower: &CscMatrix<f64>, what: &'static str) -> Result<SymbolicCholesky<usize>> {
    // Without a permutation faer reads the upper triangle.
    let upper = lower.pattern().transpose();
    let n = lower.ncols();
    let pattern = SymbolicSparseColMatRef::new_checked(n, n, upper.major_offsets(), None, upper.minor_indices());
    symbolic(pattern, Side::Upper, SymmetricOrdering::Identity, SupernodalThreshold::FORCE_SUPERNODAL, what)
}

fn symbolic(
    pattern: SymbolicSparseColMatRef<'_, usize>,
    side: Side,
    order: SymmetricOrdering<'_, usize>,
    supernodal_flop_ratio_threshold: SupernodalThreshold,
    what: &'static str,
) -> Result<SymbolicCholesky<usize>> {
    let parameters = CholeskySymbolicParams { supernodal_flop_ratio_threshold, ..Default::default() };
    factorize_symbolic_cholesky(pattern, side, order, parameters)
        .map_err(|error| Error::Other(format!("{what}: {error:?}").into()))
}

/// The same arrays as faer sees them; no copy.
pub(super) fn view(matrix: &CscMatrix<f64>) -> SparseColMatRef<'_, usize, f64> {
    let (starts, rows, values) = matrix.csc_data();
    let pattern = SymbolicSparseColMatRef::new_checked(matrix.nrows(), matrix.ncols(), starts, None, rows);
    SparseColMatRef::new(pattern, values)
}

/// The error of a matrix that is not positive definite.
pub(super) fn singular(what: &'static str) -> Error {
    Error::Singular { what, hint: "look for parts of the mesh without area or without any tie to the rest".into() }
}
