//! Metrics: how far a result is from what it should be.

pub mod point_error;
