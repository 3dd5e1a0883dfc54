//! What the cache holds of a run, looked up before it is planned.

use rayon::prelude::*;

use crate::{
    cache::{Cache, PoseCache, RunKeys, TransferSummary},
    input::Prepared,
    metrics::{MEASURED_BEFORE, are_measured_alone},
    shard::{Extent, Merge, PoseOrder, begins_of_parts},
};

/// What the cache holds of a run.
#[derive(Clone, Debug)]
pub struct CachedRun {
    /// The keys of the run.
    pub keys: RunKeys,
    /// What is known of the bound transfer.
    pub transfer: Option<TransferSummary>,
    /// Whether poses are frames of one motion, as far as that is known.
    pub motion: bool,
    /// Whether every pose has a result.
    pub complete: bool,
    /// Whether every pose has measurements, too, and they will do: pictures show more than they hold.
    pub measured: bool,
    /// The poses that have to run, or, for a merge, that no part has computed.
    pub missing: Vec<usize>,
}

impl CachedRun {
    /// Looks up what `cache` holds of a run of `prepared`, and the order of its poses; entries are not checked.
    pub fn new(prepared: &Prepared, cache: &Cache, extent: &Extent) -> (Self, PoseOrder) {
        let is_declared = prepared.pipeline.transfer.as_ref().is_some_and(|transfer| transfer.gives_motion());
        let mut keys = match extent {
            Extent::Part(part) if !is_declared => RunKeys::of_part(prepared, cache.program(), &part.poses),
            _ => RunKeys::new(prepared, cache.program()),
        };
        let transfer: Option<TransferSummary> = cache.get("transfer", keys.transfer.key);
        let motion = transfer.as_ref().map_or(is_declared, |transfer| transfer.motion);
        if motion && !is_declared {
            // The key of a frame needs all before it.
            keys = RunKeys::new(prepared, cache.program());
        }
        let order = order(prepared, cache, &keys, extent, motion);
        let poses = PoseCache { cache, keys: &keys, motion, order: &order };
        let is_missing = |i: &usize| match extent {
            // What cannot be read, or fails anywhere, is no part's to compute.
            Extent::Merge(_) => !poses.contains(*i) && poses.has_key(*i) && !poses.contains_failure(*i),
            _ => !poses.contains(*i),
        };
        let missing: Vec<usize> = order.poses().par_iter().copied().filter(is_missing).collect();
        let complete = missing.is_empty() && (transfer.is_some() || extent.is_merge());
        let alone = are_measured_alone(prepared);
        let is_measured = |place: usize| {
            let pose = order.poses()[place];
            let has_all = alone || order.has_all_before::<MEASURED_BEFORE>(place);
            has_all && (poses.contains_metrics(pose) || !poses.contains(pose))
        };
        let measured = complete && (extent.is_part() || !prepared.outputs.are_visual());
        let measured = measured && (0..order.len()).into_par_iter().all(is_measured);
        // Frames of one motion depend on those before, so they are used only all together.
        let all_run = motion && !missing.is_empty() && !extent.is_merge();
        let missing = if all_run { order.poses().to_vec() } else { missing };
        (Self { keys, transfer, motion, complete, measured, missing }, order)
    }
}

/// The poses of a run, and where the motions of frames begin.
fn order(prepared: &Prepared, cache: &Cache, keys: &RunKeys, extent: &Extent, motion: bool) -> PoseOrder {
    let all = prepared.poses.len();
    match extent {
        Extent::Part(part) if motion => PoseOrder::in_motion(part.poses.clone(), part.warm.unwrap_or(0)),
        Extent::Part(part) => PoseOrder::alone(part.poses.clone()),
        Extent::Merge(Merge { warm: Some(warm) }) if motion => {
            PoseOrder::of_parts(all, begins_of_parts(cache, keys, all, *warm), *warm)
        }
        _ => PoseOrder::all(all),
    }
}
