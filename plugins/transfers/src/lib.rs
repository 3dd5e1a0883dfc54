//! Transfers: ways to move the target as the source moves.

mod alignment;
pub mod copy_displacement;
mod field;
pub mod gradient;
mod placement;
mod poisson;

pub use placement::Placement;
