//! Cached results of single poses.

use mimesh_document::Diagnostic;

use super::{codec::PosedTarget, failure::PoseFailure, keys::RunKeys, results::Cache, store::Key};
use crate::{metrics::PoseMetrics, shard::PoseOrder};

/// The kind of cached measurements.
const METRICS: &str = "metrics";

/// The kind of cached failures.
const FAILURE: &str = "failure";

/// The kind of frames of a motion that began at another frame than the first.
const WARM: &str = "warm";

/// The cached results of a run's poses.
#[derive(Clone, Copy, Debug)]
pub struct PoseCache<'a> {
    /// The cache.
    pub cache: &'a Cache,
    /// The keys of the run.
    pub keys: &'a RunKeys,
    /// Whether poses are frames of one motion.
    pub motion: bool,
    /// Where the motions of frames begin.
    pub order: &'a PoseOrder,
}

impl PoseCache<'_> {
    /// Whether there is a result of pose `i`; it is not checked.
    pub fn contains(&self, i: usize) -> bool {
        self.key(i).is_some_and(|(kind, key)| self.cache.store.contains(kind, key))
    }

    /// The cached result of pose `i`.
    pub fn get(&self, i: usize) -> Option<PosedTarget> {
        let (kind, key) = self.key(i)?;
        self.cache.get(kind, key)
    }

    /// Stores the result of pose `i`.
    pub fn put(&self, i: usize, posed: &PosedTarget) {
        if let Some((kind, key)) = self.key(i) {
            self.cache.put(kind, key, posed);
        }
    }

    /// Whether pose `i` can be read, so that there may be a result of it.
    pub fn has_key(&self, i: usize) -> bool {
        self.key(i).is_some()
    }

    /// Whether pose `i` is known to fail.
    pub fn contains_failure(&self, i: usize) -> bool {
        self.key(i).is_some_and(|(_, key)| self.cache.store.contains(FAILURE, key))
    }

    /// Why pose `i` fails, if that is known.
    pub fn failure(&self, i: usize) -> Option<Diagnostic> {
        let failure: PoseFailure = self.cache.get(FAILURE, self.key(i)?.1)?;
        Some(failure.into_diagnostic())
    }

    /// Stores why pose `i` fails, if it would fail anywhere and at any time.
    pub fn put_failure(&self, i: usize, diagnostic: &Diagnostic) {
        if let Some((_, key)) = self.key(i)
            && let Some(failure) = PoseFailure::of(diagnostic)
        {
            self.cache.put(FAILURE, key, &failure);
        }
    }

    /// The result of frame `i` of the motion that begins at `begin`.
    pub fn warm_frame(&self, i: usize, begin: usize) -> Option<PosedTarget> {
        self.cache.get(WARM, self.keys.warm_frame(i, begin, self.order.warm())?)
    }

    /// Stores the result of frame `i` of the motion that begins at `begin`, before the part that the motion is for.
    pub fn put_warm_frame(&self, i: usize, begin: usize, posed: &PosedTarget) {
        if let Some(key) = self.keys.warm_frame(i, begin, self.order.warm()) {
            self.cache.put(WARM, key, posed);
        }
    }

    /// Whether it is known what becomes of frame `i` of the motion that begins at `begin`, `warm` frames before its part.
    pub fn contains_warm_frame(&self, i: usize, begin: usize, warm: usize) -> bool {
        let contains = |key| [WARM, FAILURE].iter().any(|kind| self.cache.store.contains(kind, key));
        self.keys.warm_frame(i, begin, warm).is_some_and(contains)
    }

    /// Whether there are measurements of pose `i`; they are not checked.
    pub fn contains_metrics(&self, i: usize) -> bool {
        self.metrics_key(i).is_some_and(|key| self.cache.store.contains(METRICS, key))
    }

    /// The cached measurements of pose `i`.
    pub fn metrics(&self, i: usize) -> Option<PoseMetrics> {
        self.cache.get(METRICS, self.metrics_key(i)?)
    }

    /// Stores the measurements of pose `i`.
    pub fn put_metrics(&self, i: usize, metrics: &PoseMetrics) {
        if let Some(key) = self.metrics_key(i) {
            self.cache.put(METRICS, key, metrics);
        }
    }

    fn metrics_key(&self, i: usize) -> Option<Key> {
        self.keys.metrics(i, |i| self.key(i).map(|(_, key)| key))
    }

    /// The kind and the key of the result of pose `i`.
    fn key(&self, i: usize) -> Option<(&'static str, Key)> {
        Some(match self.order.begin(i) {
            _ if !self.motion => ("pose", self.keys.pose(i)?),
            0 => ("frame", self.keys.frame(i)?),
            begin => (WARM, self.keys.warm_frame(i, begin, self.order.warm())?),
        })
    }
}
