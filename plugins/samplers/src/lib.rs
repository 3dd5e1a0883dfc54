//! Samplers: ways to spread points over a surface.

pub mod farthest_point;
pub mod given;
mod ground;
pub mod poisson_disk;

pub use farthest_point::Metric;
