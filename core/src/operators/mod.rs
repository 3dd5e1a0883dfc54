//! Discrete differential operators on triangle meshes.
//!
//! Signs: the Laplacian L is positive semi-definite. Units: positions are in the unit of the file, L has none, the mass M
//! is an area, gradients are per unit of length. Symmetric matrices hold their lower triangle. Triangles without area
//! ([`is_degenerate`]) contribute nothing, so every operator stays finite.

mod deformation_gradient;
mod gradient;
mod laplacian;
mod mass;
mod normals;
mod polar;

pub use deformation_gradient::DeformationGradients;
pub use gradient::{Gradient, gradients};
pub use laplacian::cotangent_laplacian;
pub use mass::voronoi_mass;
pub use normals::vertex_normals;
pub use polar::{Polar, polar};

use nalgebra::Point3;

/// Whether a triangle is too thin to have a usable normal: twice its area is below 1e-10 of its longest edge squared.
pub fn is_degenerate(&[a, b, c]: &[Point3<f64>; 3]) -> bool {
    let longest = (b - a).norm_squared().max((c - b).norm_squared()).max((a - c).norm_squared());
    // Asked this way round, NaN counts as degenerate.
    let has_area = (b - a).cross(&(c - a)).norm() > 1e-10 * longest;
    !has_area
}

#[cfg(test)]
mod tests;
