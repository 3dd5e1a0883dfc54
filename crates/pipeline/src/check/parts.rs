//! Parts of a pipeline, for commands that need no more: its source, or its two meshes.

use std::path::{Path, PathBuf};

use mimesh_core::{plugin, stage::KeyPoints};
use mimesh_document::{At, Diagnostic, Document, Kind, Location, diagnostic::Result, path};
use mimesh_markers::MarkerFiles;

use super::{
    common::{Options, check_formats, check_registry, pipeline_files, refused_without_reason},
    findings::{Findings, Scope},
    markers::marker_files,
    poses,
    rest_meshes::{self, at_file},
    run_diagnostics::RunDiagnostics,
    seams::SeamCache,
    units,
};
use crate::{
    cache::Cache,
    compose::{Part, compose_part, compose_part_of},
    formats::Formats,
    input::{self, FileHashes, InputFile, Meshes, PosedMeshes, PreparedSource},
    marker_source::{CLICKS, MarkerSource, ProposedMarkers},
    parse::{Parsed, Required, parse},
    pose_files::Poses,
    schema::resolve_files,
};

/// Remedy: give the two meshes themselves instead of a pipeline.
pub const OTHER_MESHES: &str = "other_meshes";

/// Reads the source of the pipeline in `file`, and the other slots that concern key points.
///
/// Which of its seams open is taken from `cache` if it is there.
///
/// # Errors
///
/// All that can be found wrong with these slots without choosing points or reading poses.
pub fn prepare_source(file: &Path, options: &Options, cache: Option<&Cache>) -> Result<PreparedSource> {
    let slots = ["source", "target", "markers", "key_points", "formats"];
    let Part { mut document, included, targets } = compose_part(file, &options.settings, &slots)?;
    resolve_files(&mut document);
    let mut found = Findings { inputs: pipeline_files(file, &included), ..Findings::default() };
    let Parsed { mut pipeline, rejected, .. } = parse(&document, Required::Source, &mut found.diagnostics);
    let formats = Formats::new(std::mem::take(&mut pipeline.formats), options.reach(file));
    let scope = Scope { document: &document, formats: &formats, rejected: &rejected };
    check_registry(&mut found);
    check_formats(scope, &mut found);
    let seam_cache = SeamCache { cache, hashes: &FileHashes::default() };
    let (source, poses, _) = poses::source(scope, &mut found, &pipeline.source, seam_cache);
    let files_of_markers = pipeline
        .markers
        .as_ref()
        .and_then(MarkerSource::files)
        .map(|files| marker_files(scope, files, &path(["markers"])));
    let target = pipeline.target.rest.map(|rest| rest.file).filter(|_| targets.len() <= 1);
    let mut inputs = found.inputs.clone();
    let named = files_of_markers.iter().flat_map(MarkerFiles::named);
    inputs.extend(named.map(|(_, file)| InputFile { role: "markers", path: file.clone() }));
    let rest = target.iter().map(|rest| scope.path(&at_file(scope, "target"), rest));
    inputs.extend(rest.map(|path| InputFile { role: "target rest", path }));
    finish(found, file)?;
    let source = source.ok_or_else(refused_without_reason)?;
    let key_points = pipeline.key_points.take().ok_or_else(|| missing_key_points(&document))?;
    let markers = files_of_markers.and_then(|files| files.one().cloned());
    Ok(PreparedSource { source, poses, formats, key_points, markers, target, inputs })
}

/// Reads the meshes of the pipeline in `file`, and the names of its marker files.
///
/// # Errors
///
/// All that is wrong with these slots, and that there are several targets.
pub fn prepare_meshes(file: &Path, options: &Options) -> Result<Meshes> {
    let slots = ["source", "target", "markers", "correspondence", "formats"];
    let Part { mut document, included, targets } = compose_part(file, &options.settings, &slots)?;
    refuse_several(file, &targets)?;
    resolve_files(&mut document);
    let mut found = Findings { inputs: pipeline_files(file, &included), ..Findings::default() };
    let Parsed { mut pipeline, rejected, .. } = parse(&document, Required::Meshes, &mut found.diagnostics);
    let formats = Formats::new(std::mem::take(&mut pipeline.formats), options.reach(file));
    let scope = Scope { document: &document, formats: &formats, rejected: &rejected };
    let source = poses::rest_file(scope, &mut found, &pipeline.source, pipeline.source.poses.as_ref());
    let target = rest_meshes::target(scope, &mut found, &pipeline.target);
    let (markers, landmarks) = match pipeline.markers {
        None => (None, None),
        Some(MarkerSource::Files(files)) => (Some(marker_files(scope, &files, &path(["markers"]))), None),
        Some(MarkerSource::Stage(ProposedMarkers { stage, clicks })) => {
            (clicks.map(|files| marker_files(scope, &files, &path(["markers", CLICKS]))), Some(stage))
        }
    };
    finish(found, file)?;
    let (source, target) = source.zip(target).ok_or_else(refused_without_reason)?;
    Ok(Meshes { source, target, markers, landmarks, correspondence: pipeline.correspondence })
}

/// Reads what a person looks at of the pipeline in `document`, with the files that it `included`: its meshes, its poses and the names of
/// its marker files. Mistakes elsewhere, and poses that are missing, do not matter.
///
/// # Errors
///
/// All that is wrong with the meshes, and that there are several targets.
pub fn prepare_posed_meshes(
    document: Document,
    included: Vec<PathBuf>,
    options: &Options,
    cache: Option<&Cache>,
) -> Result<PosedMeshes> {
    let file = document.file.clone();
    let slots = ["source", "target", "markers", "formats", "pictures"];
    let Part { mut document, included, targets } = compose_part_of(document, included, &options.settings, &slots)?;
    refuse_several(&file, &targets)?;
    resolve_files(&mut document);
    let mut found = Findings { inputs: pipeline_files(&file, &included), ..Findings::default() };
    let Parsed { mut pipeline, rejected, .. } = parse(&document, Required::Meshes, &mut found.diagnostics);
    let formats = Formats::new(std::mem::take(&mut pipeline.formats), options.reach(&file));
    let scope = Scope { document: &document, formats: &formats, rejected: &rejected };
    let hashes = FileHashes::default();
    let (source, poses, chosen) =
        poses::source(scope, &mut found, &pipeline.source, SeamCache { cache, hashes: &hashes });
    let target = rest_meshes::target(scope, &mut found, &pipeline.target);
    let units = [units::of_source(scope, &pipeline.source), units::of_target(scope, &pipeline.target)];
    let (markers, landmarks) = match pipeline.markers {
        None => (None, None),
        Some(MarkerSource::Files(files)) => (Some(marker_files(scope, &files, &path(["markers"]))), None),
        Some(MarkerSource::Stage(ProposedMarkers { stage, clicks })) => {
            (clicks.map(|files| marker_files(scope, &files, &path(["markers", CLICKS]))), Some(stage))
        }
    };
    let fps = match pipeline.source.poses.as_ref().or(chosen.as_ref()) {
        Some(Poses::Clips(clips)) => clips.fps,
        _ => None,
    };
    let Some((source, target)) = source.zip(target) else {
        finish(found, &file)?;
        return Err(refused_without_reason().into());
    };
    let poses_are = input::poses_are(pipeline.source.poses_are, &poses);
    Ok(PosedMeshes {
        source,
        target,
        poses,
        poses_are,
        fps,
        units,
        formats,
        markers,
        landmarks,
        warnings: found.warnings,
    })
}

fn refuse_several(file: &Path, targets: &[String]) -> Result<()> {
    if targets.len() <= 1 {
        return Ok(());
    }
    let message = format!("the pipeline has several targets ({}), expected one", targets.join(", "));
    let diagnostic = Diagnostic::new(Kind::Usage, message).at(Location::File(file.into()));
    Err(diagnostic.remedy(OTHER_MESHES, "", "give the two meshes themselves").into())
}

/// All diagnostics in the order of the file, if there are any.
fn finish(found: Findings, file: &Path) -> Result<()> {
    RunDiagnostics::of_one(found.diagnostics).finish(file)
}

fn missing_key_points(document: &Document) -> Diagnostic {
    let names: Vec<_> = plugin::instances::<dyn KeyPoints>().iter().map(|(name, _)| *name).collect();
    let hint = format!("name the stage that chooses them, e.g. `key_points: {{ type: {} }}`", names.join(" | "));
    document.diagnostic(&[], At::Value, "missing key `key_points`").hint(hint)
}
