//! What 32-bit numbers hold, for formats that have no others.

use mimesh_core::{Error, Result, mesh::Mesh};
use nalgebra::Point3;

/// The largest 32-bit number.
pub const MAX: f64 = f32::MAX as f64;

/// Checks that the texture coordinates of `mesh` are finite as 32-bit numbers, and so are `positions`; `format` is for the message.
///
/// # Errors
///
/// [`Error::Data`] with the first number that is not.
pub fn check(mesh: &Mesh, positions: &[Point3<f64>], format: &str) -> Result<()> {
    check_positions(positions, MAX, format)?;
    check_textures(mesh, format)
}

/// Checks that no coordinate is larger than `limit`.
///
/// # Errors
///
/// [`Error::Data`] with the first vertex that is.
pub fn check_positions(positions: &[Point3<f64>], limit: f64, format: &str) -> Result<()> {
    match positions.iter().position(|p| p.coords.amax() > limit) {
        None => Ok(()),
        Some(vertex) => Err(Error::data(
            format!(
                "vertex {vertex} (from 0) has coordinate {:e}, beyond the numbers of {format}",
                positions[vertex].coords.amax()
            ),
            "scale the mesh down, or write OBJ, whose numbers have no such limit",
        )),
    }
}

/// Checks that the texture coordinates of `mesh` are finite as 32-bit numbers.
///
/// # Errors
///
/// [`Error::Data`] with the first that is not.
pub fn check_textures(mesh: &Mesh, format: &str) -> Result<()> {
    let values = mesh.texture_coordinates.iter().flat_map(|textures| &textures.values);
    match values.flatten().find(|value| value.abs() > MAX) {
        None => Ok(()),
        Some(value) => Err(Error::data(
            format!("a texture coordinate is {value:e}, beyond the numbers of {format}"),
            "remove the texture coordinates from the target, or write OBJ, whose numbers have no such limit",
        )),
    }
}
