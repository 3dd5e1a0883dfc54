use nalgebra::{DMatrix, Matrix3x4, Point3, Vector3};

use crate::{Error, Result};

/// Linear blend: qᵢ = Σₖ Wᵢₖ Tₖ [pᵢ; 1], #V (eq. 2 of Yang et al. 2018).
///
/// `weights` is W (#V × #H), `transforms` is T, a 3 × 4 map a handle, and `rest` holds the pᵢ.
///
/// # Errors
///
/// [`Error::Shape`] if W does not have a row a vertex and a column a map.
pub fn linear_blend(
    weights: &DMatrix<f64>,
    transforms: &[Matrix3x4<f64>],
    rest: &[Point3<f64>],
) -> Result<Vec<Point3<f64>>> {
    Error::check_shape("rows of the weights (#V)", rest.len(), weights.nrows())?;
    Error::check_shape("maps of handles (#H)", weights.ncols(), transforms.len())?;
    let mut posed = vec![Point3::origin(); rest.len()];
    for (column, map) in weights.column_iter().zip(transforms) {
        let (linear, shift): (_, Vector3<f64>) = (map.fixed_columns::<3>(0), map.column(3).into());
        for ((q, p), &w) in posed.iter_mut().zip(rest).zip(column.iter()) {
            // Bounded weights are 0 in most places.
            if w != 0.0 {
                q.coords += (linear * p.coords + shift) * w;
            }
        }
    }
    Ok(posed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_vertex_between_two_handles_goes_to_the_mean_of_where_they_would_take_it() {
        let still = Matrix3x4::identity();
        let mut up = Matrix3x4::identity() * 2.0;
        up[(1, 3)] = 4.0;
        let weights = DMatrix::from_row_slice(2, 2, &[0.5, 0.5, 1.0, 0.0]);
        let rest = [Point3::new(1.0, 2.0, 3.0), Point3::new(5.0, 6.0, 7.0)];
        let posed = linear_blend(&weights, &[still, up], &rest).expect("shapes fit");
        assert_eq!(posed, [Point3::new(1.5, 5.0, 4.5), rest[1]]);
        assert!(linear_blend(&weights, &[still], &rest).is_err(), "a map is missing");
    }
}
