//! Weights: ways to spread the influence of handles over a surface.

pub mod biharmonic;
mod bilaplacian;
pub mod bounded_biharmonic;
mod domain;
pub mod geodesic_falloff;
mod greens;
pub mod harmonic;

pub use bounded_biharmonic::{Normalize, Solver};
