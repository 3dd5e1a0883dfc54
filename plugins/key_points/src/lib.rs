//! Key points: ways to choose the few points of a source that tell its poses best.

mod candidates;
pub mod given;
pub mod greedy;
mod measure;
mod search;
