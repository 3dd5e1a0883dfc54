//! Residuals of symmetric matrices.

use nalgebra_sparse::CscMatrix;

/// r −= A x, with A of the lower triangle `lower`; entries above the diagonal are not looked at.
pub(super) fn subtract_product(lower: &CscMatrix<f64>, x: &[f64], r: &mut [f64]) {
    for (j, column) in lower.col_iter().enumerate() {
        for (&i, &value) in column.row_indices().iter().zip(column.values()) {
            if i >= j {
                r[i] -= value * x[j];
            }
            if i > j {
                r[j] -= value * x[i];
            }
        }
    }
}
