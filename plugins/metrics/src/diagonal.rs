//! The lengths that statistics are relative to.

use mimesh_core::{Error, Result, mesh::Surface};

/// The diagonal of the target at rest, in the unit of its file; stray vertices do not matter.
///
/// # Errors
///
/// [`Error::Data`] if it is 0 or not finite.
pub fn of_target(surface: &Surface) -> Result<f64> {
    checked(surface.diagonal(), "rest mesh", RESULT_HINT)
}

/// The diagonal of the source at rest, in the unit of its file; stray vertices do not matter.
///
/// # Errors
///
/// [`Error::Data`] if it is 0 or not finite.
pub fn of_source(source: &Surface) -> Result<f64> {
    checked(source.diagonal(), "source at rest", "give the rest mesh that the poses belong to")
}

const RESULT_HINT: &str = "give the rest mesh that the result was made from";

fn checked(diagonal: f64, mesh: &str, hint: &str) -> Result<f64> {
    if diagonal.is_finite() && diagonal > 0.0 {
        return Ok(diagonal);
    }
    Err(Error::data(
        format!("the {mesh} has a bounding box of diagonal {diagonal}: expected a finite length above 0"),
        format!("statistics are given relative to this length; {hint}"),
    ))
}
