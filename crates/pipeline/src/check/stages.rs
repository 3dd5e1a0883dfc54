//! What the stages themselves refuse, and the files among their settings.

use std::path::Path;

use mimesh_core::{
    Error,
    stage::{Marker, ProximityGraph, TransferPair},
};
use mimesh_document::{At, Diagnostic, Kind, Step, path};
use mimesh_markers::IntoDiagnostic;

use super::{
    findings::{Findings, Scope},
    noise::noise_warning,
};
use crate::{input::RestMesh, schema::FileSetting, spec::Pipeline};

/// Checks the stages of `pipeline` against the meshes.
pub(super) fn check_stages(
    scope: Scope<'_>,
    found: &mut Findings,
    pipeline: &Pipeline,
    meshes: [&RestMesh; 2],
    markers: &[Marker],
    proximity: Option<&ProximityGraph>,
) {
    let [source, target] = meshes;
    let before = found.diagnostics.len();
    let pair = TransferPair { source: &source.surface, target: target.seen_surface(), markers, proximity };
    if let Some(correspondence) = &pipeline.correspondence
        && let Err(error) = correspondence.check(pair)
    {
        refused(scope, found, "correspondence", correspondence.typetag_name(), error);
    }
    if let Some(transfer) = &pipeline.transfer
        && let Err(error) = transfer.check(pair)
    {
        refused(scope, found, "transfer", transfer.typetag_name(), error);
    }
    if found.diagnostics.len() > before
        && let Some(noise) = noise_warning("target", target)
    {
        // What was refused may be that there are several components.
        for diagnostic in &mut found.diagnostics.list[before..] {
            let hint =
                diagnostic.hint.take().map_or_else(|| noise.clone(), |hint| format!("{noise}; otherwise {hint}"));
            diagnostic.hint = Some(hint);
        }
    }
}

/// Whether there are as many markers as the correspondence needs; a diagnostic if not.
pub(super) fn check_marker_count(
    scope: Scope<'_>,
    found: &mut Findings,
    pipeline: &Pipeline,
    markers: &[Marker],
) -> bool {
    let Some(correspondence) = &pipeline.correspondence else { return true };
    let needed = correspondence.markers_needed();
    if markers.len() >= needed {
        return true;
    }
    let count = match markers.len() {
        0 => "there are none".into(),
        count => format!("there are {count}"),
    };
    let message = format!("{} needs at least {needed} markers, {count}", correspondence.typetag_name());
    let hint = "a marker is a point of the source and the same point of the target: `markers: pairs.cons` (a count, then \
                `source, target` vertices from 0)";
    let at = if pipeline.markers.is_some() { path(["markers"]) } else { path(["correspondence"]) };
    found.wrong(scope, &at, At::Value, message, hint);
    false
}

/// Notes the files that settings name, with diagnostics for those that are missing.
pub(super) fn check_files(scope: Scope<'_>, found: &mut Findings, files: &[FileSetting]) {
    for FileSetting { path: at, file } in files {
        let role = role_of(at);
        if file == Path::new("") {
            found.wrong(scope, at, At::Value, "expected a path, found an empty string", "name a file, or remove it");
        } else {
            found.input(scope, role, file, at);
        }
    }
}

/// The slot of the stage that names a file.
fn role_of(at: &[Step]) -> &'static str {
    let slot = at.first().map(Step::to_string).unwrap_or_default();
    crate::parse::slots().into_iter().find(|known| *known == slot).unwrap_or("setting")
}

/// Adds the diagnostic of an error of the stage `name` in `slot`.
pub(super) fn refused(scope: Scope<'_>, found: &mut Findings, slot: &'static str, name: &str, error: Error) {
    let at = path([slot]);
    if scope.is_reported(&error, &at) {
        return;
    }
    let diagnostic = error.into_diagnostic().doing(format!("{slot} ({name})"));
    let kind = if diagnostic.kind == Kind::Internal { Kind::BadData } else { diagnostic.kind };
    found.diagnostics.push(Diagnostic { kind, ..diagnostic.at(scope.document.location(&at, At::Value)) });
}
