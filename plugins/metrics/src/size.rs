//! The lengths that figures are relative to.

use mimesh_core::{
    Error, Result,
    mesh::{Mesh, Surface},
};
use nalgebra::Point3;

/// The diagonal of the target's bounding box at rest.
///
/// # Errors
///
/// [`Error::Data`] if it has no length.
pub fn of_rest(rest: &Mesh) -> Result<f64> {
    checked(rest.diagonal(), "rest mesh", "give the rest mesh that the result was made from")
}

/// The diagonal of the source's bounding box at rest.
///
/// # Errors
///
/// [`Error::Data`] if it has no length.
pub fn of_source(source: &Surface) -> Result<f64> {
    checked(source.diagonal(), "source at rest", "give the rest mesh that the poses belong to")
}

fn checked(diagonal: f64, what: &str, way_out: &str) -> Result<f64> {
    if diagonal.is_finite() && diagonal > 0.0 {
        return Ok(diagonal);
    }
    Err(Error::data(
        format!("the {what} has a bounding box of diagonal {diagonal}: expected a finite length above 0"),
        format!("figures are given relative to this length; {way_out}"),
    ))
}

/// Whether all coordinates are finite.
pub fn is_finite(p: &Point3<f64>) -> bool {
    p.coords.iter().all(|x| x.is_finite())
}

/// Values of the vertices of a surface as a field of its mesh; NaN stays where nothing is known.
pub fn field(surface: &Surface, values: &[f64]) -> Vec<f64> {
    surface.vertex_of.iter().map(|&v| values[v as usize]).collect()
}

/// Puts the larger of what is there and `value` at each of `vertices`; NaN gives way.
pub fn raise(field: &mut [f64], vertices: &[u32], value: f64) {
    for &v in vertices {
        // f64::max prefers a number to NaN.
        field[v as usize] = field[v as usize].max(value);
    }
}
