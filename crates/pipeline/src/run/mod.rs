//! Running a prepared pipeline: stages once, poses in a stream, results written together at the end.

mod assemble;
mod execute;
mod failures;
mod files;
mod measure;
mod motion;
mod pose_steps;
mod poses;
mod prepare_stages;
mod schedule;
mod seams;
mod sharing;
mod stages;
mod stream;
mod written;

pub use execute::{Finished, run};
pub use poses::pose_error;
pub use prepare_stages::prepare_stages;
pub use stages::GIVE_MARKERS;
