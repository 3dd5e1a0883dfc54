//! Correspondences: ways to find for each target triangle the source triangle that it moves like.

mod facing;
pub mod from_file;
pub mod identity;
pub mod nearest;
pub mod nonrigid_fit;
mod sides;
