//! Key points: ways to choose the few points of a source that tell its poses best.

mod candidates;
pub mod greedy;
mod search;
