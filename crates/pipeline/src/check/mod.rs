//! Everything that can be found wrong with a pipeline before computing, all at once; what remains is ready to run.

mod capitals;
mod chosen_runs;
mod common;
mod earlier;
mod file_names;
mod findings;
mod ground_truth;
mod held_poses;
mod markers;
mod metrics;
mod noise;
mod outputs;
mod parts;
mod pictures;
mod poses;
mod quick;
mod rest_meshes;
mod run_diagnostics;
mod runs;
mod seams;
mod shape_names;
mod shape_patterns;
mod shape_regions;
mod shapes;
mod shared;
mod stages;
mod units;
mod vertex_counts;
mod writable;

pub use common::Options;
pub use held_poses::NAME_POSES;
pub use parts::{OTHER_MESHES, prepare_meshes, prepare_posed_meshes, prepare_source};
pub use quick::check_text;
pub use rest_meshes::in_file;
pub use runs::{prepare_all, prepare_document};
pub use vertex_counts::{no_pose_fits, other_vertex_counts};
