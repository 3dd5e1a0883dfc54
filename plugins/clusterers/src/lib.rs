//! Clusterers: ways to divide a surface into regions that move about rigidly.

pub mod rotation_kmeans;
pub mod weight_kmeans;

mod kmeans;
mod points;
mod pose_features;
mod principal;
mod start;
#[cfg(test)]
mod tests;
mod unwrap;

pub use rotation_kmeans::RotationKmeans;
pub use start::Start;
pub use weight_kmeans::WeightKmeans;
