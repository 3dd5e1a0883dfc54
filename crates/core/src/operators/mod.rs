//! Discrete differential operators on triangle meshes.
//!
//! Signs: the Laplacian L is positive semi-definite. Units: positions are in the unit of the file, L has none, the mass M
//! is an area, gradients are per unit of length. Symmetric matrices hold their lower triangle. Triangles without area
//! ([`is_degenerate`]) contribute nothing, so every operator stays finite.

mod blend;
mod deformation_gradient;
mod degenerate;
mod gradient;
mod laplacian;
mod mass;
mod newton;
mod normals;
mod polar;
mod rotation;
mod tetrahedron;
mod untouched;

pub use blend::{blended_maps, linear_blend};
pub use deformation_gradient::DeformationGradients;
pub use degenerate::{is_degenerate, relative_height};
pub use gradient::{Gradient, gradients};
pub use laplacian::cotangent_laplacian;
pub use mass::voronoi_mass;
pub use normals::vertex_normals;
pub use polar::{Polar, polar, rotations};
pub use rotation::{Turn, logarithm, mean_gradient, mean_quaternion, nearer};
pub use tetrahedron::Tetrahedron;
pub use untouched::{keep_untouched, untouched};

#[cfg(test)]
mod tests;
