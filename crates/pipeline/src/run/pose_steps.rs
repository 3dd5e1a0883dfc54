//! The steps of a pose: taken from the cache or transferred, then measured and written.

use std::{
    ops::Range,
    sync::{Mutex, MutexGuard, PoisonError},
};

use mimesh_document::{Diagnostic, Diagnostics, Kind, diagnostic};
use rayon::prelude::*;
use tracing::{Span, debug_span};

use super::{
    files::pose_files,
    measure::PosedPose,
    motion::MotionUnderWay,
    poses::{PoseResult, PoseRunner},
    schedule::Steps,
};
use crate::{
    cache::PosedTarget,
    metrics::{MEASURED_BEFORE, are_measured_alone},
    report::PoseReport,
    staging::Staged,
};

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
    pub motion: Mutex<Option<MotionUnderWay<'a>>>,
    /// The span of all poses: any thread may take a step.
    pub span: Span,
}

impl<'a> PoseSteps<'a> {
    fn motion(&self) -> MutexGuard<'_, Option<MotionUnderWay<'a>>> {
        self.motion.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The result of a pose for a merge, which computes none: the cached one, or why there is none.
    fn merged(&self, place: usize, cached: Option<PosedTarget>) -> diagnostic::Result<PoseResult<PosedPose>> {
        let runner = self.runner;
        let pose = runner.order().poses()[place];
        if let Some(target) = cached {
            return Ok(runner.reused(place, target));
        }
        let input = &runner.prepared.poses[pose];
        // A file that cannot be read says best why.
        if let Err(diagnostic) = runner.read(input, &Span::current()) {
            return Ok(Err(diagnostic));
        }
        match runner.stages.pose_cache().and_then(|cache| cache.failure(pose)) {
            Some(diagnostic) => Ok(Err(diagnostic)),
            None => {
                let message = format!("pose {}: its cached result was damaged, and is removed", input.name);
                Err(Diagnostic::new(Kind::Busy, message).hint("compute this pose again, and then merge").into())
            }
        }
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
        let motion = self.motion().take();
        let cache = runner.stages.reusable_poses().filter(|_| motion.is_none());
        let poses = runner.order().poses();
        let mut cached: Vec<Option<PosedTarget>> =
            batch.clone().into_par_iter().map(|place| cache.and_then(|cache| cache.get(poses[place]))).collect();
        if runner.stages.is_merge {
            return batch.zip(cached).map(|(place, cached)| self.merged(place, cached)).collect();
        }
        if !cached.iter().all(Option::is_some) {
            let bound = runner.stages.bound()?;
            if let Some(mut motion) = motion.or_else(|| MotionUnderWay::new(bound)) {
                let frames = motion.frames(runner, batch);
                *self.motion() = Some(motion);
                return Ok(frames);
            }
        }
        let missing: Vec<usize> =
            batch.clone().zip(&cached).filter(|(_, c)| c.is_none()).map(|(place, _)| place).collect();
        let mut transferred = if missing.is_empty() {
            vec![].into_iter()
        } else {
            runner.transferred(&missing, runner.stages.bound()?).into_iter()
        };
        let pose = |(place, cached): (usize, &mut Option<PosedTarget>)| match cached.take() {
            Some(target) => runner.reused(place, target),
            None => transferred.next().expect("each pose that is missing was transferred"),
        };
        Ok(batch.zip(&mut cached).map(pose).collect())
    }

    /// Measures and writes a pose; the diagnostic of one that failed before.
    fn finish(
        &self,
        place: usize,
        posed: &PoseResult<PosedPose>,
        before: [Option<&PoseResult<PosedPose>>; MEASURED_BEFORE],
    ) -> PoseResult<PoseOutput> {
        let (prepared, order) = (self.runner.prepared, self.runner.order());
        let i = order.poses()[place];
        let this = posed.as_ref().map_err(Clone::clone)?;
        let alone = are_measured_alone(prepared);
        let places = order.before::<MEASURED_BEFORE>(place);
        let before = std::array::from_fn(|back| {
            let posed = before[back].filter(|_| places[back].is_some() && !alone)?;
            posed.as_ref().ok().map(PosedPose::frame)
        });
        let name = prepared.poses[i].name.clone();
        let mut report =
            PoseReport { name, reused: this.reused, figures: this.target.figures.clone(), ..PoseReport::default() };
        let span = debug_span!(parent: &self.span, "measure", pose = &*report.name);
        // What is measured without the poses before is not what the whole run measures.
        let is_exact = alone || order.has_all_before::<MEASURED_BEFORE>(place);
        let cache = self.runner.stages.pose_cache().filter(|_| is_exact);
        span.in_scope(|| self.runner.measurer.measure([i, place], this, before, cache, &mut report));
        let files = debug_span!(parent: &self.span, "write", pose = &*report.name)
            .in_scope(|| pose_files(prepared, self.runner.transaction, i, &this.target.positions))?;
        Ok(PoseOutput { report, files })
    }
}
