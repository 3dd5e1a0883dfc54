//! Cached results of single poses.

use super::{codec::PosedTarget, keys::RunKeys, results::Cache, store::Key};
use crate::metrics::PoseMetrics;

/// The kind of cached measurements.
const METRICS: &str = "metrics";

/// The cached results of a run's poses.
#[derive(Clone, Copy, Debug)]
pub struct PoseCache<'a> {
    /// The cache.
    pub cache: &'a Cache,
    /// The keys of the run.
    pub keys: &'a RunKeys,
    /// Whether poses are frames of one motion.
    pub motion: bool,
}

impl PoseCache<'_> {
    /// Whether there is a result of pose `i`; it is not checked.
    pub fn contains(&self, i: usize) -> bool {
        self.key(i).is_some_and(|key| self.cache.store.contains(self.kind(), key))
    }

    /// The cached result of pose `i`.
    pub fn get(&self, i: usize) -> Option<PosedTarget> {
        self.cache.get(self.kind(), self.key(i)?)
    }

    /// Stores the result of pose `i`.
    pub fn put(&self, i: usize, posed: &PosedTarget) {
        if let Some(key) = self.key(i) {
            self.cache.put(self.kind(), key, posed);
        }
    }

    /// Whether there are measurements of pose `i`; they are not checked.
    pub fn contains_metrics(&self, i: usize) -> bool {
        self.keys.metrics(i, self.motion).is_some_and(|key| self.cache.store.contains(METRICS, key))
    }

    /// The cached measurements of pose `i`.
    pub fn metrics(&self, i: usize) -> Option<PoseMetrics> {
        self.cache.get(METRICS, self.keys.metrics(i, self.motion)?)
    }

    /// Stores the measurements of pose `i`.
    pub fn put_metrics(&self, i: usize, metrics: &PoseMetrics) {
        if let Some(key) = self.keys.metrics(i, self.motion) {
            self.cache.put(METRICS, key, metrics);
        }
    }

    fn kind(&self) -> &'static str {
        if self.motion { "frame" } else { "pose" }
    }

    fn key(&self, i: usize) -> Option<Key> {
        if self.motion { self.keys.frame(i) } else { self.keys.pose(i) }
    }
}
