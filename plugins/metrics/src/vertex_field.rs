//! Values at vertices, for pictures.

use mimesh_core::mesh::Surface;
use nalgebra::Point3;

/// Values at the vertices of a mesh, from `values` (#V) at those of its surface; NaN where nothing is known, as at vertices that no
/// face uses.
pub fn on_mesh(surface: &Surface, values: &[f64]) -> Vec<f64> {
    surface.vertex_of.iter().map(|v| v.map_or(f64::NAN, |v| values[v as usize])).collect()
}

/// Raises the value at each of `vertices` to `value` if it is smaller or NaN.
pub fn raise(values: &mut [f64], vertices: &[u32], value: f64) {
    for &v in vertices {
        // f64::max prefers a number to NaN.
        values[v as usize] = values[v as usize].max(value);
    }
}

/// Whether all coordinates are finite.
pub fn is_finite(p: &Point3<f64>) -> bool {
    p.coords.iter().all(|x| x.is_finite())
}
