//! What a run works on, once it is read and checked: rest meshes, poses, the ground truth, files.

mod file_hashes;
mod ground_truth;
mod help_commands;
mod output_change;
mod outputs;
mod poses;
mod prepared;
mod rest_mesh;
mod view_script;

pub use file_hashes::{FileHashes, HashedFile};
pub use ground_truth::GroundTruth;
pub use help_commands::HelpCommands;
pub use output_change::OutputChange;
pub use outputs::{Output, Outputs};
pub use poses::{PoseFrom, PoseInput, evenly_spaced, poses_are, read_evenly_spaced, read_pose};
pub use prepared::{InputFile, Meshes, PosedMeshes, Prepared, PreparedSource, ProximityInput};
pub use rest_mesh::RestMesh;
pub use view_script::ViewScript;
