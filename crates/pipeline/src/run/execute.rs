//! Executing a plan.

use mimesh_core::{
    Error,
    stage::{MetricContext, Proposal, ProposedPair},
};
use mimesh_document::{Diagnostic, Diagnostics, Kind, diagnostic::Result};
use mimesh_markers::IntoDiagnostic;
use rayon::prelude::*;
use serde_json::Value;
use tracing::info_span;

use super::{measure::Measurer, poses::PoseRunner, stages::Stages, stream::Stream, written};
use crate::{
    cache::{Cache, LastRun},
    check::no_pose_fits,
    input::{InputFile, Prepared},
    json::to_value,
    metrics::{Gate, Level, MetricSet, PoseMetrics, Reason, landmark_doubt, over_poses},
    pictures::Thumbnails,
    plan::Plan,
    progress::Progress,
    report::{Clock, InputReport, MeshFigures, PoseReport, ProposedMarker, Report, RunOf, usage},
    rest_choice::warning_of_rest,
    shapes::ShapeEditor,
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
    let name = |worker| format!("worker {}", worker + 1);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).thread_name(name).build();
    let pool = pool.map_err(|error| Diagnostic::new(Kind::Internal, format!("cannot start threads: {error}")))?;
    // The threads of the pool are in no span.
    let span = info_span!("run", "type" = &*prepared.variant.name);
    pool.install(|| span.in_scope(|| execute(prepared, plan, cache, progress)))
}

fn execute(prepared: &Prepared, plan: &Plan, cache: Option<&Cache>, progress: &dyn Progress) -> Result<Finished> {
    let Some(transfer) = &prepared.pipeline.transfer else {
        return Err(Diagnostic::new(Kind::Internal, "a pipeline without a transfer was taken for checked").into());
    };
    let since_start = Clock::start();
    Diagnostics { list: no_pose_fits(prepared) }.into_result()?;
    let transaction = Transaction::begin(prepared.outputs.files())?;
    transaction.warnings().iter().for_each(|warning| progress.warning(warning));
    let cached = cache.zip(plan.cached.as_ref());
    let stages = Stages::new(prepared, transfer.as_ref(), cached, progress);
    stages.propose()?;
    let measured = cached_metrics(prepared, plan, &stages);
    if plan.needs_map(prepared, measured.is_some()) {
        stages.map()?;
    } else {
        stages.cached_map();
    }
    match cached.and_then(|(_, cached)| cached.transfer.clone().filter(|_| cached.complete)) {
        Some(summary) => {
            let clock = Clock::start();
            stages.report(clock.stop("transfer", transfer.typetag_name(), summary.figures).reused());
        }
        None => _ = stages.bound()?,
    }
    if let Some((cache, cached)) = cached {
        LastRun::of(&cached.keys).store(&cache.store, prepared);
    }

    let mut staged = Vec::new();
    if let Some(path) = &prepared.outputs.correspondence
        && let Some(map) = stages.map()?
    {
        staged.push(written::correspondence(&transaction, path, map)?);
    }
    progress.poses(prepared.poses.len());
    let metrics = match measured {
        Some(_) => MetricSet::for_verdicts(&prepared.metrics),
        None => info_span!("metrics").in_scope(|| MetricSet::bind(&prepared.metrics, context(prepared, &stages)))?,
    };
    let metrics = metrics.with_gates(&prepared.gates);
    let thumbnails = prepared.outputs.are_visual().then(|| Thumbnails::new(prepared, stages.cached_map()));
    let measurer =
        Measurer { prepared, metrics: &metrics, measured: measured.as_deref(), thumbnails: thumbnails.as_ref() };
    let shapes = ShapeEditor::new(prepared, stages.pair());
    let runner =
        PoseRunner { prepared, transaction: &transaction, stages: &stages, measurer: &measurer, shapes: &shapes };
    let clock = Clock::start();
    let Stream { poses, failed, files, mut warnings } =
        info_span!("poses").in_scope(|| Stream::run(&runner, progress))?;
    warnings.extend(shapes.warning());
    drop(metrics);
    staged.extend(files);
    stages.report(clock.stop("poses", "", Default::default()));
    if failed.len() == poses.len() {
        return Err(Diagnostics { list: failed });
    }

    let Prepared { source, target, .. } = prepared;
    // Markers of a file were looked at before.
    let of_rest = stages.proposal().and_then(|proposal| {
        warning_of_rest([source, target], &prepared.poses, &prepared.formats, &proposal.markers())
    });
    progress.stage("writing");
    let _writing = info_span!("writing").entered();
    let mut report = assemble(prepared, stages, poses, &failed, &staged, cache, since_start)?;
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
    staged.push(written::report(&transaction, &prepared.outputs.report, &report)?);
    transaction.commit(staged)?;
    Ok(Finished { report, failed })
}

/// The cached measurements of all poses, where they will do.
fn cached_metrics(prepared: &Prepared, plan: &Plan, stages: &Stages<'_>) -> Option<Vec<PoseMetrics>> {
    let measured = plan.cached.as_ref().is_some_and(|cached| cached.measured);
    if !measured {
        return None;
    }
    let poses = stages.pose_cache()?;
    (0..prepared.poses.len()).into_par_iter().map(|i| poses.metrics(i)).collect()
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

/// The report of a run whose poses are done.
fn assemble(
    prepared: &Prepared,
    stages: Stages<'_>,
    poses: Vec<PoseReport>,
    failed: &[Diagnostic],
    staged: &[Staged],
    cache: Option<&Cache>,
    since_start: Clock,
) -> Result<Report> {
    let clock = Clock::start();
    let proposed_markers = proposed_markers(prepared, stages.proposal());
    let doubt = stages.proposal().and_then(landmark_doubt);
    let inputs = inputs(prepared)?;
    stages.report(clock.stop("writing", "", Default::default()));
    if let Some(cache) = cache {
        cache.store.clean_up();
    }
    let unmeasured: Vec<String> =
        prepared.gates.iter().filter(|gate| !is_measured(gate, &poses)).map(unmeasured_gate).collect();
    let of_cache = cache.map(Cache::warnings).unwrap_or_default();
    let stages = stages.into_reports();
    let rest_verdict = poses.iter().find_map(|pose| pose.rest_verdict.clone());
    let rest_verdict = match doubt {
        Some(doubt) => Some(rest_verdict.unwrap_or_default().with(doubt)),
        None => rest_verdict,
    };
    let shared = rest_verdict.as_ref().map(|verdict| verdict.level);
    Ok(Report {
        mimesh: env!("CARGO_PKG_VERSION").into(),
        status: if failed.is_empty() { "done" } else { "partly" }.into(),
        pipeline: prepared.file.clone(),
        place: prepared.outputs.report.clone(),
        settings: settings(prepared),
        set: prepared.set.clone(),
        threads: rayon::current_num_threads(),
        inputs,
        source: MeshFigures::new(&prepared.source),
        target: MeshFigures::new(&prepared.target),
        choices: prepared.choices.clone(),
        markers: prepared.markers().len(),
        proposed_markers,
        run: RunOf::new(&prepared.variant),
        verdict: worst(&poses).max(shared).max(unmeasured.first().map(|_| Level::Failed)),
        rest_verdict,
        target_view: None,
        gates: prepared.gates.iter().map(|gate| (gate.key.clone(), gate.limit.into())).collect(),
        warnings: prepared.warnings.iter().cloned().chain(unmeasured).chain(of_cache).collect(),
        metrics: over_poses(&poses),
        seconds: prepared.seconds() + since_start.seconds(),
        stages,
        poses,
        outputs: staged.iter().map(Staged::written).collect(),
        process: usage(),
    })
}

/// The markers that a stage proposed, as files count their points.
fn proposed_markers(prepared: &Prepared, proposal: Option<&Proposal>) -> Vec<ProposedMarker> {
    let of_file = |pair: &ProposedPair| ProposedMarker {
        name: pair.marker.name.clone(),
        source: prepared.source.surface.mesh_point(pair.marker.source),
        target: prepared.target.surface.mesh_point(pair.marker.target),
        confidence: pair.confidence,
    };
    proposal.into_iter().flat_map(|proposal| proposal.pairs.iter().map(of_file)).collect()
}

/// The settings in full.
fn settings(prepared: &Prepared) -> Value {
    let mut settings = to_value(&prepared.pipeline);
    settings["metrics"] = to_value(&prepared.metrics);
    settings["formats"] = to_value(prepared.formats.all());
    settings
}

/// Size and hash of every file that was read.
fn inputs(prepared: &Prepared) -> Result<Vec<InputReport>> {
    let report = |input: &InputFile| match prepared.hashes.get(&input.path) {
        Some(file) => {
            let (role, path) = (input.role.to_owned(), input.path.clone());
            Some(Ok(InputReport { role, path, bytes: file.bytes, blake3: file.blake3 }))
        }
        // A pose that cannot be read has a diagnostic of its own.
        None if input.is_pose() => None,
        None => {
            let error = std::io::Error::from(std::io::ErrorKind::NotFound);
            Some(Err(Error::read(&input.path, error).into_diagnostic().into()))
        }
    };
    prepared.inputs.par_iter().filter_map(report).collect()
}

/// The warning about a gate whose statistic no pose has.
fn unmeasured_gate(gate: &Gate) -> String {
    format!(
        "the gate `{}` is broken: {} gave `{}` for no pose; remove the gate, or give the metric what it needs",
        gate.key, gate.metric, gate.statistic
    )
}

/// Whether the statistic of `gate` was measured in any of `poses`, or a verdict says that it could not be.
fn is_measured(gate: &Gate, poses: &[PoseReport]) -> bool {
    let is_reason = |reason: &Reason| reason.level == Level::Failed && reason.metric == gate.metric;
    poses.iter().any(|pose| {
        pose.metrics.contains(&gate.metric, &gate.statistic)
            || [&pose.verdict, &pose.rest_verdict]
                .into_iter()
                .flatten()
                .any(|verdict| verdict.reasons.iter().any(is_reason))
    })
}

/// The worst verdict of any pose.
fn worst(poses: &[PoseReport]) -> Option<Level> {
    poses.iter().filter_map(|pose| Some(pose.verdict.as_ref()?.level)).max()
}

fn deduplicate(warnings: &mut Vec<String>) {
    let mut seen = std::collections::HashSet::new();
    warnings.retain(|warning| seen.insert(warning.clone()));
}
