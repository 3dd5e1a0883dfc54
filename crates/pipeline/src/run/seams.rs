//! Where parts of a motion meet that were computed alone.

use nalgebra::distance;

use super::stages::Stages;
use crate::{cache::PosedTarget, input::Prepared, plan::Plan, text::number};

/// How far the parts of a motion lie apart where they meet.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Seams {
    /// The number of parts.
    pub parts: usize,
    /// The number of warm frames before each.
    pub warm: usize,
    /// The largest distance of a vertex from the same in the part before, in percent of the target's diagonal, and the name of the frame.
    pub largest: Option<(f64, String)>,
}

/// The seams of a motion whose frames parts have computed; `None` where all frames are exact.
///
/// Each part also has the last of its warm frames, which is the last of the part before. Both would be the same if the part had begun
/// with the first frame of all.
pub(super) fn seams(prepared: &Prepared, plan: &Plan, stages: &Stages<'_>) -> Option<Seams> {
    let order = &plan.order;
    let cache = stages.pose_cache().filter(|_| plan.extent.is_merge())?;
    let begins =
        |&frame: &usize| order.begin(frame) > 0 && (frame == 0 || order.begin(frame) != order.begin(frame - 1));
    let starts: Vec<usize> = order.poses().iter().copied().filter(begins).collect();
    if starts.is_empty() {
        return None;
    }
    let diagonal = prepared.target.sequence.rest.diagonal();
    let apart = |&frame: &usize| {
        let before = frame.checked_sub(1)?;
        let (part, warm) = (cache.get(before)?, cache.warm_frame(before, order.begin(frame))?);
        Some((100.0 * largest_distance(&part, &warm) / diagonal, prepared.poses[before].name.clone()))
    };
    let largest = starts.iter().filter_map(apart).max_by(|a, b| a.0.total_cmp(&b.0));
    // Exact frames before the first are a part too.
    let parts = starts.len() + usize::from(order.begin(0) == 0);
    Some(Seams { parts, warm: order.warm(), largest })
}

fn largest_distance(a: &PosedTarget, b: &PosedTarget) -> f64 {
    a.positions.iter().zip(&b.positions).map(|(a, b)| distance(a, b)).fold(0.0, f64::max)
}

impl Seams {
    /// The seams as a sentence.
    pub fn warning(&self) -> String {
        let Self { parts, warm, .. } = self;
        let start = format!(
            "frames of one motion were computed in {parts} parts, each after {warm} warm frames: results are not exact"
        );
        match &self.largest {
            Some((percent, pose)) => format!(
                "{start}; where parts meet, vertices lie up to {} % of the target's diagonal apart, most at frame {pose}",
                number(*percent)
            ),
            None => format!("{start}, and how far parts lie apart where they meet is not known"),
        }
    }
}
