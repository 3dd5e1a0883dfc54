//! Checking markers.

use std::path::Path;

use mimesh_core::stage::Marker;
use mimesh_document::{Diagnostic, Kind, Location, Step, path};
use mimesh_markers::{
    MarkerFile, MarkerFiles, MarkerMesh, MarkerStatus, MeshRole, Note, PointSource, from_landmarks, notation::Notation,
};

use super::findings::{Findings, Scope};
use crate::{
    choices::Choice,
    input::{FileHashes, RestMesh},
    marker_source::CLICKS,
};

impl RestMesh {
    /// The mesh as far as markers need it.
    pub fn for_markers(&self, role: MeshRole) -> MarkerMesh<'_> {
        MarkerMesh { role, mesh: &self.sequence.rest, surface: &self.surface }
    }

    /// The mesh as its file has it, which points of marker files lie on; a pose may serve as the rest in its place.
    pub fn as_in_file(&self, role: MeshRole) -> MarkerMesh<'_> {
        match &self.of_file {
            Some((mesh, surface)) => MarkerMesh { role, mesh, surface },
            None => self.for_markers(role),
        }
    }
}

/// The markers between two meshes, as far as they can be had; a pipeline without files has those of equal landmarks.
pub(super) fn markers(
    scope: Scope<'_>,
    found: &mut Findings,
    files: Option<&MarkerFiles>,
    source: Option<&RestMesh>,
    target: Option<&RestMesh>,
    hashes: &FileHashes,
) -> Option<Vec<Marker>> {
    let Some(files) = files else {
        let (source, target) = (source?, target?);
        let landmarks = from_landmarks(&source.sequence, &target.sequence);
        return resolve(found, &landmarks, source, target);
    };
    let markers = of_files(scope, found, files, &path(["markers"]), source, target, hashes)?;
    resolve(found, &markers, source?, target?)
}

/// The markers that the user clicked, beside the stage that proposes others; those that are only proposed are left to the stage.
pub(super) fn clicks(
    scope: Scope<'_>,
    found: &mut Findings,
    files: &MarkerFiles,
    source: Option<&RestMesh>,
    target: Option<&RestMesh>,
    hashes: &FileHashes,
) -> Option<Vec<Marker>> {
    let mut markers = of_files(scope, found, files, &path(["markers", CLICKS]), source, target, hashes)?;
    let all = markers.pairs.len();
    markers.pairs.retain(|pair| pair.status == MarkerStatus::Confirmed);
    let proposed = all - markers.pairs.len();
    if proposed > 0 {
        let (pairs, are) = if proposed == 1 { ("pair", "is") } else { ("pairs", "are") };
        found.warnings.push(format!(
            "{proposed} {pairs} of the clicks {are} only proposed, and found anew; `status: confirmed` keeps one"
        ));
    }
    resolve(found, &markers, source?, target?)
}

/// The markers in `files`, which are named at `slot`.
fn of_files(
    scope: Scope<'_>,
    found: &mut Findings,
    files: &MarkerFiles,
    slot: &[Step],
    source: Option<&RestMesh>,
    target: Option<&RestMesh>,
    hashes: &FileHashes,
) -> Option<MarkerFile> {
    let files = marker_files(scope, files, slot);
    let before = found.diagnostics.len();
    for (key, file) in files.named() {
        let role = match key {
            Some("source") => "source markers",
            Some(_) => "target markers",
            None => "markers",
        };
        found.input(scope, role, file, &at_key(slot, key));
    }
    if found.diagnostics.len() > before {
        return None;
    }
    let read = PointSource::read(&files, scope.formats);
    let read = read.map_err(|failure| found.diagnostics.extend(failure.into_iter().map(as_named))).ok()?;
    let (source, target) = (source?, target?);
    let attached = read.attach([source.as_in_file(MeshRole::Source), target.as_in_file(MeshRole::Target)], false);
    let attached = attached.map_err(|failure| found.diagnostics.extend(failure)).ok()?;
    found.warnings.extend(attached.warnings);
    let choice = |note: Note| Choice::new(format!("markers.{}", note.about), note.chosen, note.why);
    found.choices.extend(attached.notes.into_iter().map(choice));
    if let Some(file) = files.one() {
        warn_of_changes(found, &attached.markers, file, [source, target], hashes);
    }
    Some(attached.markers)
}

/// The files as seen from the current folder.
pub(super) fn marker_files(scope: Scope<'_>, files: &MarkerFiles, slot: &[Step]) -> MarkerFiles {
    files.map(|key, file| scope.path(&at_key(slot, key), file))
}

/// A file whose notation does not fit its key is a fault of the pipeline.
fn as_named(diagnostic: Diagnostic) -> Diagnostic {
    let (Kind::Usage, Some(Location::File(file))) = (diagnostic.kind, &diagnostic.location) else { return diagnostic };
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let hint = match Notation::of(file) {
        Some(notation) if notation.holds_both_sides() => Some(format!("name it alone: `markers: {name}`")),
        Some(_) => Some(format!("name a file for each side: `markers: {{ source: {name}, target: … }}`")),
        None => diagnostic.hint.clone(),
    };
    Diagnostic { kind: Kind::BadPipeline, hint, ..diagnostic }
}

/// The path in the document of the file under `key` of `slot`, or of the only file.
fn at_key(slot: &[Step], key: Option<&str>) -> Vec<Step> {
    slot.iter().cloned().chain(key.map(|key| Step::Key(key.into()))).collect()
}

/// Warns of meshes that have changed since the markers in `file` were made.
fn warn_of_changes(
    found: &mut Findings,
    markers: &MarkerFile,
    file: &Path,
    meshes: [&RestMesh; 2],
    hashes: &FileHashes,
) {
    for (role, mesh) in MeshRole::BOTH.into_iter().zip(meshes) {
        let is_hashed = markers.reference(role).is_some_and(|reference| reference.blake3.is_some());
        let hash = mesh.path.as_ref().filter(|_| is_hashed).and_then(|path| hashes.hash(path));
        found.warnings.extend(markers.stale_warning(file, mesh.as_in_file(role), hash.as_deref()));
    }
}

fn resolve(found: &mut Findings, markers: &MarkerFile, source: &RestMesh, target: &RestMesh) -> Option<Vec<Marker>> {
    let resolved = markers.resolve([source.for_markers(MeshRole::Source), target.for_markers(MeshRole::Target)]);
    resolved.map_err(|failure| found.diagnostics.extend(failure)).ok()
}
