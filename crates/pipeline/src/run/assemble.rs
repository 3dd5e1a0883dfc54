//! The report of a run, put together when its poses are done.

use std::{collections::HashSet, path::Path};

use mimesh_core::{
    Error,
    stage::{Proposal, ProposedPair},
};
use mimesh_document::diagnostic::Result;
use mimesh_markers::IntoDiagnostic;
use rayon::prelude::*;
use serde_json::Value;

use super::stages::Stages;
use crate::{
    cache::Cache,
    input::{InputFile, PoseFrom, Prepared},
    json::to_value,
    metrics::{Gate, Level, Reason, landmark_doubt, over_poses},
    plan::Plan,
    report::{Clock, InputReport, MeshFigures, PartReport, PoseReport, ProposedMarker, Report, RunOf, usage},
    shard::{Part, PoseSelection},
    staging::Staged,
};

/// What a run has done.
#[derive(Debug, Default)]
pub(super) struct Done<'a> {
    /// The poses in their order.
    pub poses: Vec<PoseReport>,
    /// How many of them failed.
    pub failed: usize,
    /// The files so far, in temporary places.
    pub staged: &'a [Staged],
}

/// The report of a run whose poses are done.
///
/// # Errors
///
/// If an input is no longer there.
pub(super) fn assemble(
    prepared: &Prepared,
    plan: &Plan,
    stages: Stages<'_>,
    done: Done<'_>,
    cache: Option<&Cache>,
    since_start: Clock,
) -> Result<Report> {
    let Done { poses, failed, staged } = done;
    let clock = Clock::start();
    let proposed_markers = proposed_markers(prepared, stages.proposal());
    let doubt = stages.proposal().and_then(landmark_doubt);
    let inputs = inputs(prepared, plan)?;
    stages.report(clock.stop("writing", "", Default::default()));
    if let Some(cache) = cache {
        cache.store.clean_up();
    }
    // A part need not have what the gates look at.
    let gates = prepared.gates.iter().filter(|_| !plan.extent.is_part());
    let unmeasured: Vec<String> = gates.filter(|gate| !is_measured(gate, &poses)).map(unmeasured_gate).collect();
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
        status: if failed == 0 { "done" } else { "partly" }.into(),
        pipeline: prepared.file.clone(),
        place: if plan.extent.is_part() { Default::default() } else { prepared.outputs.report.clone() },
        part: plan.extent.part().map(part),
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

/// Which poses of the run a part of it has.
fn part(part: &Part) -> PartReport {
    let shard = match &part.selection {
        PoseSelection::Shard(shard) => Some(shard.to_string()),
        PoseSelection::Frames(_) => None,
    };
    PartReport { frames: part.ranges(), poses: part.poses.len(), of: part.of, shard, warm: part.warm }
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
fn inputs(prepared: &Prepared, plan: &Plan) -> Result<Vec<InputReport>> {
    let of_part: Option<HashSet<&Path>> = plan.extent.part().map(|part| {
        let files = part.poses.iter().filter_map(|&i| match &prepared.poses[i].from {
            PoseFrom::File(path) => Some(path.as_path()),
            PoseFrom::Held(_) => None,
        });
        files.collect()
    });
    let is_read = |input: &&InputFile| !input.is_pose() || of_part.as_ref().is_none_or(|of| of.contains(&*input.path));
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
    prepared.inputs.par_iter().filter(is_read).filter_map(report).collect()
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
