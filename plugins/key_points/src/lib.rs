//! Key points: ways to choose the few points of a source that tell its poses best.

mod candidates;
mod coarse;
mod course;
mod evaluator;
pub mod given;
pub mod greedy;
mod judge;
mod measure;
mod report;
mod search;
