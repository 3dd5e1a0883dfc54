//! Running a prepared pipeline: stages once, poses in a stream, results written together at the end.

mod execute;
mod files;
mod measure;
mod pose_steps;
mod poses;
mod schedule;
mod stages;
mod stream;
mod written;

pub use execute::{Finished, run};
pub use poses::pose_error;
pub use stages::GIVE_MARKERS;
