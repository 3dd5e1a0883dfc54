//! Frames of a motion that was computed in parts, each of which began some warm frames earlier.

use std::collections::BTreeMap;

use super::order::PoseOrder;
use crate::cache::{Cache, PoseCache, RunKeys};

/// Where the motions began that the cache has frames of, for each of the first `count` frames that is not exact.
///
/// An exact frame is always taken. Of the others a frame goes on with the part of the one before it, if that part has it, so that there
/// are as few seams as can be.
pub fn begins_of_parts(cache: &Cache, keys: &RunKeys, count: usize, warm: usize) -> BTreeMap<usize, usize> {
    let exact = PoseOrder::all(count);
    let poses = PoseCache { cache, keys, motion: true, order: &exact };
    let mut begins = BTreeMap::new();
    // The parts that have the frame before, and the one of them that it is taken from.
    let (mut parts, mut taken) = (Vec::new(), None);
    for frame in 0..count {
        let has = |begin: &usize| poses.contains_warm_frame(frame, *begin, warm);
        parts.retain(has);
        // A part that begins with the first frame of all is exact.
        parts.extend(frame.checked_sub(warm).filter(|begin| *begin > 0 && has(begin)));
        taken = match poses.contains(frame) {
            true => None,
            false => taken.filter(|begin| parts.contains(begin)).or_else(|| parts.last().copied()),
        };
        begins.extend(taken.map(|begin| (frame, begin)));
    }
    begins
}
