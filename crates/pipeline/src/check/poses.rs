//! The poses of the source: globs, names, and poses that the rest file holds.

use std::{
    collections::{HashMap, HashSet},
    path::{Path, PathBuf},
};

use mimesh_core::stage::{PoseChoice, RestShape, Selection};
use mimesh_document::{
    At, Step,
    limits::thousands,
    path,
    paths::{entry_identity, identity, stem},
    suggest::did_you_mean,
};

use super::{
    findings::{Findings, Scope},
    held_poses::{check_times, frames, is_readable, own_clip, own_poses, poses_in},
    rest_meshes::{at_file, in_file, rest_mesh},
    seams::{self, SeamCache},
    units,
};
use crate::{
    globs::{expand, is_glob, nearby},
    input::{PoseFrom, PoseInput, RestMesh, read_pose},
    pose_files::Poses,
    pose_units::warning_of_pose_units,
    rest::Rest,
    spec::Source,
};

/// The source and its poses, as far as they can be had, and what was chosen for its poses if `source` leaves them open.
pub(super) fn source(
    scope: Scope<'_>,
    found: &mut Findings,
    source: &Source,
    by: SeamCache<'_>,
) -> (Option<RestMesh>, Vec<PoseInput>, Option<Poses>) {
    if source.generator.is_some() && source.poses.is_some() {
        let hint = "a generator brings its own poses; remove `poses`";
        found.wrong(scope, &path(["source", "poses"]), At::Key, "`poses` beside `generator`", hint);
    }
    if let Some(Poses::Clips(clips)) = &source.poses
        && !check_times(scope, found, clips)
    {
        return (None, vec![], None);
    }
    let (mut mesh, chosen) = rest_and_clip(scope, found, source);
    let declared = source.poses.as_ref().or(chosen.as_ref());
    let change = units::poses_change(scope, found, source);
    if let Some(mesh) = &mut mesh {
        mesh.poses_change = change;
        mesh.selection.same_vertices = declared.is_some_and(Poses::same_vertices);
    }
    let poses = match (declared, &mut mesh) {
        (Some(Poses::Clips(clips)), Some(mesh)) => frames(scope, found, mesh, clips),
        (None, Some(mesh)) => own_poses(scope, found, mesh),
        (Some(Poses::Clips(_)) | None, None) => vec![],
        (Some(files), mesh) => {
            let files = pose_files(scope, found, files, source.rest.as_ref());
            let named = |file: PoseInput| (file.name.clone(), poses_in(scope, found, mesh.as_mut(), file));
            told_apart(files.into_iter().map(named).collect())
        }
    };
    let poses = with_unique_names(scope, found, poses);
    let pose = source.rest.as_ref().and_then(|rest| rest.pose.as_deref());
    let mesh = match (mesh, pose) {
        (Some(mesh), Some(name)) => resting_at(scope, found, mesh, &poses, name),
        (mesh, _) => mesh,
    };
    let Some(mut mesh) = mesh else { return (None, poses, chosen) };
    match &source.opened_seams {
        Some(points) if !seams::open_named(scope, found, "source", &mut mesh, points) => return (None, poses, chosen),
        Some(_) => {}
        None => seams::open_parted(scope, found, &mut mesh, &poses, by),
    }
    if units::has_pose_files(source.poses.as_ref()) {
        let known = units::of_source(scope, source);
        found.warnings.extend(warning_of_pose_units(&mesh, &poses, scope.formats, known));
    }
    (Some(mesh), poses, chosen)
}

/// The source at rest, and the clip that is chosen for its poses where they are left open and its file has nothing but clips.
fn rest_and_clip(scope: Scope<'_>, found: &mut Findings, source: &Source) -> (Option<RestMesh>, Option<Poses>) {
    let mut own = Findings::default();
    let mut mesh = rest_file(scope, &mut own, source, source.poses.as_ref());
    let declared = scope.document.get(&path(["source", "poses"]));
    let is_open = declared.is_none_or(serde_json::Value::is_null) && source.generator.is_none();
    let chosen = mesh.as_ref().filter(|_| is_open).and_then(own_clip);
    if let Some((poses, choice)) = &chosen {
        // Frames of a clip are read with the mesh.
        own = Findings::default();
        mesh = rest_file(scope, &mut own, source, Some(poses));
        own.choices.push(choice.clone());
    }
    found.absorb(own);
    (mesh, chosen.map(|(poses, _)| poses))
}

/// The source as its file or its generator has it at rest.
///
/// `poses` are those of `source`, or chosen for it.
pub(super) fn rest_file(
    scope: Scope<'_>,
    found: &mut Findings,
    source: &Source,
    poses: Option<&Poses>,
) -> Option<RestMesh> {
    let poses = match poses {
        None => PoseChoice::Shapes,
        Some(Poses::Clips(clips)) if clips.file.is_none() => PoseChoice::Clips(clips.choice()),
        Some(_) => PoseChoice::Nothing,
    };
    let selection = Selection { poses, ..Selection::default() };
    let (rest, generator) = (source.rest.as_ref(), source.generator.as_deref());
    rest_mesh(scope, found, "source", rest, selection, generator, source.weld_tolerance)
}

/// The source with its pose `name` as its rest.
fn resting_at(
    scope: Scope<'_>,
    found: &mut Findings,
    mesh: RestMesh,
    poses: &[PoseInput],
    name: &str,
) -> Option<RestMesh> {
    let at = path(["source", "rest", "pose"]);
    let Some(pose) = poses.iter().find(|pose| pose.name == name) else {
        // Frames of a clip are the poses, and the shape at rest is another of the file.
        let shape =
            Selection { rest: RestShape::Pose(name.into()), poses: PoseChoice::Nothing, ..mesh.selection.clone() };
        let holds_poses = |file: &Path| scope.formats.reader(file).is_ok_and(|format| format.holds_poses());
        let held = mesh.path.as_deref().filter(|file| holds_poses(file)).map(|file| scope.formats.read(file, &shape));
        if let Some(Ok(resting)) = held
            && let Ok(mesh) = mesh.resting_at(resting.rest.positions)
        {
            return Some(mesh);
        }
        let names: Vec<&str> = poses.iter().map(|pose| pose.name.as_str()).collect();
        let hint = did_you_mean(name, &names).unwrap_or_else(|| format!("poses: {}", crate::text::some_of(&names)));
        found.missing(scope, &at, format!("the source has no pose called `{name}`"), hint);
        return None;
    };
    let file = match &pose.from {
        PoseFrom::File(file) => Some(file.clone()),
        PoseFrom::Held(_) => mesh.path.clone(),
    };
    let resting = read_pose(&mesh, scope.formats, &pose.from).and_then(|positions| mesh.resting_at(positions));
    match (resting, file) {
        (Ok(mesh), _) => return Some(mesh),
        (Err(error), Some(file)) => found.diagnostics.push(in_file(&file, error)),
        (Err(error), None) => found.wrong(scope, &at, At::Value, error.to_string(), "choose another pose"),
    }
    None
}

/// The poses in the files that `poses` stand for, without the rest mesh.
fn pose_files(scope: Scope<'_>, found: &mut Findings, poses: &Poses, rest: Option<&Rest>) -> Vec<PoseInput> {
    let Some(patterns) = poses.files() else { return vec![] };
    let slot = match poses {
        Poses::Mapped(_) => path(["source", "poses", "files"]),
        _ => path(["source", "poses"]),
    };
    let rest = rest.map(|rest| scope.path(&at_file(scope, "source"), &rest.file));
    if patterns.items.is_empty() {
        found.wrong(scope, &slot, At::Value, "the sequence of poses is empty", "name at least one file");
    }
    found.check_empty(scope, &slot);
    let mut poses = Vec::new();
    let (mut seen, mut asked, mut repeated) = (HashSet::new(), HashSet::new(), Vec::new());
    let mut looked_at = 0;
    // An item that is no string has a diagnostic of its own, and an empty one stands in its place.
    for (i, pattern) in patterns.items.iter().enumerate().filter(|(_, pattern)| !pattern.is_empty()) {
        let at = if patterns.listed { [&slot[..], &[Step::Index(i)]].concat() } else { slot.clone() };
        if !asked.insert(pattern) {
            repeated.push(pattern.to_string());
            continue;
        }
        for pose in matching(scope, found, pattern, &at, rest.as_ref(), &mut looked_at) {
            // Frames that are held are often links to one file.
            if seen.insert(entry_identity(&pose.path)) {
                poses.push(PoseInput { name: pose.name, time: None, from: PoseFrom::File(pose.path) });
            } else if !is_glob(pattern) {
                repeated.push(pattern.to_string());
            }
        }
    }
    if let Some(first) = repeated.first() {
        let many = if repeated.len() > 1 { format!(" ({} such)", thousands(repeated.len())) } else { String::new() };
        found.warnings.push(format!("source.poses: `{first}` is named more than once and taken once{many}"));
    }
    poses
}

/// The readable files of poses that `pattern`, written at `at`, stands for.
fn matching(
    scope: Scope<'_>,
    found: &mut Findings,
    pattern: &str,
    at: &[Step],
    rest: Option<&PathBuf>,
    looked_at: &mut usize,
) -> Vec<crate::globs::GlobMatch> {
    let files = match expand(scope.document.folder(at), pattern, looked_at) {
        Ok(files) => files,
        Err(refused) => {
            found.wrong(scope, at, At::Value, refused.message, refused.hint);
            return vec![];
        }
    };
    let is_rest = |file: &Path| rest.is_some_and(|rest| is_same_mesh(file, rest));
    let hint = || nearby(&scope.path(at, Path::new(pattern)));
    if files.is_empty() {
        found.missing(scope, at, format!("no file matches `{pattern}`"), hint());
    } else if is_glob(pattern) && files.iter().all(|file| is_rest(&file.path)) {
        let message = format!("`{pattern}` matches the rest mesh only, which is no pose");
        found.missing(scope, at, message, hint());
        return vec![];
    }
    let mut readable = Vec::new();
    for file in files {
        if is_glob(pattern) && is_rest(&file.path) {
            found.warnings.push(format!("`{pattern}` also matches the rest mesh, which is not taken as a pose"));
        } else if is_readable(scope, found, &file.path, at) {
            readable.push(file);
        }
    }
    readable
}

/// Whether `file` is the rest mesh itself: a link to it is a pose that holds the rest.
fn is_same_mesh(file: &Path, rest: &Path) -> bool {
    let is_link = file.symlink_metadata().is_ok_and(|found| found.is_symlink());
    entry_identity(file) == entry_identity(rest) || (!is_link && identity(file) == identity(rest))
}

/// The poses of all files; those that several files hold under one name get the name of the file before their own.
///
/// Many programs write one clip a file, and call all of them alike.
fn told_apart(files: Vec<(String, Vec<PoseInput>)>) -> Vec<PoseInput> {
    let held = |pose: &PoseInput| matches!(pose.from, PoseFrom::Held(_));
    let mut counts: HashMap<String, usize> = HashMap::new();
    for pose in files.iter().flat_map(|(_, poses)| poses).filter(|pose| held(pose)) {
        *counts.entry(pose.name.clone()).or_default() += 1;
    }
    let rename = |(file, mut poses): (String, Vec<PoseInput>)| {
        if poses.iter().any(|pose| held(pose) && counts[&pose.name] > 1) {
            for pose in &mut poses {
                pose.name = format!("{file}-{}", pose.name);
                if let Some(time) = &mut pose.time {
                    time.clip = format!("{file}-{}", time.clip);
                }
            }
        }
        poses
    };
    files.into_iter().flat_map(rename).collect()
}

/// The poses under unique names: where wildcards stand for the same, poses are called like their files.
fn with_unique_names(scope: Scope<'_>, found: &mut Findings, mut poses: Vec<PoseInput>) -> Vec<PoseInput> {
    if duplicate_name(&poses).is_some() {
        for pose in &mut poses {
            if let PoseFrom::File(file) = &pose.from {
                pose.name = stem(file);
            }
        }
    }
    if let Some(name) = duplicate_name(&poses) {
        let of_name = poses.iter().filter(|pose| pose.name == name);
        let files: Vec<_> = of_name
            .filter_map(|pose| match &pose.from {
                PoseFrom::File(file) => Some(file.display().to_string()),
                PoseFrom::Held(_) => None,
            })
            .collect();
        let message = format!("two poses are called `{name}`: {}", files.join(", "));
        let hint = "rename one, or use a wildcard where the paths differ: a pose is called what wildcards stand for";
        found.wrong(scope, &path(["source", "poses"]), At::Value, message.trim_end_matches(": "), hint);
        // That their results collide follows, and needs no diagnostic.
        let mut seen = HashSet::new();
        poses.retain(|pose| seen.insert(pose.name.clone()));
    }
    poses
}

fn duplicate_name(poses: &[PoseInput]) -> Option<String> {
    let mut names: Vec<_> = poses.iter().map(|pose| &pose.name).collect();
    names.sort();
    names.windows(2).find(|pair| pair[0] == pair[1]).map(|pair| pair[0].clone())
}
