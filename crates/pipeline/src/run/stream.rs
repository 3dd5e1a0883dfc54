//! All poses of a run in a stream, so that memory does not grow with their number.

use std::sync::Mutex;

use mimesh_core::memory;
use mimesh_document::{Diagnostic, Kind, diagnostic};
use mimesh_markers::IntoDiagnostic;
use tracing::{Span, debug_span};

use super::{
    files::{PosesFile, warnings_of_pose_files},
    pose_steps::{PoseOutput, PoseSteps},
    poses::PoseRunner,
    schedule::Schedule,
    stages::Stages,
};
use crate::{input::PoseInput, progress::Progress, report::PoseReport, staging::Staged};

/// Frames of one motion that are read side by side.
const FRAMES_AT_ONCE: usize = 8;

/// The results of all poses.
#[derive(Debug, Default)]
pub(super) struct Stream {
    /// The poses in order.
    pub poses: Vec<PoseReport>,
    /// Diagnostics of the poses that failed.
    pub failed: Vec<Diagnostic>,
    /// The results, in temporary files.
    pub files: Vec<Staged>,
    /// Sentences about single poses.
    pub warnings: Vec<String>,
}

impl Stream {
    /// Sends all poses of `runner` through and tells `progress` of each.
    ///
    /// # Errors
    ///
    /// If a result cannot be written, or the transfer cannot be bound; poses that fail on their own are in the result.
    pub fn run(runner: &PoseRunner<'_>, progress: &dyn Progress) -> diagnostic::Result<Self> {
        let mut stream = Self::default();
        let of_all = if runner.is_part { vec![] } else { PosesFile::all(runner.prepared, runner.transaction)? };
        let mut sequences = of_all;
        let (poses, order) = (&runner.prepared.poses, runner.order());
        let (at_once, in_order) = batches(runner.stages)?;
        let schedule = Schedule { count: order.len(), batch: at_once, in_order };
        check_memory(runner, schedule)?;
        let steps = PoseSteps { runner, motion: Mutex::new(None), span: Span::current() };
        schedule.run(&steps, |place, posed, output| {
            let i = order.poses()[place];
            let pose = &poses[i];
            let _collecting = debug_span!(parent: &steps.span, "collect").entered();
            progress.pose_done();
            match (posed, output) {
                (Ok(posed), Ok(output)) => {
                    for sequence in &mut sequences {
                        sequence.add(pose, &posed.target.positions)?;
                    }
                    stream.add(pose, output);
                }
                (Err(diagnostic), _) => {
                    if let Some(cache) = runner.stages.pose_cache().filter(|_| !runner.stages.is_merge) {
                        cache.put_failure(i, diagnostic);
                    }
                    stream.fail(pose, diagnostic.clone())?;
                }
                (_, Err(diagnostic)) => stream.fail(pose, diagnostic)?,
            }
            Ok(())
        })?;
        stream.warnings.extend(warnings_of_pose_files(runner.prepared));
        if stream.failed.len() < stream.poses.len() {
            for sequence in sequences {
                let (file, warnings) = sequence.finish()?;
                stream.files.push(file);
                stream.warnings.extend(warnings);
            }
        }
        Ok(stream)
    }

    fn add(&mut self, pose: &PoseInput, output: PoseOutput) {
        let warnings = output.report.figures.warnings.iter();
        self.warnings.extend(warnings.map(|warning| format!("pose {}: {warning}", pose.name)));
        let mut report = output.report;
        if let Some(before) = self.poses.last() {
            report.metrics.share_names(&before.metrics);
            report.rest_baseline.share_names(&before.rest_baseline);
        }
        self.poses.push(report);
        self.files.extend(output.files);
    }

    /// Notes a pose that failed on its own.
    fn fail(&mut self, pose: &PoseInput, diagnostic: Diagnostic) -> diagnostic::Result<()> {
        // A full disk is no fault of the pose.
        if diagnostic.kind == Kind::CannotWrite {
            return Err(diagnostic.into());
        }
        let error = Some(diagnostic.to_json());
        self.poses.push(PoseReport { name: pose.name.clone(), error, ..PoseReport::default() });
        self.failed.push(diagnostic);
        Ok(())
    }
}

/// Vectors of each vertex of the target that a pose has while it is under way: its positions in the file and on the surface, and what is
/// measured of them.
const VECTORS_OF_A_POSE: usize = 6;

/// Asks for the memory of all poses that are under way together.
fn check_memory(runner: &PoseRunner<'_>, schedule: Schedule) -> diagnostic::Result<()> {
    let [under_way, posed] = schedule.at_once();
    let vertices =
        runner.prepared.source.sequence.rest.positions.len() + runner.prepared.target.sequence.rest.positions.len();
    let of_vertices = memory::bytes_of::<[f64; 3]>(under_way * VECTORS_OF_A_POSE * vertices);
    let of_transfer = runner.stages.bound_so_far().map_or(0, |bound| bound.bytes(posed));
    let what = format!("{under_way} poses under way");
    Ok(memory::need(what, of_vertices + of_transfer).map_err(IntoDiagnostic::into_diagnostic)?)
}

/// How many poses are taken at once, and whether one batch needs those before it.
fn batches(stages: &Stages<'_>) -> diagnostic::Result<(usize, bool)> {
    // Where all results are cached there may be no bound transfer, and one batch at a time may have to bind it.
    if stages.reusable_poses().is_some() && stages.is_complete() {
        return Ok((FRAMES_AT_ONCE, true));
    }
    let bound = stages.bound()?;
    Ok(if bound.motion().is_some() { (FRAMES_AT_ONCE, true) } else { (bound.at_once(), false) })
}
