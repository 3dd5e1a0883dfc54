//! Frames of one motion, each found from those before.

use std::ops::Range;

use mimesh_core::stage::{BoundTransfer, Motion};
use rayon::prelude::*;
use tracing::{Span, debug_span};

use super::{
    measure::PosedPose,
    poses::{PoseResult, PoseRunner},
};

/// Frames that are read side by side while a motion is replayed.
const READ_AT_ONCE: usize = 8;

/// A motion under way.
pub(super) struct MotionUnderWay<'a> {
    bound: &'a dyn BoundTransfer,
    motion: Box<dyn Motion + 'a>,
    /// The frame at which it began, and the next one; `None` until it has begun.
    frames: Option<Range<usize>>,
}

impl<'a> MotionUnderWay<'a> {
    /// A fresh start; `None` for a transfer whose poses stand alone.
    pub fn new(bound: &'a dyn BoundTransfer) -> Option<Self> {
        Some(Self { bound, motion: bound.motion()?, frames: None })
    }

    /// The frames at some places of the run's order: read side by side, but transferred one after the other.
    pub fn frames(&mut self, runner: &PoseRunner<'_>, places: Range<usize>) -> Vec<PoseResult<PosedPose>> {
        let (poses, order) = (&runner.prepared.poses, runner.order());
        let span = Span::current();
        let frames = &order.poses()[places.clone()];
        let read: Vec<_> = frames.par_iter().map(|&i| runner.read(&poses[i], &span)).collect();
        let transferred: Vec<_> = frames
            .iter()
            .zip(read)
            .map(|(&i, source)| {
                self.go_to(runner, i);
                let source = source?;
                let transferred = runner.transfer_span(1).in_scope(|| self.motion.frame(i, &source.surface));
                Ok((source, transferred))
            })
            .collect();
        let posed = |(place, result): (usize, PoseResult<_>)| {
            let (source, transferred) = result?;
            debug_span!(parent: &span, "result").in_scope(|| runner.posed(place, source, transferred))
        };
        places.into_par_iter().zip(transferred).map(posed).collect()
    }

    /// Brings the motion to frame `i`, unless it is there, through all frames since it begins.
    fn go_to(&mut self, runner: &PoseRunner<'_>, i: usize) {
        let begin = runner.order().begin(i);
        if self.frames != Some(begin..i) {
            // The first motion is fresh.
            if self.frames.is_some()
                && let Some(motion) = self.bound.motion()
            {
                self.motion = motion;
            }
            self.replay(runner, begin..i);
        }
        self.frames = Some(begin..i + 1);
    }

    /// Sends frames through whose results are there already, or are thrown away.
    fn replay(&mut self, runner: &PoseRunner<'_>, frames: Range<usize>) {
        let span = Span::current();
        let poses = &runner.prepared.poses;
        for start in frames.clone().step_by(READ_AT_ONCE) {
            let some = start..frames.end.min(start + READ_AT_ONCE);
            let read: Vec<_> = some.clone().into_par_iter().map(|i| runner.read(&poses[i], &span)).collect();
            for (i, source) in some.zip(read) {
                // A frame that fails is reported where it counts.
                let Ok(source) = source else { continue };
                let transferred = self.motion.frame(i, &source.surface);
                if frames.start > 0 && i + 1 == frames.end {
                    runner.keep_last_warm_frame(i, frames.start, &source, transferred);
                }
            }
        }
    }
}
