//! Results of stages, cached under all that they depend on, so that a run computes only what is new.
//!
//! A key is the BLAKE3 hash of the program's identity, the stage's settings, the contents of its inputs and the keys of the
//! stages before it. No time stamp takes part, and of a path only its extension. Cached are the seams that open in the source,
//! proposed markers, the proximity graph, the triangle map, every posed target as soon as it is done, why a pose failed, and measurements.
//! So a run that was killed goes on where it was. A bound transfer is no data; it is bound again if any pose is missing. Frames of one motion
//! depend on those before, so that they are used only all together.

mod codec;
mod failure;
mod hashes;
mod keys;
mod last_run;
mod pose_cache;
mod results;
mod stage_lock;
mod store;
mod timing;

pub use codec::{CacheCodec, OpenedSeams, PosedTarget, TransferSummary};
pub use keys::{RunKeys, StageKey, opened_seams_key, proximity_key};
pub use last_run::{Change, LastRun};
pub use pose_cache::PoseCache;
pub use results::{Cache, DEFAULT_LIMIT, OTHER_CACHE_FOLDER, VARIABLE, WITHOUT_CACHE};
pub use stage_lock::{LockHolder, StageLock};
pub use store::{CacheUsage, Key, Lookup, Store};
pub use timing::Timing;
