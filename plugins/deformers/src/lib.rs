//! Deformers: ways to find the maps of handles that bring a surface to a pose.

pub mod arap_skinning;
pub mod linear_blend;

mod alternation;
mod covariances;
mod edges;
mod handle_space;
mod handles;
mod reference;
#[cfg(test)]
mod tests;

pub use arap_skinning::{ArapSkinning, Difference, EdgeWeights, GlobalStep};
pub use linear_blend::LinearBlend;
