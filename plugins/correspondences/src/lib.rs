//! correspondences
