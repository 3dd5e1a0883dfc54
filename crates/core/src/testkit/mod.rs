//! What tests of stages need: fixture meshes and seeded random numbers.

mod clusterer;
pub mod contracts;
mod deformer;
mod format;
mod key_points;
pub mod meshes;
mod metric;
pub mod random;
mod registered;
mod sampler;
mod weights;
