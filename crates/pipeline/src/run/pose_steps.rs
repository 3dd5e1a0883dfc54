//! The steps of a pose: taken from the cache or transferred, then measured and written.

use std::{
    ops::Range,
    sync::{Mutex, MutexGuard, PoisonError},
};

use mimesh_core::{mesh::PosesAre, stage::Motion};
use mimesh_document::{Diagnostics, diagnostic};
use rayon::prelude::*;
use tracing::{Span, debug_span};

use super::{
    files::pose_files,
    measure::PosedPose,
    poses::{PoseResult, PoseRunner},
    schedule::{BEFORE, Steps},
};
use crate::{cache::PosedTarget, report::PoseReport, staging::Staged};

/// The output of one pose.
pub(super) struct PoseOutput {
    /// What is known of it.
    pub report: PoseReport,
    /// Its files, in temporary places.
    pub files: Vec<Staged>,
}

/// The steps of the poses of a run.
pub(super) struct PoseSteps<'a> {
    /// What they are done with.
    pub runner: &'a PoseRunner<'a>,
    /// The motion under way, where poses are frames of one.
    pub motion: Mutex<Option<Box<dyn Motion + 'a>>>,
    /// The span of all poses: any thread may take a step.
    pub span: Span,
}

impl<'a> PoseSteps<'a> {
    fn motion(&self) -> MutexGuard<'_, Option<Box<dyn Motion + 'a>>> {
        self.motion.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Steps for PoseSteps<'_> {
    type Posed = PoseResult<PosedPose>;
    type Output = PoseResult<PoseOutput>;
    type Error = Diagnostics;

    /// The poses of a batch, transferred or taken from the cache.
    ///
    /// Frames of one motion are taken from the cache only where all are there. If one proves damaged, the motion is replayed up to it.
    fn pose(&self, batch: Range<usize>) -> diagnostic::Result<Vec<PoseResult<PosedPose>>> {
        let runner = self.runner;
        let _posing = debug_span!(parent: &self.span, "pose", count = batch.len()).entered();
        // Taken, not held: this thread may begin another batch while it waits for others, but not within a motion.
        let mut motion = self.motion().take();
        let cache = runner.stages.reusable_poses().filter(|_| motion.is_none());
        let mut cached: Vec<Option<PosedTarget>> =
            batch.clone().into_par_iter().map(|i| cache.and_then(|cache| cache.get(i))).collect();
        if !cached.iter().all(Option::is_some) {
            let bound = runner.stages.bound()?;
            if motion.is_none() {
                motion = bound.motion();
                if let Some(motion) = motion.as_mut() {
                    runner.replay(batch.start, motion.as_mut());
                }
            }
            if let Some(mut motion) = motion {
                let frames = runner.frames(batch, motion.as_mut());
                *self.motion() = Some(motion);
                return Ok(frames);
            }
        }
        let missing: Vec<usize> = batch.clone().zip(&cached).filter(|(_, c)| c.is_none()).map(|(i, _)| i).collect();
        let mut transferred = if missing.is_empty() {
            vec![].into_iter()
        } else {
            runner.transferred(&missing, runner.stages.bound()?).into_iter()
        };
        let pose = |(i, cached): (usize, &mut Option<PosedTarget>)| match cached.take() {
            Some(target) => runner.reused(&runner.prepared.poses[i], target),
            None => transferred.next().expect("each pose that is missing was transferred"),
        };
        Ok(batch.zip(&mut cached).map(pose).collect())
    }

    /// Measures and writes a pose; the diagnostic of one that failed before.
    fn finish(
        &self,
        i: usize,
        posed: &PoseResult<PosedPose>,
        before: [Option<&PoseResult<PosedPose>>; BEFORE],
    ) -> PoseResult<PoseOutput> {
        let prepared = self.runner.prepared;
        let this = posed.as_ref().map_err(Clone::clone)?;
        let before = match prepared.poses_are {
            PosesAre::Frames => before.map(|posed| posed?.as_ref().ok().map(PosedPose::frame)),
            PosesAre::Shapes => [None; BEFORE],
        };
        let name = prepared.poses[i].name.clone();
        let mut report =
            PoseReport { name, reused: this.reused, figures: this.target.figures.clone(), ..PoseReport::default() };
        let span = debug_span!(parent: &self.span, "measure", pose = &*report.name);
        span.in_scope(|| self.runner.measurer.measure(i, this, before, self.runner.stages.pose_cache(), &mut report));
        let files = debug_span!(parent: &self.span, "write", pose = &*report.name)
            .in_scope(|| pose_files(prepared, self.runner.transaction, i, &this.target.positions))?;
        Ok(PoseOutput { report, files })
    }
}
