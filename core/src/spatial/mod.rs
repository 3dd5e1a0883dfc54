//! Spatial.
