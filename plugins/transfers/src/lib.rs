//! Transfers: ways to move the target as the source moves.

mod alignment;
pub mod biharmonic;
pub mod blend;
pub mod chain;
pub mod copy_displacement;
mod field;
mod frames;
pub mod gradient;
pub mod multi_component;
mod placement;
mod poisson;

pub use placement::Placement;
