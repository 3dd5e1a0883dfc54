use nalgebra::{DMatrix, Matrix3, Matrix3x4, Point3, Vector3};

use crate::{Error, Result};

/// Vertices that all handles move before the next ones, so that they stay in the cache.
const BLOCK: usize = 512;

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
    for (start, (posed, rest)) in (0..).step_by(BLOCK).zip(posed.chunks_mut(BLOCK).zip(rest.chunks(BLOCK))) {
        for (k, map) in transforms.iter().enumerate() {
            let column = &column(weights, k)[start..start + posed.len()];
            let (linear, shift): (_, Vector3<f64>) = (map.fixed_columns::<3>(0), map.column(3).into());
            for ((q, p), &w) in posed.iter_mut().zip(rest).zip(column) {
                // Bounded weights are 0 in most places.
                if w != 0.0 {
                    q.coords += (linear * p.coords + shift) * w;
                }
            }
        }
    }
    Ok(posed)
}

/// The linear part of the map of each vertex, Mᵢ = Σₖ Wᵢₖ Tₖ, where handle k has the affine map Tₖ.
///
/// # Errors
///
/// [`Error::Shape`] if the weights do not have a column for each map.
pub fn blended_maps(weights: &DMatrix<f64>, transforms: &[Matrix3x4<f64>]) -> Result<Vec<Matrix3<f64>>> {
    Error::check_shape("maps of handles (#H)", weights.ncols(), transforms.len())?;
    let mut maps = vec![Matrix3::zeros(); weights.nrows()];
    for (start, maps) in (0..).step_by(BLOCK).zip(maps.chunks_mut(BLOCK)) {
        for (k, transform) in transforms.iter().enumerate() {
            let linear: Matrix3<f64> = transform.fixed_columns::<3>(0).into();
            let column = &column(weights, k)[start..start + maps.len()];
            maps.iter_mut().zip(column).filter(|(_, w)| **w != 0.0).for_each(|(map, &w)| *map += linear * w);
        }
    }
    Ok(maps)
}

fn column(weights: &DMatrix<f64>, k: usize) -> &[f64] {
    let rows = weights.nrows();
    &weights.as_slice()[k * rows..(k + 1) * rows]
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

    #[test]
    fn blended_maps_act_as_the_blend_does_but_for_a_translation() {
        let count = 2 * BLOCK + 7;
        let weights = DMatrix::from_fn(count, 3, |v, k| if v % 3 == k { 0.0 } else { 0.1 * (v + k) as f64 });
        let maps: [Matrix3x4<f64>; 3] =
            std::array::from_fn(|k| Matrix3x4::from_fn(|r, c| (1 + r + 2 * c + 5 * k) as f64 * 0.1));
        let blended = blended_maps(&weights, &maps).expect("shapes fit");
        let at = |p: Point3<f64>| linear_blend(&weights, &maps, &vec![p; count]).expect("shapes fit");
        let (p, q) = (Point3::new(0.3, -0.2, 0.7), Point3::new(-0.4, 0.1, 0.2));
        for ((map, p_moved), q_moved) in blended.iter().zip(at(p)).zip(at(q)) {
            // Rounding of numbers up to 1e3.
            assert!((map * (p - q) - (p_moved - q_moved)).norm() < 1e-11);
        }
        assert!(blended_maps(&weights, &maps[..2]).is_err(), "a map is missing");
    }
}
