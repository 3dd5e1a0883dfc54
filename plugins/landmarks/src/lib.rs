//! Landmarks: ways to find corresponding points of two surfaces without clicks.

pub mod extremities;
