//! The text of the pipeline: kept, changed value by value with its comments, and checked.

pub mod check;
pub mod set;
pub mod store;

pub use check::Checked;
pub use store::{PipelineStore, PipelineView};
