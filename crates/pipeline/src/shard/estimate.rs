//! The shards of a run: which poses each has, what is cached of them, and what it will take as far as that is known.

use mimesh_document::Diagnostic;
use serde::Serialize;

use super::{
    order::PoseOrder,
    part::Part,
    selection::{PoseSelection, Shard},
};
use crate::{
    cache::{Cache, PoseCache, Timing},
    input::Prepared,
    plan::Plan,
};

/// A shard of a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ShardPlan {
    /// Its number and the number of shards, e.g. `1/4`.
    pub shard: String,
    /// Its poses by number, e.g. `5-9`; empty if it has none.
    pub frames: String,
    /// The number of its poses.
    pub poses: usize,
    /// How many of them are cached.
    pub cached: usize,
    /// About how many seconds it will take on as many threads as the last run had; `None` where that is not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seconds: Option<f64>,
    /// The memory that the last run took; `None` where that is not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub memory_bytes: Option<u64>,
}

/// `prepared`, planned by `plan` as a whole, in `count` shards (at least one); frames of one motion with so many `warm` frames before each.
///
/// # Errors
///
/// Those of [`Part::new`].
pub fn plan_shards(
    prepared: &Prepared,
    plan: &Plan,
    cache: Option<&Cache>,
    count: usize,
    warm: Option<usize>,
) -> Result<Vec<ShardPlan>, Diagnostic> {
    let cached = cache.zip(plan.cached.as_ref());
    let timing = cached.and_then(|(cache, cached)| Timing::read(cache, cached.keys.transfer.key));
    let declared = prepared.pipeline.transfer.as_ref().is_some_and(|transfer| transfer.gives_motion());
    let motion = plan.cached.as_ref().map_or(declared, |cached| cached.motion);
    let shard = |number: usize| {
        let shard = Shard { number, of: count };
        let part = Part::new(prepared, &PoseSelection::Shard(shard), warm)?;
        if motion {
            part.check_motion()?;
        }
        let warm = warm.filter(|_| motion).unwrap_or(0);
        let order = match motion {
            true => PoseOrder::in_motion(part.poses.clone(), warm),
            false => PoseOrder::alone(part.poses.clone()),
        };
        let is_cached = |pose: &&usize| {
            cached.is_some_and(|(cache, cached)| {
                PoseCache { cache, keys: &cached.keys, motion, order: &order }.contains(**pose)
            })
        };
        let poses = part.poses.len();
        let found = part.poses.iter().filter(is_cached).count();
        // Frames of one motion are used only all together.
        let cached = if motion && found < poses { 0 } else { found };
        let warm = part.poses.first().map_or(0, |first| warm.min(*first));
        let computed = if cached < poses { poses - cached + warm } else { 0 };
        let timing = timing.as_ref().filter(|_| computed > 0);
        let seconds = timing.and_then(|timing| Some(timing.start_seconds + computed as f64 * timing.pose_seconds?));
        let memory_bytes = timing.and_then(|timing| timing.peak_memory_bytes);
        Ok(ShardPlan { shard: shard.to_string(), frames: part.ranges(), poses, cached, seconds, memory_bytes })
    };
    (0..count).map(shard).collect()
}
