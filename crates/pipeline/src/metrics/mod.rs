//! The metrics of a pipeline: measured on every pose, held to limits and gates, and combined over poses.
//!
//! [`Verdict`] and [`PoseMetrics`] are data that reports and the cache keep. [`Gate`]s come from the declared statistics.
//! [`MetricSet`] measures poses and gives verdicts. [`over_poses`] reads the reports of all poses.

mod declared;
mod faults;
mod gates;
mod landmark_doubt;
mod metric_set;
mod neighbours;
mod over_poses;
mod point_error;
mod pose_metrics;
pub mod verdict;

pub use declared::{declared_statistic, key_in_words, limit_with_unit, unit, with_unit};
pub use faults::faults;
pub use gates::{Gate, Unknown, gates};
pub use landmark_doubt::landmark_doubt;
pub use metric_set::{MetricSet, binding_error};
pub use neighbours::{MEASURED_BEFORE, are_measured_alone};
pub use over_poses::{PrimaryStatistic, over_poses, primary_statistics};
pub use point_error::point_error;
pub use pose_metrics::{PoseMeasurements, PoseMetrics};
pub use verdict::{Level, Reason, Verdict};
