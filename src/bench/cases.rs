use std::{
    fs,
    path::{Path, PathBuf},
};

use serde::Deserialize;

use super::Method;
use crate::{
    core::{Error, mesh::Surface},
    diagnostic::{Diagnostic, Kind, Location, Result},
    pipeline::Formats,
};

/// A transfer whose result is known.
#[derive(Clone, Debug)]
pub struct Case {
    /// What it is called.
    pub name: String,
    /// `source`, `target`, `markers` and `truth` of a pipeline, in YAML.
    meshes: String,
    /// Whether the target has several components.
    pub components: bool,
    /// Pairs of markers that are written beside the pipeline.
    markers: Option<Vec<[u32; 2]>>,
}

/// The built-in samples: animals of one piece, of plates, of stones and of boxes.
pub fn samples() -> Vec<Case> {
    let quadruped = |name: &str, proportions: &str, gait: &str, more: &str| Case {
        name: name.into(),
        meshes: format!(
            "source: {{ generator: {{ type: quadruped, proportions: horse, gait: {gait} }} }}\n\
             target: {{ generator: {{ type: quadruped, proportions: {proportions}, gait: {gait}, {more} }} }}\n"
        ),
        components: more.contains("made_of"),
        markers: None,
    };
    vec![
        quadruped("camel", "camel", "gallop", "resolution: 70, seed: 1"),
        quadruped("giraffe", "giraffe", "walk", "seed: 2"),
        quadruped("plates", "camel", "gallop", "made_of: plates, pieces: 60, seed: 1"),
        quadruped("pebbles", "camel", "gallop", "made_of: pebbles, pieces: 200, seed: 1"),
        quadruped("boxes", "giraffe", "walk", "made_of: boxes"),
    ]
}

/// Pairs of vertices of source and target.
#[derive(Deserialize)]
struct Landmarks {
    source: Vec<u32>,
    target: Vec<u32>,
}

/// The cases in `folder`, with each number of markers, and what was passed over.
///
/// A folder `source` has the source: `rest` and a mesh for each pose. Every other folder that has `rest`, `truth-POSE`, and
/// `landmarks.json` (`{ "source": [vertices], "target": [vertices] }`) is a target.
///
/// # Errors
///
/// If there is no source, or no target.
pub fn folder(folder: &Path, markers: &[usize]) -> Result<(Vec<Case>, Vec<String>)> {
    let formats = Formats::new(vec![]);
    let source = folder.join("source");
    let rest = mesh_called(&formats, &source, "rest").ok_or_else(|| {
        let message = "no folder `source` with a mesh called `rest`";
        let hint = "expected source/rest.obj, source/POSE.obj, and TARGET/rest.obj, TARGET/truth-POSE.ply, TARGET/landmarks.json";
        Diagnostic::new(Kind::MissingInput, message).at(Location::File(folder.into())).hint(hint)
    })?;
    let mut targets: Vec<PathBuf> = fs::read_dir(folder)
        .map_err(|error| Diagnostic::from(Error::read(folder, error)))?
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| path.is_dir() && *path != source)
        .collect();
    targets.sort();
    let (mut cases, mut passed) = (vec![], vec![]);
    for target in targets {
        let name = target.file_name().unwrap_or_default().to_string_lossy().into_owned();
        match of_target(&formats, &rest, &target, &name, markers) {
            Ok(of_target) => cases.extend(of_target),
            Err(why) => passed.push(format!("{name}: {why}")),
        }
    }
    if cases.is_empty() {
        let message = format!("no target can be measured: {}", passed.join("; "));
        let hint = "a target is a folder with rest.obj, truth-POSE.ply and landmarks.json";
        return Err(Diagnostic::new(Kind::MissingInput, message).at(Location::File(folder.into())).hint(hint).into());
    }
    Ok((cases, passed))
}

fn of_target(
    formats: &Formats,
    source: &Path,
    target: &Path,
    name: &str,
    markers: &[usize],
) -> std::result::Result<Vec<Case>, String> {
    let rest = mesh_called(formats, target, "rest").ok_or("no mesh called `rest`")?;
    let text = fs::read_to_string(target.join("landmarks.json")).map_err(|_| "no landmarks.json")?;
    let landmarks: Landmarks = serde_json::from_str(&text).map_err(|error| format!("landmarks.json: {error}"))?;
    if landmarks.source.len() != landmarks.target.len() {
        let [source, target] = [landmarks.source.len(), landmarks.target.len()];
        return Err(format!("landmarks.json: {source} of the source, {target} of the target"));
    }
    let pairs: Vec<[u32; 2]> = landmarks.source.into_iter().zip(landmarks.target).map(|(s, t)| [s, t]).collect();
    let mut poses: Vec<(String, PathBuf, PathBuf)> = Vec::new();
    for file in fs::read_dir(target).map_err(|error| error.to_string())?.filter_map(|entry| Some(entry.ok()?.path())) {
        let stem = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let Some(pose) = stem.strip_prefix("truth-").filter(|_| formats.reader(&file).is_ok()) else { continue };
        let folder = source.parent().unwrap_or(Path::new(""));
        if let Some(posed) = mesh_called(formats, folder, pose) {
            poses.push((pose.to_owned(), posed, file.clone()));
        }
    }
    poses.sort();
    let (_, _, first) = poses.first().ok_or("no known result `truth-POSE` of a pose of the source")?;
    let mesh = formats.reader(&rest).map_err(|unknown| unknown.message)?.read(&rest).map_err(|e| e.to_string())?.rest;
    let components = Surface::new(&mesh).map_err(|error| error.to_string())?.components().count() > 1;
    let quoted = |path: &Path| serde_json::to_string(&absolute(path)).unwrap_or_default();
    let files: Vec<String> = poses.iter().map(|(_, posed, _)| quoted(posed)).collect();
    let extension = first.extension().unwrap_or_default().to_string_lossy();
    if let Some((_, _, other)) = poses.iter().find(|(_, _, truth)| truth.extension() != first.extension()) {
        return Err(format!("known results in several formats: {} and {}", first.display(), other.display()));
    }
    let truth = quoted(&target.join(format!("truth-{{pose}}.{extension}")));
    let meshes = format!(
        "source: {{ rest: {}, poses: [{}] }}\ntarget: {{ rest: {} }}\ntruth: {truth}\n",
        quoted(source),
        files.join(", "),
        quoted(&rest)
    );
    let mut cases = Vec::new();
    for &count in markers.iter().filter(|count| **count <= pairs.len()) {
        let markers = Some(pairs[..count].to_vec());
        cases.push(Case { name: format!("{name}-{count}"), meshes: meshes.clone(), components, markers });
    }
    match (cases.is_empty(), markers.iter().min()) {
        (true, Some(fewest)) => Err(format!("{} landmarks, fewer than {fewest}", pairs.len())),
        _ => Ok(cases),
    }
}

/// The mesh called `stem` in `folder`, in whatever format can be read.
fn mesh_called(formats: &Formats, folder: &Path, stem: &str) -> Option<PathBuf> {
    let mut found: Vec<PathBuf> = fs::read_dir(folder)
        .ok()?
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| path.file_stem().is_some_and(|name| name == stem) && formats.reader(path).is_ok())
        .collect();
    found.sort();
    found.into_iter().next()
}

fn absolute(path: &Path) -> String {
    std::path::absolute(path).unwrap_or_else(|_| path.into()).display().to_string()
}

impl Case {
    /// The pipeline that runs `method` and is called `name`; markers stand in it.
    pub(super) fn pipeline(&self, method: &Method, name: &str) -> String {
        let mut text = format!("{}{} on {}.\n{}", super::MARK, method.name, self.name, self.meshes);
        if self.markers.is_some() {
            text += &format!("markers: {}.cons\n", self.name);
        }
        if self.components {
            text += "proximity: { type: spanning_tree }\n";
        }
        text += method.stages;
        text + &format!("output: [{name}/result.glb, {name}/report.html]\n")
    }

    /// The file of markers beside the pipelines, if there is one: its name and contents.
    pub(super) fn marker_file(&self) -> Option<(String, String)> {
        let pairs = self.markers.as_ref()?;
        let lines: String = pairs.iter().map(|[source, target]| format!("{source}, {target}\n")).collect();
        Some((format!("{}.cons", self.name), format!("{}\n{lines}", pairs.len())))
    }
}
