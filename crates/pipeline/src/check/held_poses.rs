//! Poses that files hold: morph targets, and frames of clips.

use std::{path::Path, sync::Arc};

use mimesh_core::{
    mesh::{ComputePoses, MeshSequence, Pose, Positions},
    spatial::UnitAxes,
    stage::{ClipChoice, ClipTimes, PoseChoice, RestShape, Selection, check_pose, check_vertices},
};
use mimesh_document::{At, Diagnostic, Kind, Step, path};
use nalgebra::Point3;

use super::{
    findings::{Findings, Scope},
    rest_meshes::in_file,
};
use crate::{
    choices::Choice,
    input::{PoseFrom, PoseInput, RestMesh},
    one_or_many::OneOrMany,
    pose_files::{ClipPoses, Poses},
    text::some_of,
};

/// Remedy: name the poses of the source.
pub const NAME_POSES: &str = "name_poses";

/// Whether the file of a pose, named at `at`, exists and has a format; else there is a diagnostic.
pub(super) fn is_readable(scope: Scope<'_>, found: &mut Findings, file: &Path, at: &[Step]) -> bool {
    if !found.input(scope, "pose", file, at) {
        return false;
    }
    match scope.formats.reader(file) {
        Ok(_) => {
            found.warn_of_file(file, scope.formats.warning(file).as_slice());
            true
        }
        Err(unknown) => {
            found.wrong(scope, at, At::Value, unknown.message, unknown.hint);
            false
        }
    }
}

/// The poses that come with the rest mesh, from number `first` on.
fn held_poses(mesh: &RestMesh, first: usize) -> Vec<PoseInput> {
    let held = mesh.sequence.poses.iter().enumerate().skip(first);
    held.map(|(i, pose)| PoseInput { name: pose.name.clone(), time: pose.time.clone(), from: PoseFrom::Held(i) })
        .collect()
}

/// The clip of the rest's file that stands for the poses where no others are declared and the file holds no shapes: the only one, or
/// the first one that lasts.
pub(super) fn own_clip(mesh: &RestMesh) -> Option<(Poses, Choice)> {
    let clips = &mesh.sequence.animations;
    let clip = clips.iter().find(|clip| clip.seconds > 0.0).or(clips.first())?;
    if !mesh.sequence.poses.is_empty() {
        return None;
    }
    let why = match clips.len() {
        1 => "the file of the source has no morph targets and this clip alone".into(),
        many => {
            let names: Vec<&str> = clips.iter().map(|clip| clip.name.as_str()).collect();
            format!(
                "the file of the source has no morph targets, and of its {many} clips one is taken: {}",
                some_of(&names)
            )
        }
    };
    let named = OneOrMany { items: vec![clip.name.clone()], listed: false };
    let choice = Choice::new("source.poses", format!("clip {}", clip.name), why);
    Some((Poses::Clips(ClipPoses { clip: named, ..ClipPoses::default() }), choice))
}

/// The poses of the rest mesh where no others are declared.
pub(super) fn own_poses(scope: Scope<'_>, found: &mut Findings, mesh: &RestMesh) -> Vec<PoseInput> {
    let poses = held_poses(mesh, 0);
    // A wrong `poses` has a diagnostic of its own.
    let declared = scope.document.value.get("source").and_then(|source| source.get("poses"));
    if poses.is_empty() && declared.is_none_or(serde_json::Value::is_null) {
        let reason = if mesh.path.is_some() { "the rest file holds none" } else { "the generator makes none" };
        let at = scope.document.location(&path(["source"]), At::Value);
        let diagnostic = Diagnostic::new(Kind::MissingInput, format!("the source has no poses: {reason}")).at(at);
        found.diagnostics.push(diagnostic.remedy(NAME_POSES, "", "name their files, e.g. `poses: horse-??.obj`"));
    }
    poses
}

/// Whether the times of clips can be meant; else there is a diagnostic.
pub(super) fn check_times(scope: Scope<'_>, found: &mut Findings, clips: &ClipPoses) -> bool {
    let at = |key: &str| path(["source", "poses", key]);
    if clips.at_keys && clips.fps.is_some() {
        found.wrong(scope, &at("fps"), At::Key, "`fps` beside `at_keys`", "remove one of the two");
        return false;
    }
    // A number out of its range has a diagnostic already.
    if clips.fps.is_some_and(|fps| fps <= 0.0) {
        return false;
    }
    if let Some([start, end]) = clips.range
        && !(start >= 0.0 && start <= end)
    {
        let message = format!("expected a first time from 0 on and a last time not before it, found [{start}, {end}]");
        found.wrong(scope, &at("range"), At::Value, message, "e.g. `range: [0.5, 1.5]`");
        return false;
    }
    true
}

/// The frames of clips: those that came with the rest mesh, or those of another file.
pub(super) fn frames(scope: Scope<'_>, found: &mut Findings, mesh: &mut RestMesh, clips: &ClipPoses) -> Vec<PoseInput> {
    let Some(file) = &clips.file else {
        if mesh.sequence.poses.is_empty() {
            let (message, hint) = match &mesh.sequence.animations[..] {
                [] => (
                    "the rest holds no clips",
                    "name the file that holds the clip, e.g. `poses: { file: run.glb, clip: Run }`",
                ),
                _ => ("no key of the clip moves the mesh in the given times", STILL),
            };
            found.missing(scope, &path(["source", "poses"]), message, hint);
        }
        return held_poses(mesh, 0);
    };
    let at = path(["source", "poses", "file"]);
    let file = scope.path(&at, file);
    if !is_readable(scope, found, &file, &at) {
        return vec![];
    }
    let read = read_poses(scope, mesh, &file, PoseChoice::Clips(clips.choice()));
    match read.and_then(|read| hold(found, mesh, &file, read)) {
        Ok(poses) if poses.is_empty() => {
            let message = format!("{} holds no clip that moves the mesh", file.display());
            found.missing(scope, &at, message, STILL);
            vec![]
        }
        Ok(poses) => poses,
        Err(error) => {
            found.diagnostics.push(in_file(&file, error));
            vec![]
        }
    }
}

/// The way out where clips give no poses.
const STILL: &str = "name another clip, or other times";

/// The poses that a file among those of the source holds: all of one that holds poses, else the mesh in it.
pub(super) fn poses_in(
    scope: Scope<'_>,
    found: &mut Findings,
    mesh: Option<&mut RestMesh>,
    pose: PoseInput,
) -> Vec<PoseInput> {
    let (PoseFrom::File(file), Some(mesh)) = (&pose.from, mesh) else { return vec![pose] };
    if !scope.formats.reader(file).is_ok_and(|format| format.holds_poses()) {
        return vec![pose];
    }
    let mut read = read_poses(scope, mesh, file, PoseChoice::Shapes);
    if read.as_ref().is_ok_and(|read| read.poses.is_empty() && !read.animations.is_empty()) {
        // A look at each clip tells which of them move the mesh. Of several none is chosen, so that their frames are not made.
        let times = ClipTimes::PerSecond(1.0);
        let looks = ClipChoice { times, range: Some([0.0, 0.0]), ..ClipChoice::default() };
        read = read_poses(scope, mesh, file, PoseChoice::Clips(looks));
        if let Ok([_]) = read.as_ref().map(|read| &read.poses[..]) {
            read = read_poses(scope, mesh, file, PoseChoice::Clips(ClipChoice::default()));
        }
    }
    let held = read.and_then(|read| {
        let mut clips: Vec<&str> = read.poses.iter().filter_map(|pose| Some(&*pose.time.as_ref()?.clip)).collect();
        clips.dedup();
        if clips.len() > 1 {
            let message = format!("{} has several clips: {}", file.display(), some_of(&clips));
            let hint = format!("name one: `poses: {{ file: {}, clip: {} }}`", file.display(), clips[0]);
            found.wrong(scope, &path(["source", "poses"]), At::Value, message, hint);
            return Ok(vec![]);
        }
        // A mesh in one shape is a pose like any other file of one mesh.
        if read.poses.is_empty() { Ok(vec![pose.clone()]) } else { hold(found, mesh, file, read) }
    });
    held.unwrap_or_else(|error| {
        found.diagnostics.push(in_file(file, error));
        vec![]
    })
}

/// The chosen poses of `file`, where the mesh rests as the source does.
///
/// # Errors
///
/// Those of the format.
fn read_poses(scope: Scope<'_>, mesh: &RestMesh, file: &Path, poses: PoseChoice) -> mimesh_core::Result<MeshSequence> {
    let selection = Selection { meshes: mesh.selection.meshes.clone(), poses, ..Selection::default() };
    resting_alike(scope, file, selection, &mesh.selection.rest)
}

/// Reads `file` with the shape `rest` of another file of the same rig, if it has the clip that this is of.
///
/// # Errors
///
/// Those of the format.
pub(super) fn resting_alike(
    scope: Scope<'_>,
    file: &Path,
    selection: Selection,
    rest: &RestShape,
) -> mimesh_core::Result<MeshSequence> {
    let read = scope.formats.read(file, &selection)?;
    match rest {
        RestShape::Clip { name, .. } if read.animations.iter().any(|clip| clip.name == *name) => {
            scope.formats.read(file, &Selection { rest: rest.clone(), ..selection })
        }
        _ => Ok(read),
    }
}

/// Puts the poses that were read from `file` with those that the source holds; these poses.
///
/// # Errors
///
/// If the file does not have the vertices and polygons of the source.
fn hold(
    found: &mut Findings,
    mesh: &mut RestMesh,
    file: &Path,
    read: MeshSequence,
) -> mimesh_core::Result<Vec<PoseInput>> {
    found.warn_of_file(file, &read.warnings);
    if read.poses.is_empty() {
        return Ok(vec![]);
    }
    let rest = &mesh.sequence.rest;
    // A point cache has no polygons.
    match mesh.selection.same_vertices || read.rest.polygons.is_empty() {
        true => check_vertices(file, rest, read.rest.positions.len())?,
        false => check_pose(file, rest, read.rest.positions.len(), &read.rest.polygons)?,
    }
    let first = mesh.sequence.poses.len();
    let poses =
        read.poses.into_iter().map(|pose| Pose { positions: converted(pose.positions, mesh.poses_change), ..pose });
    mesh.sequence.poses.extend(poses);
    Ok(held_poses(mesh, first))
}

/// Positions after a change of unit and axes; those that are computed each time are changed each time.
fn converted(positions: Positions, change: UnitAxes) -> Positions {
    if change == UnitAxes::IDENTITY {
        return positions;
    }
    match positions {
        Positions::Held(positions) => Positions::Held(positions.iter().map(|p| change.apply(p)).collect()),
        computed => Positions::Computed(Arc::new(Converted { positions: computed, change }), 0),
    }
}

/// One computed pose that is in another unit or axes than its rest.
struct Converted {
    positions: Positions,
    change: UnitAxes,
}

impl ComputePoses for Converted {
    fn positions(&self, _: usize) -> mimesh_core::Result<Vec<Point3<f64>>> {
        Ok(self.positions.get()?.iter().map(|p| self.change.apply(p)).collect())
    }
}
