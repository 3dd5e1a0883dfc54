//! Runs that are split over processes and machines.
//!
//! The cache holds results and measurements of each pose under keys that do not depend on which poses run together. A part of a run
//! therefore computes its poses into a cache that all share, and writes the files that hold one pose each. A merge takes every pose from
//! the cache and writes all files, with the bytes of a run that was not split.

mod estimate;
mod frames;
mod missing;
mod order;
mod part;
mod room;
mod selection;
mod warm;

pub use estimate::{ShardPlan, plan_shards};
pub use frames::{Frames, in_ranges};
pub use missing::{COMPUTE_POSES, missing_poses};
pub use order::PoseOrder;
pub use part::{Extent, Merge, Part, WARM_FRAMES};
pub use room::{LARGER_CACHE, bytes_of_poses, check_room, megabytes_of_poses};
pub use selection::{PoseSelection, Shard};
pub use warm::begins_of_parts;
