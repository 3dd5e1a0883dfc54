//! Executing a plan.

use std::collections::HashSet;

use mimesh_core::stage::MetricContext;
use mimesh_document::{Diagnostic, Diagnostics, Kind, diagnostic::Result};
use rayon::prelude::*;
use tracing::info_span;

use super::{
    assemble::{Done, assemble},
    measure::Measurer,
    poses::PoseRunner,
    seams::seams,
    stages::Stages,
    stream::Stream,
    written,
};
use crate::{
    cache::{Cache, LastRun, Timing},
    check::no_pose_fits,
    input::Prepared,
    metrics::{MEASURED_BEFORE, MetricSet, PoseMetrics, are_measured_alone},
    pictures::Thumbnails,
    plan::Plan,
    progress::Progress,
    report::{Clock, PoseReport, Report, StageReport, usage},
    rest_choice::warning_of_rest,
    shapes::ShapeEditor,
    shard::{Extent, missing_poses},
    staging::{Staged, Transaction},
};

/// A run that gave results.
#[derive(Debug)]
pub struct Finished {
    /// The report of the run.
    pub report: Report,
    /// Diagnostics of the poses that failed; the others are written.
    pub failed: Vec<Diagnostic>,
}

/// Executes `plan` for `prepared` on `threads` threads (0: as many as the machine has); `cache` is the one that the plan was made
/// with.
///
/// The results are the same for any number of threads, and with or without a cache.
///
/// # Errors
///
/// Those of a stage or a file; then nothing is written. A pose that fails on its own is in the result, unless all of them fail.
pub fn run(
    prepared: &Prepared,
    plan: &Plan,
    threads: usize,
    cache: Option<&Cache>,
    progress: &dyn Progress,
) -> Result<Finished> {
    // The threads of the pool are in no span.
    let span = info_span!("run", "type" = &*prepared.variant.name);
    in_pool(threads, || span.in_scope(|| execute(prepared, plan, cache, progress)))
}

/// Does `work` on so many threads (0: as many as the machine has).
///
/// # Errors
///
/// Those of the work, and if the system starts no threads.
pub(super) fn in_pool<T: Send>(threads: usize, work: impl FnOnce() -> Result<T> + Send) -> Result<T> {
    let name = |worker| format!("worker {}", worker + 1);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).thread_name(name).build();
    let pool = pool.map_err(|error| Diagnostic::new(Kind::Internal, format!("cannot start threads: {error}")))?;
    pool.install(work)
}

fn execute(prepared: &Prepared, plan: &Plan, cache: Option<&Cache>, progress: &dyn Progress) -> Result<Finished> {
    let Some(transfer) = &prepared.pipeline.transfer else {
        return Err(Diagnostic::new(Kind::Internal, "a pipeline without a transfer was taken for checked").into());
    };
    let since_start = Clock::start();
    Diagnostics { list: no_pose_fits(prepared) }.into_result()?;
    Diagnostics { list: missing_poses(plan).into_iter().collect() }.into_result()?;
    let is_part = plan.extent.is_part();
    let places = if is_part { prepared.outputs.files_of(plan.order.poses()) } else { prepared.outputs.files() };
    let transaction = Transaction::begin(places)?;
    transaction.warnings().iter().for_each(|warning| progress.warning(warning));
    let stages = Stages::new(prepared, plan, transfer.as_ref(), cache, progress);
    // A part without poses needs no stage.
    if is_part && plan.order.is_empty() {
        let report = assemble(prepared, plan, stages, Done::default(), cache, since_start)?;
        return Ok(Finished { report, failed: vec![] });
    }
    let measured = run_stages(prepared, plan, &stages, cache)?;
    if let Extent::Part(part) = &plan.extent
        && stages.bound_so_far().is_some_and(|bound| bound.motion().is_some())
    {
        part.check_motion()?;
        // A transfer that does not declare its motion is known only once it was bound.
        if cache.is_some() && plan.cached.as_ref().is_some_and(|cached| !cached.motion) {
            let message = "the poses turn out to be frames of one motion";
            return Err(Diagnostic::new(Kind::Busy, message).hint("run this again: it is known now").into());
        }
    }

    let mut staged = Vec::new();
    if let Some(path) = prepared.outputs.correspondence.as_ref().filter(|_| !is_part)
        && let Some(map) = stages.map()?
    {
        staged.push(written::correspondence(&transaction, path, map)?);
    }
    progress.poses(plan.order.len());
    let metrics = match plan.cached.as_ref().is_some_and(|cached| cached.measured) && measured.is_whole {
        true => MetricSet::for_verdicts(&prepared.metrics),
        false => info_span!("metrics").in_scope(|| MetricSet::bind(&prepared.metrics, context(prepared, &stages)))?,
    };
    let metrics = metrics.with_gates(&prepared.gates);
    let is_visual = prepared.outputs.are_visual() && !is_part;
    let thumbnails = is_visual.then(|| Thumbnails::new(prepared, stages.cached_map()));
    let measurer =
        Measurer { prepared, metrics: &metrics, measured: &measured.of_poses, thumbnails: thumbnails.as_ref() };
    let shapes = ShapeEditor::new(prepared, stages.pair());
    let runner = PoseRunner {
        prepared,
        transaction: &transaction,
        stages: &stages,
        measurer: &measurer,
        shapes: &shapes,
        is_part,
    };
    let clock = Clock::start();
    let Stream { poses, failed, files, mut warnings } =
        info_span!("poses").in_scope(|| Stream::run(&runner, progress))?;
    warnings.extend(shapes.warning(plan.order.poses()));
    warnings.extend(seams(prepared, plan, &stages).map(|seams| seams.warning()));
    drop(metrics);
    staged.extend(files);
    let of_poses = clock.stop("poses", "", Default::default());
    note_times(prepared, plan, &stages, cache, (&of_poses, &poses));
    stages.report(of_poses);
    if failed.len() == poses.len() && !is_part {
        return Err(Diagnostics { list: failed });
    }

    let Prepared { source, target, .. } = prepared;
    // Markers of a file were looked at before.
    let of_rest = stages.proposal().and_then(|proposal| {
        warning_of_rest([source, target], &prepared.poses, &prepared.formats, &proposal.markers())
    });
    progress.stage("writing");
    let _writing = info_span!("writing").entered();
    let done = Done { poses, failed: failed.len(), staged: &staged };
    let mut report = assemble(prepared, plan, stages, done, cache, since_start)?;
    let of_others = transaction.warnings().iter().cloned();
    let of_run = of_others.chain(warnings).chain(of_rest);
    report.warnings.splice(prepared.warnings.len()..prepared.warnings.len(), of_run);
    deduplicate(&mut report.warnings);
    if let Some(thumbnails) = thumbnails {
        report.target_view = Some(thumbnails.target_view());
        let visual = written::visual_outputs(&transaction, prepared, &report, thumbnails)?;
        report.outputs.extend(visual.iter().map(Staged::written));
        staged.extend(visual);
    }
    if !is_part {
        staged.push(written::report(&transaction, &prepared.outputs.report, &report)?);
    }
    transaction.commit(staged)?;
    Ok(Finished { report, failed })
}

/// The measurements of the poses of a run that are cached.
struct CachedMetrics {
    /// By the places of poses in the order of the run.
    of_poses: Vec<Option<PoseMetrics>>,
    /// Whether every pose that has a result has measurements.
    is_whole: bool,
}

/// Runs the stages that run once, as far as they are needed, and looks up measurements.
fn run_stages(prepared: &Prepared, plan: &Plan, stages: &Stages<'_>, cache: Option<&Cache>) -> Result<CachedMetrics> {
    stages.propose()?;
    let cached = cache.zip(plan.cached.as_ref());
    let measured = cached_metrics(prepared, plan, stages);
    let is_measured = cached.is_some_and(|(_, cached)| cached.measured) && measured.is_whole;
    if plan.needs_map(prepared, is_measured) {
        stages.map()?;
    } else {
        stages.cached_map();
    }
    match cached.and_then(|(_, cached)| cached.transfer.clone().filter(|_| cached.complete)) {
        Some(summary) => {
            let clock = Clock::start();
            stages.report(clock.stop("transfer", stages.transfer.typetag_name(), summary.figures).reused());
        }
        None => _ = stages.bound()?,
    }
    if let Some((cache, cached)) = cached {
        LastRun::of(&cached.keys).store(&cache.store, prepared);
    }
    Ok(measured)
}

/// The cached measurements of the poses of a run, where they will do.
fn cached_metrics(prepared: &Prepared, plan: &Plan, stages: &Stages<'_>) -> CachedMetrics {
    let (order, alone) = (&plan.order, are_measured_alone(prepared));
    let none = || CachedMetrics { of_poses: vec![None; order.len()], is_whole: false };
    // Pictures show more than measurements hold.
    if prepared.outputs.are_visual() && !plan.extent.is_part() {
        return none();
    }
    let Some(cache) = stages.pose_cache() else { return none() };
    let of_place = |place: usize| {
        // What is measured without the poses before is not what is cached.
        let is_exact = alone || order.has_all_before::<MEASURED_BEFORE>(place);
        cache.metrics(order.poses()[place]).filter(|_| is_exact)
    };
    let of_poses: Vec<_> = (0..order.len()).into_par_iter().map(of_place).collect();
    let missing = order.poses().par_iter().zip(&of_poses).filter(|(_, metrics)| metrics.is_none());
    let is_whole = missing.map(|(pose, _)| *pose).all(|pose| !cache.contains(pose));
    CachedMetrics { of_poses, is_whole }
}

/// Stores how long the run took, if it has computed poses.
fn note_times(
    prepared: &Prepared,
    plan: &Plan,
    stages: &Stages<'_>,
    cache: Option<&Cache>,
    (of_poses, poses): (&StageReport, &[PoseReport]),
) {
    let computed = poses.iter().filter(|pose| !pose.reused && pose.error.is_none()).count();
    let Some((cache, cached)) = cache.zip(plan.cached.as_ref()).filter(|_| computed > 0) else { return };
    if let Some(seconds) = stages.seconds_of_binding() {
        let timing = Timing {
            threads: rayon::current_num_threads(),
            start_seconds: prepared.seconds() + seconds,
            pose_seconds: Some(of_poses.seconds / computed as f64),
            peak_memory_bytes: usage().peak_memory_bytes,
        };
        timing.store(cache, cached.keys.transfer.key);
    }
}

/// What metrics are bound to.
fn context<'a>(prepared: &'a Prepared, stages: &'a Stages<'_>) -> MetricContext<'a> {
    MetricContext {
        rest: &prepared.target.sequence.rest,
        surface: prepared.target.seen_surface(),
        pair: Some(stages.pair()),
        map: stages.cached_map(),
    }
}

fn deduplicate(warnings: &mut Vec<String>) {
    let mut seen = HashSet::new();
    warnings.retain(|warning| seen.insert(warning.clone()));
}
