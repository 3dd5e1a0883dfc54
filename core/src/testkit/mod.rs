//! What tests of stages need: fixture meshes and seeded random numbers.

pub mod contracts;
pub mod meshes;
pub mod random;
