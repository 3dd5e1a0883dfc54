//! Which seams of the meshes open: named by the pipeline, or parted by the poses of the source.

use std::sync::Arc;

use mimesh_core::{Error, mesh::Seams};
use mimesh_document::{At, Step, path};
use rayon::prelude::*;

use super::{
    findings::{Findings, Scope},
    rest_meshes::{self, in_file},
};
use crate::{
    cache::{Cache, OpenedSeams, opened_seams_key},
    input::{FileHashes, PoseInput, RestMesh, read_pose},
    seam_points::SeamPoint,
    spec::Target,
};

/// What the decision over a source's seams is cached by.
#[derive(Clone, Copy, Debug)]
pub(super) struct SeamCache<'a> {
    /// The cache, if there is one.
    pub cache: Option<&'a Cache>,
    /// Hashes of the poses' files.
    pub hashes: &'a FileHashes,
}

/// The target with the seams open that the pipeline names, as far as it can be had.
pub(super) fn target(scope: Scope<'_>, found: &mut Findings, target: &Target) -> Option<RestMesh> {
    let mut mesh = rest_meshes::target(scope, found, target)?;
    match &target.opened_seams {
        Some(points) => open_named(scope, found, "target", &mut mesh, points).then_some(mesh),
        None => Some(mesh),
    }
}

/// Opens the seams of `mesh` that the pipeline names in the slot `name`; `false` if one of them does not exist.
pub(super) fn open_named(
    scope: Scope<'_>,
    found: &mut Findings,
    name: &str,
    mesh: &mut RestMesh,
    points: &[SeamPoint],
) -> bool {
    let before = found.diagnostics.len();
    let opened = mesh.seams().and_then(|seams| {
        for (i, point) in points.iter().enumerate() {
            if !seams.pairs().iter().any(|pair| point.opens(*pair)) {
                let at: Vec<Step> = [&path([name, "opened_seams"])[..], &[Step::Index(i)]].concat();
                let message = format!("no seam of the {name} is welded at {point}");
                let hint =
                    "name vertices along boundaries that lie at one place and run in opposite directions, from 0";
                found.wrong(scope, &at, At::Value, message, hint);
            }
        }
        let is_opened = |pair: &&[u32; 2]| points.iter().any(|point| point.opens(**pair));
        mesh.open_seams(seams.pairs().iter().filter(is_opened).copied().collect())
    });
    if let Err(error) = opened {
        refused(found, mesh, error);
    }
    found.diagnostics.len() == before
}

/// Opens the seams of the source that its `poses` part, all of which are read once if no cached result says it.
///
/// Poses that cannot be read are left out; they are reported when their turn comes.
pub(super) fn open_parted(
    scope: Scope<'_>,
    found: &mut Findings,
    mesh: &mut RestMesh,
    poses: &[PoseInput],
    by: SeamCache<'_>,
) {
    if !mesh.has_seams() {
        return;
    }
    let key = by
        .cache
        .and_then(|cache| Some((cache, opened_seams_key(mesh, poses, scope.formats, by.hashes, cache.program())?)));
    let cached = key.as_ref().and_then(|(cache, key)| cache.get::<OpenedSeams>("opened_seams", key.key));
    let decided = match cached {
        Some(decided) => Ok(decided),
        None => parted(scope, mesh, poses).map(|opened| {
            let decided = OpenedSeams(opened);
            if let Some((cache, key)) = &key {
                cache.put("opened_seams", key.key, &decided);
            }
            decided
        }),
    };
    match decided.and_then(|OpenedSeams(opened)| mesh.open_seams(opened)) {
        Ok(()) => {}
        Err(error) => refused(found, mesh, error),
    }
}

/// The seams that any of `poses` parts; a pose a thread is in memory.
fn parted(scope: Scope<'_>, mesh: &RestMesh, poses: &[PoseInput]) -> Result<Vec<[u32; 2]>, Error> {
    let seams = mesh.seams()?;
    let see = |mut seams: Seams, pose: &PoseInput| {
        if let Ok(positions) = read_pose(mesh, scope.formats, &pose.from) {
            // A pose of another length is refused when its turn comes.
            let _ = seams.see(&positions);
        }
        seams
    };
    let all = poses.par_iter().fold(|| seams.clone(), see).reduce(|| seams.clone(), Seams::or);
    Ok(all.opened())
}

/// The target with its seams open where those of the source are, if both have the same polygons.
///
/// Seams of another target stay welded; a sentence tells how to open them.
pub(super) fn open_like(found: &mut Findings, source: &RestMesh, target: Arc<RestMesh>) -> Arc<RestMesh> {
    let opened = &source.welding.opened;
    if opened.is_empty() || !target.has_seams() {
        return target;
    }
    if source.sequence.rest.polygons != target.sequence.rest.polygons {
        found.warnings.push(format!(
            "the source opens at {} in its poses, and boundaries of the target that coincide stay closed: name those that open by \
             `opened_seams` in `target`",
            places(opened.len())
        ));
        return target;
    }
    let open = || {
        let seams = target.seams()?;
        let shared = seams.pairs().iter().filter(|pair| opened.binary_search(pair).is_ok());
        let mut open = RestMesh::new(
            target.path.clone(),
            target.selection.clone(),
            target.sequence.clone(),
            target.welding.clone(),
        )?;
        open.of_file = target.of_file.clone();
        open.open_seams(shared.copied().collect())?;
        Ok(Arc::new(open))
    };
    open().unwrap_or_else(|error| {
        refused(found, &target, error);
        target.clone()
    })
}

fn places(count: usize) -> String {
    if count == 1 { "1 place of its seams".into() } else { format!("{count} places of its seams") }
}

fn refused(found: &mut Findings, mesh: &RestMesh, error: Error) {
    let diagnostic = match &mesh.path {
        Some(file) => in_file(file, error),
        None => mimesh_markers::IntoDiagnostic::into_diagnostic(error),
    };
    found.diagnostics.push(diagnostic);
}
