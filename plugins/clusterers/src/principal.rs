//! The same points seen along their principal axes.

use nalgebra::{DMatrix, SymmetricEigen};

/// Columns of `points` turned so that the first entries differ most from point to point and the last least; entries that do
/// not differ, to rounding, are left out. Distances between columns stay what they are.
///
/// Sums of squared entries then come near to their final value early, and a search for the nearest point can often stop there.
pub(crate) fn along_principal_axes(points: DMatrix<f64>) -> DMatrix<f64> {
    if points.is_empty() {
        return points;
    }
    let mut centred = points;
    let mean = centred.column_mean();
    centred.column_iter_mut().for_each(|mut column| column -= &mean);
    let eigen = SymmetricEigen::new(&centred * centred.transpose());
    let mut order: Vec<usize> = (0..eigen.eigenvalues.len()).collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]).then(a.cmp(&b)));
    let negligible = 1e-15 * eigen.eigenvalues.sum();
    order.retain(|&k| eigen.eigenvalues[k] > negligible);
    eigen.eigenvectors.select_columns(&order).transpose() * centred
}

#[cfg(test)]
mod tests {
    use mimesh_core::random::Random;

    use super::*;

    #[test]
    fn distances_stay_and_dimensions_without_extent_go() {
        let mut random = Random::new(4);
        // Twelve entries that depend on five.
        let (map, few) = (
            DMatrix::from_fn(12, 5, |_, _| random.between(-1.0, 1.0)),
            DMatrix::from_fn(5, 40, |_, _| random.between(-1.0, 1.0)),
        );
        let points = map * few;
        let turned = along_principal_axes(points.clone());
        assert_eq!(turned.shape(), (5, 40));
        for (a, b) in [(0, 1), (7, 30), (39, 2)] {
            let distance = |points: &DMatrix<f64>| (points.column(a) - points.column(b)).norm();
            assert!((distance(&points) - distance(&turned)).abs() < 1e-12, "rounding of a dozen entries of about 1");
        }
        let spread = |k: usize| turned.row(k).norm();
        assert!((1..5).all(|k| spread(k - 1) >= spread(k)));
    }
}
