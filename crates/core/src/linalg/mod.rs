//! Sparse symmetric positive definite systems: assembled once, factored when values change, solved often.
//!
//! Matrices are `nalgebra_sparse` CSC matrices that hold the lower triangle; faer factors them, or several at once
//! [in lanes](LaneCholesky). Large ones that are factored often have [fronts](Multifrontal). Everything here runs on the calling
//! thread: callers spread right-hand sides, poses and handles over threads themselves, which measures faster than threads inside a
//! factorisation. Only [`Blocks`], [`Multifrontal`] and [`FixedUnknowns::for_refactoring`] use the threads there are.

mod assembly;
mod blocks;
mod cholesky;
mod fixed;
mod lanes;
mod multifrontal;
mod residual;
mod symbolic;

pub use assembly::Assembly;
pub use blocks::{Blocks, OuterSum};
pub use cholesky::Cholesky;
pub use fixed::FixedUnknowns;
pub use lanes::{LaneCholesky, LanePattern};
pub use multifrontal::Multifrontal;
