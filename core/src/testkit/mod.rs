//! What tests of stages need: fixture meshes and seeded random numbers.

mod clusterer;
pub mod contracts;
mod deformer;
mod key_points;
pub mod meshes;
pub mod random;
mod sampler;
mod weights;
