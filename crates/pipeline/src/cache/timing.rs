//! How long the last run of a transfer took, which shards are estimated by.

use serde::{Deserialize, Serialize};

use super::{codec::CacheCodec, results::Cache, store::Key};
use crate::json::to_bytes;

/// The kind of its entry in the cache.
const KIND: &str = "timing";

/// What the last run that computed poses of a transfer took.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Timing {
    /// Threads used.
    pub threads: usize,
    /// Seconds to read meshes and to bind, which every process takes.
    pub start_seconds: f64,
    /// Seconds from one pose to the next, with all threads at work; `None` until poses were computed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pose_seconds: Option<f64>,
    /// The largest resident memory of the process, where the system tells.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub peak_memory_bytes: Option<u64>,
}

impl Timing {
    /// The times of the transfer with the key `transfer`, if it has run.
    pub fn read(cache: &Cache, transfer: Key) -> Option<Self> {
        cache.get(KIND, transfer)
    }

    /// Stores them.
    pub fn store(&self, cache: &Cache, transfer: Key) {
        cache.put(KIND, transfer, self);
    }
}

impl CacheCodec for Timing {
    fn encode(&self) -> Vec<u8> {
        to_bytes(self)
    }

    fn decode(bytes: &[u8]) -> Option<Self> {
        serde_json::from_slice(bytes).ok()
    }
}
