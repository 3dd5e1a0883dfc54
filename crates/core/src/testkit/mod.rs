//! Tools for tests of stages: contracts, fixture meshes, seeded random numbers, and meshes from outside the repository.

mod clusterer;
pub mod contracts;
mod correspondence;
pub mod data;
mod deformer;
mod format;
mod generator;
mod key_points;
mod landmarks;
pub mod memory_file;
pub mod meshes;
mod metric;
mod proximity;
pub mod random;
mod registered;
mod sampler;
mod support;
mod transfer;
mod weights;
