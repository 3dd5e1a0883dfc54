//! Landmarks: ways to find corresponding points of two surfaces without clicks.

pub mod external;
pub mod extremities;
pub mod given;
