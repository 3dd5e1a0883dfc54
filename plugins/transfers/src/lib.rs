//! Transfers: ways to move the target as the source moves.

mod alignment;
pub mod biharmonic;
pub mod blend;
pub mod chain;
pub mod copy_displacement;
mod extension;
mod field;
mod frames;
pub mod gradient;
mod lift;
pub mod multi_component;
mod placement;
mod poisson;
mod shore_motion;

pub use extension::Continuation;
pub use placement::Placement;
