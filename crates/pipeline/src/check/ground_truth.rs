//! Checking the known results.

use std::path::{Path, PathBuf};

use mimesh_core::{
    mesh::Pose,
    stage::{PoseChoice, Selection},
};
use mimesh_document::{At, path};

use super::{
    findings::{Findings, Scope},
    held_poses::resting_alike,
    rest_meshes::in_file,
};
use crate::{
    input::{GroundTruth, PoseInput, RestMesh},
    placeholder::{POSE, placeholders, with_pose},
    text::some_of,
};

/// The known results that `truth: pattern` names, or that a generated target brings.
pub(super) fn ground_truth(
    scope: Scope<'_>,
    found: &mut Findings,
    pattern: Option<&Path>,
    target: Option<&RestMesh>,
    poses: &[PoseInput],
) -> GroundTruth {
    let Some(pattern) = pattern else {
        return match target {
            Some(target) if target.path.is_none() => GroundTruth::held(&target.sequence.poses),
            _ => GroundTruth::None,
        };
    };
    let at = path(["truth"]);
    let text = pattern.to_string_lossy();
    if let Some(other) = placeholders(&text).into_iter().find(|name| *name != "pose") {
        let message = format!("unknown placeholder `{{{other}}}`");
        found.wrong(scope, &at, At::Value, message, "`{pose}` stands for the pose's name");
        return GroundTruth::None;
    }
    if let Err(unknown) = scope.formats.reader(pattern) {
        found.wrong(scope, &at, At::Value, unknown.message, unknown.hint);
        return GroundTruth::None;
    }
    if text.contains(POSE) {
        truth_files(scope, found, &text, target, poses)
    } else {
        truth_file(scope, found, &scope.path(&at, pattern), target, poses)
    }
}

/// A file a pose.
fn truth_files(
    scope: Scope<'_>,
    found: &mut Findings,
    pattern: &str,
    target: Option<&RestMesh>,
    poses: &[PoseInput],
) -> GroundTruth {
    let at = path(["truth"]);
    let file = |pose: &PoseInput| {
        let written = scope.path(&at, Path::new(&with_pose(pattern, &pose.name)));
        // Known results are from elsewhere, and may have a name that Windows reserves.
        let named = scope.path(&at, Path::new(&pattern.replace(POSE, &pose.name)));
        if !written.is_file() && !pose.name.contains(['/', '\\']) && named.is_file() { named } else { written }
    };
    let files: Vec<PathBuf> = poses.iter().map(file).collect();
    let missing: Vec<_> = files.iter().filter(|file| !file.is_file()).collect();
    if let Some(first) = missing.first() {
        let others = if missing.len() > 1 { format!(" (and {} more)", missing.len() - 1) } else { String::new() };
        let hint =
            "there must be a known result for every pose; `{pose}` stands for what the wildcards of `poses` match";
        found.missing(scope, &at, format!("no such file: {}{others}", first.display()), hint);
        return GroundTruth::None;
    }
    for file in &files {
        found.input(scope, "truth", file, &at);
    }
    GroundTruth::Files { files, meshes: chosen_meshes(target) }
}

/// The parts of a known result that are the target's.
fn chosen_meshes(target: Option<&RestMesh>) -> Vec<String> {
    target.map(|target| target.selection.meshes.clone()).unwrap_or_default()
}

/// One file for all poses.
fn truth_file(
    scope: Scope<'_>,
    found: &mut Findings,
    file: &Path,
    target: Option<&RestMesh>,
    poses: &[PoseInput],
) -> GroundTruth {
    let at = path(["truth"]);
    if !found.input(scope, "truth", file, &at) {
        return GroundTruth::None;
    }
    let selection = Selection { meshes: chosen_meshes(target), ..Selection::default() };
    let rest = target.map(|target| target.selection.rest.clone()).unwrap_or_default();
    let sequence = match resting_alike(scope, file, selection, &rest) {
        Ok(sequence) => sequence,
        Err(error) => {
            found.diagnostics.push(in_file(file, error));
            return GroundTruth::None;
        }
    };
    found.warn_of_file(file, &sequence.warnings);
    if let Some(target) = target {
        let (expected, count) = (target.sequence.rest.positions.len(), sequence.rest.positions.len());
        if expected != count {
            let message = format!("{} has {count} vertices, the target {expected}", file.display());
            found.wrong(scope, &at, At::Value, message, "the truth is the target itself in its known poses");
            return GroundTruth::None;
        }
    }
    if let Some(missing) = poses.iter().find(|pose| sequence.poses.iter().all(|held| held.name != pose.name)) {
        let message = format!("{} holds no pose called `{}`", file.display(), missing.name);
        let hint = "for a file a pose, put `{pose}` into the name: `truth: truth-{pose}.obj`";
        found.missing(scope, &at, message, hint);
    }
    if let Some(target) = target {
        warn_of_own_shapes(scope, found, file, target, &sequence.poses, poses);
    }
    GroundTruth::held(&sequence.poses)
}

/// Warns of known results that are morph targets that the target had before, as a file has that was written from it.
fn warn_of_own_shapes(
    scope: Scope<'_>,
    found: &mut Findings,
    file: &Path,
    target: &RestMesh,
    truth: &[Pose],
    poses: &[PoseInput],
) {
    let Some(path) = target.path.as_deref().filter(|path| *path != file) else { return };
    if !scope.formats.reader(path).is_ok_and(|format| format.holds_poses()) {
        return;
    }
    let selection = Selection { poses: PoseChoice::Shapes, keep_document: false, ..target.selection.clone() };
    let Ok(own) = scope.formats.read(path, &selection) else { return };
    let asked = |pose: &&Pose| poses.iter().any(|asked| asked.name == pose.name);
    let is_own = |pose: &&Pose| own.poses.iter().any(|own| own.name == pose.name && own.positions == pose.positions);
    let names: Vec<&str> = truth.iter().filter(asked).filter(is_own).map(|pose| &*pose.name).collect();
    if !names.is_empty() {
        found.warnings.push(format!(
            "{}: the target itself has these shapes, so that they may be no known results: {}",
            file.display(),
            some_of(&names)
        ));
    }
}
