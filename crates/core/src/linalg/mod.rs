//! Sparse symmetric positive definite systems: assembled once, factored when values change, solved often.
//!
//! Matrices are `nalgebra_sparse` CSC matrices that hold the lower triangle; faer factors them. Everything here runs on
//! the calling thread: callers spread right-hand sides, poses and handles over threads themselves, which measures faster
//! than threads inside a factorisation.

mod assembly;
mod cholesky;
mod fixed;

pub use assembly::Assembly;
pub use cholesky::Cholesky;
pub use fixed::FixedUnknowns;
