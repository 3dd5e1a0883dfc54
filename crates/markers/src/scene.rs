//! Points of a mesh as named nodes of a scene, such as empties of Blender in a `.glb`.

use std::{collections::BTreeSet, path::Path};

use mimesh_core::stage::ScenePoint;
use mimesh_document::{Diagnostic, Kind, Location, Result};

use crate::{
    attacher::{Attacher, is_too_far},
    diagnose::IntoDiagnostic,
    pairing::MAX_NAMED,
    points::{NamedPoint, PointFile, PointPosition, Scene},
};

/// Whoever can read the nodes of scenes.
pub trait ScenePoints {
    /// The nodes of `file` that may be points; `None` if it is no scene.
    fn scene_points(&self, file: &Path) -> Option<mimesh_core::Result<Vec<ScenePoint>>>;
}

/// The points in a scene; `None` if `file` is none.
///
/// # Errors
///
/// Those of the reader, and a scene without points.
pub fn read(file: &Path, scenes: &dyn ScenePoints) -> Option<Result<PointFile>> {
    let nodes = match scenes.scene_points(file)? {
        Ok(nodes) => nodes,
        Err(error) => return Some(Err(error.into_diagnostic().into())),
    };
    let mut result = PointFile { scene: Some(Scene::default()), ..PointFile::new(file) };
    let (mut seen, mut twice) = (BTreeSet::new(), BTreeSet::new());
    for ScenePoint { name, position, is_doubtful } in nodes {
        if !seen.insert(name.clone()) {
            twice.insert(name.clone());
        }
        if is_doubtful && let Some(scene) = &mut result.scene {
            scene.doubtful.insert(name.clone());
        }
        let (position, location) = (PointPosition::InSpace(position), Location::File(file.into()));
        result.points.push(NamedPoint { name: Some(name), position, location });
    }
    // Which of several is meant is not known.
    result.points.retain(|point| point.name.as_ref().is_none_or(|name| !twice.contains(name)));
    result.warn_of_left_out("nodes of one name", &twice.into_iter().collect::<Vec<_>>());
    if result.points.is_empty() {
        let message = "no points: the scene has no named node without a mesh, a camera, a light or a joint";
        let hint = "add an empty with a name for each point, and export the file with them";
        return Some(Err(Diagnostic::new(Kind::BadData, message).at(Location::File(file.into())).hint(hint).into()));
    }
    Some(Ok(result))
}

/// Leaves those nodes of scenes that have a name of the other side.
///
/// # Errors
///
/// If a side is a scene and no name is on both.
pub fn keep_shared(files: &mut [PointFile; 2]) -> Result<()> {
    if files.iter().all(|file| file.scene.is_none()) {
        return Ok(());
    }
    let names =
        [0, 1].map(|k| -> BTreeSet<String> { files[k].points.iter().filter_map(|point| point.name.clone()).collect() });
    if names[0].is_disjoint(&names[1]) {
        let all = [0, 1].map(|k| {
            let some: Vec<_> = names[k].iter().take(MAX_NAMED).map(String::as_str).collect();
            let more = if names[k].len() > some.len() { ", …" } else { "" };
            let some = if some.is_empty() { "no names".into() } else { some.join(", ") };
            format!("{} has {some}{more}", files[k].file.display())
        });
        let message = format!("the points cannot be paired: no name is on both sides; {}", all.join(", "));
        let diagnostic = Diagnostic::new(Kind::BadData, message).at(Location::File(files[0].file.clone()));
        return Err(diagnostic.hint("nodes of a scene are paired by name: call partners alike").into());
    }
    for k in 0..2 {
        if files[k].scene.is_some() {
            files[k].points.retain(|point| point.name.as_ref().is_some_and(|name| names[1 - k].contains(name)));
        }
    }
    Ok(())
}

/// Leaves out the nodes of scenes that may be there for others and do not lie on their mesh: on both sides, and told.
pub fn drop_groups(files: &mut [PointFile; 2], attachers: &[Attacher<'_>; 2]) {
    let mut dropped: BTreeSet<String> = BTreeSet::new();
    for (file, attacher) in files.iter().zip(attachers) {
        let Some(scene) = &file.scene else { continue };
        for point in &file.points {
            let name = point.name.as_ref().filter(|name| scene.doubtful.contains(*name));
            if let (Some(name), Some(position)) = (name, point.in_space())
                && is_too_far(attacher.attach(&position).distance)
            {
                dropped.insert(name.clone());
            }
        }
    }
    let names: Vec<String> = dropped.iter().cloned().collect();
    for file in files.iter_mut().filter(|file| file.scene.is_some()) {
        file.points.retain(|point| point.name.as_ref().is_none_or(|name| !dropped.contains(name)));
        file.warn_of_left_out("groups and ends of joints off the surface", &names);
    }
}
