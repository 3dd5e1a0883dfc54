use nalgebra::Point3;

use crate::{Error, Result};

/// Coordinates are smaller than this: powers of lengths up to the sixth are finite then, as squares of areas and volumes are.
pub const MAX_COORDINATE: f64 = 1e50;

/// Checks that coordinates are numbers to compute with: finite, and smaller than [`MAX_COORDINATE`].
///
/// # Errors
///
/// [`Error::Data`] that names the first vertex that is not, counted from 0.
pub fn check_finite(positions: &[Point3<f64>]) -> Result<()> {
    match positions.iter().position(|p| !p.coords.iter().all(|x| x.abs() < MAX_COORDINATE)) {
        None => Ok(()),
        Some(vertex) => {
            let [x, y, z]: [f64; 3] = positions[vertex].into();
            let (expected, hint) = if x.is_finite() && y.is_finite() && z.is_finite() {
                (
                    "numbers below 1e50",
                    "scale the mesh down: the squares of such lengths are beyond what can be computed",
                )
            } else {
                ("finite numbers", "repair the file or export it again without NaN and infinity")
            };
            let [x, y, z] = [x, y, z].map(short);
            Err(Error::data(format!("vertex {vertex} (from 0) has coordinates {x} {y} {z}: expected {expected}"), hint))
        }
    }
}

/// A number for messages: without hundreds of digits.
fn short(x: f64) -> String {
    if x.is_finite() && x.abs() >= 1e16 { format!("{x:e}") } else { format!("{x}") }
}

/// Smallest and largest corner of the box around `positions`; both at the origin if there are none.
pub fn bounding_box(positions: &[Point3<f64>]) -> (Point3<f64>, Point3<f64>) {
    let Some(&first) = positions.first() else { return (Point3::origin(), Point3::origin()) };
    positions.iter().fold((first, first), |(low, high), p| (low.inf(p), high.sup(p)))
}

/// Length of the diagonal of the box around `positions`.
pub fn diagonal(positions: &[Point3<f64>]) -> f64 {
    let (low, high) = bounding_box(positions);
    (high - low).norm()
}

/// For each of `vertex_count` vertices whether a polygon of three corners or more uses it.
///
/// Vertices that no face uses are construction points, or remains of an export, and may lie anywhere. So they never set a scale.
pub fn used_by_faces<'a>(vertex_count: usize, polygons: impl Iterator<Item = &'a [u32]>) -> Vec<bool> {
    let mut used = vec![false; vertex_count];
    polygons.filter(|corners| corners.len() >= 3).flatten().for_each(|&v| used[v as usize] = true);
    used
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_whose_squares_overflow_are_told_from_nan() {
        let error = |x: f64| check_finite(&[Point3::origin(), Point3::new(0.0, x, 1.0)]).unwrap_err().to_string();
        assert_eq!(error(f64::NAN), "vertex 1 (from 0) has coordinates 0 NaN 1: expected finite numbers");
        assert_eq!(error(-1e308), "vertex 1 (from 0) has coordinates 0 -1e308 1: expected numbers below 1e50");
        assert!(check_finite(&[Point3::new(9e49, -9e49, 0.0)]).is_ok());
        assert!(diagonal(&[Point3::new(9e49, -9e49, 0.0), Point3::new(-9e49, 9e49, 9e49)]).powi(6).is_finite());
    }
}
