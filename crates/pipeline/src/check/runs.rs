//! Checking all runs that a file declares.

use std::{
    path::Path,
    sync::{Arc, OnceLock},
};

use mimesh_core::{
    Figures,
    stage::{Marker, Proximity, ProximityGraph, TransferPair},
};
use mimesh_document::{Document, diagnostic::Result, path};
use tracing::info_span;

use super::{
    chosen_runs::{ChosenRuns, choose_runs},
    common::{Options, check_formats, check_registry, pipeline_files, refused_without_reason},
    earlier::{foreign_report, look_around},
    findings::{Findings, Scope},
    ground_truth::ground_truth,
    markers::{clicks, markers},
    metrics::{check_bound, gates, metrics},
    outputs::{REPORT, outputs},
    pictures::view_script,
    rest_meshes::{check_inside_out, check_mirrored},
    run_diagnostics::RunDiagnostics,
    seams::{SeamCache, open_like},
    shapes::{check_masks, shapes},
    shared::SharedMeshes,
    stages::{check_files, check_marker_count, check_stages, refused},
    units,
    writable::{Destination, conflict, name_reports},
};
use crate::{
    cache::{Cache, proximity_key},
    choices::{Open, choose_markers, choose_proximity, choose_stages, in_order},
    compose::{self, Run, Runs},
    formats::Formats,
    handedness,
    input::{self, FileHashes, InputFile, Prepared, ProximityInput, RestMesh},
    marker_source::MarkerSource,
    parse::{Parsed, Required, parse},
    report::Clock,
    rest_choice::warning_of_rest,
    schema::resolve_files,
    spec::Pipeline,
};

/// Reads and checks the pipeline in `file`, for every target and every combination of its matrix; at least one run.
///
/// The checks of stages look at the proximity graph of the target; it is taken from `cache` if it is there.
///
/// # Errors
///
/// All that can be found wrong with any run without computing or reading poses, each once.
pub fn prepare_all(file: &Path, options: &Options, cache: Option<&Cache>) -> Result<Vec<Prepared>> {
    let clock = Clock::start();
    let runs = compose::compose(file, &options.settings)?;
    let files = pipeline_files(file, &runs.included);
    prepare_runs(file, files, runs, options, cache, clock)
}

/// Checks the pipeline in `document`, which no file holds, as [`prepare_all`] does.
///
/// # Errors
///
/// Those of [`prepare_all`].
pub fn prepare_document(document: Document, options: &Options, cache: Option<&Cache>) -> Result<Vec<Prepared>> {
    let clock = Clock::start();
    let file = document.file.clone();
    let runs = compose::compose_document(document, vec![], &options.settings)?;
    prepare_runs(&file, vec![], runs, options, cache, clock)
}

fn prepare_runs(
    file: &Path,
    files: Vec<InputFile>,
    runs: Runs,
    options: &Options,
    cache: Option<&Cache>,
    mut clock: Clock,
) -> Result<Vec<Prepared>> {
    let _reading = info_span!("reading").entered();
    let Runs { runs, diagnostics, suppressed, warnings, .. } = runs;
    let (several, meshes) = (runs.len() > 1, SharedMeshes::default());
    // What is wrong with how runs are declared comes before which of them are wanted.
    let ChosenRuns { runs, other_reports } = match diagnostics.is_empty() {
        true => choose_runs(runs, options)?,
        false => ChosenRuns { runs, ..ChosenRuns::default() },
    };
    let mut collected = RunDiagnostics::new(&runs, diagnostics, suppressed);
    let mut shared = Shared { several, meshes, hashes: Arc::default(), cache };
    let mut prepared = Vec::new();
    for (i, run) in runs.into_iter().enumerate() {
        match prepare_one(file, &files, run, options, &mut shared, clock) {
            Ok(one) => prepared.push(one),
            Err(diagnostics) => collected.add(i, diagnostics),
        }
        clock = Clock::start();
    }
    if collected.is_empty() {
        name_reports(&mut prepared, &other_reports);
        collected.add_whole(conflict(&prepared));
        collected.add_whole(prepared.iter().filter_map(foreign_report));
        collected.add_whole(prepared.iter_mut().flat_map(look_around));
    }
    collected.finish(file)?;
    // Warnings of the file as a whole are those of its first run.
    if let Some(first) = prepared.first_mut() {
        first.warnings.splice(0..0, warnings);
    }
    Ok(prepared)
}

/// How many places of the source's and the target's seams open.
fn seam_figures(source: &RestMesh, target: &RestMesh) -> Figures {
    let mut figures = Figures::default();
    for (name, mesh) in [("source_seams_opened", source), ("target_seams_opened", target)] {
        if !mesh.welding.opened.is_empty() {
            figures.set(name, mesh.welding.opened.len());
        }
    }
    figures
}

/// What the runs of one file have in common.
#[derive(Debug)]
struct Shared<'a> {
    /// Whether there are several runs.
    several: bool,
    meshes: SharedMeshes,
    hashes: Arc<FileHashes>,
    cache: Option<&'a Cache>,
}

/// Checks one run; `clock` has been running since its reading began.
fn prepare_one(
    file: &Path,
    files_of_pipeline: &[InputFile],
    run: Run,
    options: &Options,
    shared: &mut Shared<'_>,
    clock: Clock,
) -> Result<Prepared> {
    let Run { variant, mut document } = run;
    let files = resolve_files(&mut document);
    let mut found = Findings { inputs: files_of_pipeline.to_vec(), ..Findings::default() };
    let Parsed { mut pipeline, rejected, open } = parse(&document, Required::Run, &mut found.diagnostics);
    let mut formats = Formats::new(std::mem::take(&mut pipeline.formats), options.reach(file));
    let units =
        units::of_target(Scope { document: &document, formats: &formats, rejected: &rejected }, &pipeline.target);
    units::declare(&mut formats, &document, units);
    let scope = Scope { document: &document, formats: &formats, rejected: &rejected };
    let found_mut = &mut found;
    check_registry(found_mut);
    check_formats(scope, found_mut);
    let seam_cache = SeamCache { cache: shared.cache, hashes: &shared.hashes };
    let (source, poses) = shared.meshes.source(scope, found_mut, &mut pipeline.source, seam_cache);
    let target = shared.meshes.target(scope, found_mut, &pipeline.target);
    let target = match &source {
        Some(source) if pipeline.target.opened_seams.is_none() => {
            target.map(|target| open_like(found_mut, source, target))
        }
        _ => target,
    };
    check_inside_out(found_mut, source.as_deref(), target.as_deref());
    let meshes = source.as_deref().zip(target.as_deref());
    if let Some((source, target)) = meshes {
        let pair = rest_pair(source, target);
        let metrics = pipeline.metrics.take();
        found_mut.choices.extend(choose_stages(&mut pipeline, open, pair, metrics.as_deref().unwrap_or_default()));
        pipeline.metrics = metrics;
    }
    let markers = marker_input(scope, found_mut, &mut pipeline, open, meshes, &shared.hashes);
    let clicks = match pipeline.markers.as_ref().and_then(MarkerSource::clicks) {
        Some(files) => clicks(
            scope,
            found_mut,
            files,
            meshes.map(|(source, _)| source),
            meshes.map(|(_, target)| target),
            &shared.hashes,
        ),
        None => Some(vec![]),
    };
    let are_proposed = pipeline.markers.as_ref().and_then(MarkerSource::stage).is_some();
    if are_proposed {
        check_mirrored(found_mut, source.as_deref(), target.as_deref());
    }
    let has_map = pipeline.correspondence.is_some();
    let are = input::poses_are(pipeline.source.poses_are, &poses);
    check_masks(scope, found_mut, pipeline.shapes.as_ref(), are);
    let (poses, shape_edits) = shapes(scope, found_mut, pipeline.shapes.as_ref(), poses, target.as_deref(), has_map);
    let truth = ground_truth(scope, found_mut, pipeline.truth.as_deref(), target.as_deref(), &poses);
    let metrics = metrics(scope, found_mut, pipeline.metrics.take(), &truth);
    let gates = gates(scope, found_mut, &pipeline.gates, &metrics, &truth);
    if let (Some(source), Some(target), Some(markers)) = (&source, &target, &markers) {
        found_mut.warnings.extend(warning_of_rest([source, target], &poses, scope.formats, markers));
        check_bound(scope, found_mut, &metrics, source, target, markers);
        found_mut.warnings.extend(handedness::warning_of_markers(source, target, markers));
    }
    check_files(scope, found_mut, &files);
    let meshes = source.as_deref().zip(target.as_deref());
    let proximity =
        stages_and_proximity(scope, found_mut, &mut pipeline, open.proximity, meshes, markers.as_deref(), shared);
    let out = options.out.as_deref().map(|given| Destination::new(given, &variant, shared.several));
    let report = options.report.as_deref().unwrap_or(REPORT);
    let poses_are = input::poses_are(pipeline.source.poses_are, &poses);
    let outputs = outputs(scope, found_mut, &pipeline, target.as_deref(), &poses, out.as_ref(), report);
    let sides = [source.as_deref(), target.as_deref()];
    let view_script = view_script(scope, found_mut, &pipeline, &outputs, sides, &options.view_script);
    let output_change = units::output_change(scope, found_mut, &pipeline, target.as_deref(), &outputs);
    found.diagnostics.into_result()?;
    let (Some(source), Some(target), Some(markers), Some(clicks)) = (source, target, markers, clicks) else {
        return Err(refused_without_reason().into());
    };
    let reading = clock.stop("reading", "", seam_figures(&source, &target));
    let reading = match &proximity {
        Some(proximity) => reading.without(&proximity.report),
        None => reading,
    };
    Ok(Prepared {
        file: file.into(),
        variant,
        set: options.settings.clone(),
        inputs: found.inputs,
        warnings: found.warnings,
        unfinished: vec![],
        choices: in_order(found.choices),
        hashes: shared.hashes.clone(),
        reading,
        formats,
        source,
        target,
        pipeline,
        document,
        poses,
        shape_edits,
        poses_are,
        markers: if are_proposed { OnceLock::new() } else { markers.into() },
        clicks,
        allow_commands: options.allow_commands,
        help: options.help.clone(),
        view_script,
        proximity,
        truth,
        metrics,
        gates,
        outputs,
        output_change,
    })
}

/// The two surfaces without markers.
fn rest_pair<'a>(source: &'a RestMesh, target: &'a RestMesh) -> TransferPair<'a> {
    TransferPair { source: &source.surface, target: target.seen_surface(), markers: &[], proximity: None }
}

/// The markers as far as they can be had; none where a stage proposes them, and where the pipeline wants none.
fn marker_input(
    scope: Scope<'_>,
    found: &mut Findings,
    pipeline: &mut Pipeline,
    open: Open,
    meshes: Option<(&RestMesh, &RestMesh)>,
    hashes: &FileHashes,
) -> Option<Vec<Marker>> {
    // What is wrong with them is reported, and what follows from it needs no diagnostic.
    if scope.rejected.iter().any(|at| at.starts_with(&path(["markers"]))) {
        return None;
    }
    // The run proposes them; what needs them is left to it.
    if pipeline.markers.as_ref().and_then(MarkerSource::stage).is_some()
        || (pipeline.markers.is_none() && !open.markers)
    {
        return Some(vec![]);
    }
    let files = pipeline.markers.as_ref().and_then(MarkerSource::files);
    let (source, target) = (meshes.map(|(source, _)| source), meshes.map(|(_, target)| target));
    let markers = markers(scope, found, files, source, target, hashes)?;
    if !open.markers {
        return Some(markers);
    }
    found.choices.extend(choose_markers(pipeline, &markers));
    Some(if pipeline.markers.is_some() { vec![] } else { markers })
}

/// Checks the stages, and computes the proximity graph that their checks need; chooses one if it is `open`.
fn stages_and_proximity(
    scope: Scope<'_>,
    found: &mut Findings,
    pipeline: &mut Pipeline,
    open: bool,
    meshes: Option<(&RestMesh, &RestMesh)>,
    markers: Option<&[Marker]>,
    shared: &Shared<'_>,
) -> Option<ProximityInput> {
    let markers = markers?;
    let are_proposed = pipeline.markers.as_ref().and_then(MarkerSource::stage).is_some();
    if !are_proposed && !check_marker_count(scope, found, pipeline, markers) {
        return None;
    }
    let (source, target) = meshes?;
    let given = pipeline.proximity.as_ref().map(|stage| proximity(stage.as_ref(), target, shared));
    let proximity = match given {
        Some(Ok(proximity)) => Some(proximity),
        Some(Err(error)) => {
            let name = pipeline.proximity.as_ref().map_or("", |stage| stage.typetag_name());
            refused(scope, found, "proximity", name, error);
            return None;
        }
        None if open => {
            let known = (!are_proposed).then_some(markers);
            let compute = |stage: &dyn Proximity| proximity(stage, target, shared);
            // What cannot be linked is refused by the stage that needs it.
            let chosen = choose_proximity(pipeline, rest_pair(source, target), known, compute).ok().flatten();
            chosen.map(|(choice, proximity)| {
                found.choices.push(choice);
                proximity
            })
        }
        None => None,
    };
    let graph = proximity.as_ref().map(|proximity| &proximity.graph);
    // What stages refuse may depend on markers, and a run finds it anyway.
    if !are_proposed {
        check_stages(scope, found, pipeline, [source, target], markers, graph);
    }
    proximity
}

/// The proximity graph of `target`: the cached one, or that of `stage`.
fn proximity(stage: &dyn Proximity, target: &RestMesh, shared: &Shared<'_>) -> mimesh_core::Result<ProximityInput> {
    let clock = Clock::start();
    let name = stage.typetag_name();
    let cached = shared.cache.and_then(|cache| {
        let key = proximity_key(stage, target, &shared.hashes, cache.program());
        cache.get::<ProximityGraph>("proximity", key.key)
    });
    if let Some(graph) = cached {
        let report = clock.stop("proximity", name, graph.figures.clone()).reused();
        return Ok(ProximityInput { graph, report });
    }
    let graph = info_span!("proximity", "type" = name).in_scope(|| stage.proximity(&target.surface))?;
    graph.check(&target.surface)?;
    let report = clock.stop("proximity", name, graph.figures.clone());
    Ok(ProximityInput { graph, report })
}
