//! Discrete differential operators on triangle meshes.
//!
//! Signs: the Laplacian L is positive semi-definite. Units: positions are in the unit of the file, L has none, the mass M
//! is an area, gradients are per unit of length. Symmetric matrices hold their lower triangle. Triangles without area
//! ([`is_degenerate`]) contribute nothing, so every operator stays finite.

mod blend;
mod deformation_gradient;
mod gradient;
mod laplacian;
mod mass;
mod normals;
mod polar;
mod tetrahedron;

pub use blend::linear_blend;
pub use deformation_gradient::DeformationGradients;
pub use gradient::{Gradient, gradients};
pub use laplacian::cotangent_laplacian;
pub use mass::voronoi_mass;
pub use normals::vertex_normals;
pub use polar::{Polar, polar};
pub use tetrahedron::Tetrahedron;

use nalgebra::Point3;

/// Height of a triangle over its longest edge, relative to that edge: 0.87 if equilateral, 0 without area, NaN if a corner is.
pub fn relative_height(&[a, b, c]: &[Point3<f64>; 3]) -> f64 {
    let longest = (b - a).norm_squared().max((c - b).norm_squared()).max((a - c).norm_squared());
    if longest == 0.0 { 0.0 } else { (b - a).cross(&(c - a)).norm() / longest }
}

/// Whether a triangle is too thin for cotangents that keep half their digits: its [`relative_height`] is below 1e-8 or NaN.
pub fn is_degenerate(corners: &[Point3<f64>; 3]) -> bool {
    let has_area = relative_height(corners) > 1e-8;
    !has_area
}

#[cfg(test)]
mod tests;
