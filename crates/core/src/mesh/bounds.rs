use nalgebra::Point3;

use crate::{Error, Result};

/// Checks that coordinates are finite.
///
/// # Errors
///
/// [`Error::Data`] that names the first vertex that is not, counted from 0.
pub fn check_finite(positions: &[Point3<f64>]) -> Result<()> {
    match positions.iter().position(|p| !p.coords.iter().all(|x| x.is_finite())) {
        None => Ok(()),
        Some(vertex) => {
            let p = positions[vertex];
            Err(Error::data(
                format!("vertex {vertex} (from 0) has coordinates {} {} {}: expected finite numbers", p.x, p.y, p.z),
                "repair the file or export it again without NaN and infinity",
            ))
        }
    }
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
