//! Proximity: ways to find which components of a target lie close together.

mod parts;
pub mod spanning_tree;
mod sweep;
mod tree;
