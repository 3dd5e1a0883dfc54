//! Parts of a pipeline, for commands that need no more: its source, or its two meshes.

use std::path::Path;

use mimesh_core::{plugin, stage::KeyPoints};
use mimesh_document::{At, Diagnostic, Document, diagnostic::Result};

use super::{
    common::{Options, check_formats, check_registry, pipeline_files, refused_without_reason},
    findings::{Findings, Scope},
    markers::marker_files,
    poses, rest_meshes,
    run_diagnostics::RunDiagnostics,
    seams::SeamCache,
};
use crate::{
    cache::Cache,
    compose::compose_source,
    formats::Formats,
    input::{FileHashes, Meshes, PreparedSource},
    parse::{Parsed, Required, parse},
    schema::resolve_files,
};

/// Reads the source of the pipeline in `file`; of the rest only what concerns key points is looked at.
///
/// Which of its seams open is taken from `cache` if it is there.
///
/// # Errors
///
/// All that can be found wrong with that part without computing or reading poses.
pub fn prepare_source(file: &Path, options: &Options, cache: Option<&Cache>) -> Result<PreparedSource> {
    let (mut document, included, targets) = compose_source(file, &options.settings)?;
    resolve_files(&mut document);
    let mut found = Findings { inputs: pipeline_files(file, &included), ..Findings::default() };
    let Parsed { mut pipeline, rejected } = parse(&document, Required::Source, &mut found.diagnostics);
    let formats = Formats::new(std::mem::take(&mut pipeline.formats));
    let scope = Scope { document: &document, formats: &formats, rejected: &rejected };
    check_registry(&mut found);
    check_formats(scope, &mut found);
    let seam_cache = SeamCache { cache, hashes: &FileHashes::default() };
    let (source, poses) = poses::source(scope, &mut found, &pipeline.source, seam_cache);
    let markers = pipeline.markers.as_ref().and_then(|files| marker_files(scope, files).one().cloned());
    finish(found, file)?;
    let source = source.ok_or_else(refused_without_reason)?;
    let key_points = pipeline.key_points.take().ok_or_else(|| missing_key_points(&document))?;
    let target = pipeline.target.rest.filter(|_| targets == 1);
    Ok(PreparedSource { source, poses, formats, key_points, markers, target })
}

/// Reads the meshes of the pipeline in `file`; of the rest nothing is looked at but the names of its markers.
///
/// # Errors
///
/// All that is wrong with that part.
pub fn prepare_meshes(file: &Path, options: &Options) -> Result<Meshes> {
    let (document, included, _) = compose_source(file, &options.settings)?;
    let mut found = Findings { inputs: pipeline_files(file, &included), ..Findings::default() };
    let Parsed { mut pipeline, rejected } = parse(&document, Required::Meshes, &mut found.diagnostics);
    let formats = Formats::new(std::mem::take(&mut pipeline.formats));
    let scope = Scope { document: &document, formats: &formats, rejected: &rejected };
    let source = poses::rest_file(scope, &mut found, &pipeline.source);
    let target = rest_meshes::target(scope, &mut found, &pipeline.target);
    let markers = pipeline.markers.map(|files| marker_files(scope, &files));
    finish(found, file)?;
    let (source, target) = source.zip(target).ok_or_else(refused_without_reason)?;
    Ok(Meshes { source, target, markers })
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
