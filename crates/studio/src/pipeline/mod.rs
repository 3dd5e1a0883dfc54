//! The text of the pipeline: kept, changed value by value with its comments, and checked.

pub mod check;
pub mod history;
pub mod set;
pub mod store;
pub mod written;

pub use check::Checked;
pub use store::{PipelineStore, PipelineView};
