//! The parts of the target that shapes may move.

use std::{
    collections::{BTreeMap, HashMap},
    path::PathBuf,
    sync::Arc,
};

use mimesh_document::{At, path, suggest::did_you_mean};

use super::{findings::Findings, shape_patterns::Patterns};
use crate::{
    input::{PoseInput, RestMesh},
    shapes::{Channel, Mask, Region, ShapeSettings, read_mask},
    text::some_of,
};

/// The regions of masks by the names of their shapes.
pub(super) fn regions(
    patterns: &Patterns<'_>,
    found: &mut Findings,
    settings: &ShapeSettings,
    poses: &[PoseInput],
    target: Option<&RestMesh>,
    has_map: bool,
) -> HashMap<String, Arc<Region>> {
    let mut by_mask: HashMap<&str, Arc<Region>> = HashMap::new();
    for (pattern, mask) in &settings.masks {
        let at = path(["shapes", "masks", pattern]);
        // A file that is not there is told even where there is no target.
        let file = mask.file.as_ref().map(|file| {
            let at = path(["shapes", "masks", pattern, "file"]);
            let file = patterns.scope.path(&at, file);
            found.input(patterns.scope, "mask", &file, &at).then_some(file)
        });
        let is_lost = matches!(file, Some(None));
        let target = target.filter(|_| !is_lost);
        let region = target.and_then(|target| match region(patterns, mask, file.flatten(), poses, target, has_map) {
            Ok(region) => Some(region),
            Err((message, hint)) => {
                found.wrong(patterns.scope, &at, At::Value, message, hint);
                None
            }
        });
        by_mask.extend(region.map(|region| (pattern.as_str(), Arc::new(region))));
    }
    let keys: BTreeMap<String, &str> =
        settings.masks.keys().map(|pattern| (pattern.clone(), pattern.as_str())).collect();
    let by_shape = patterns.by_shape(found, "masks", &keys);
    let mut regions: HashMap<String, Arc<Region>> =
        by_shape.iter().filter_map(|(shape, pattern)| Some((shape.clone(), by_mask.get(**pattern)?.clone()))).collect();
    // Shapes that mirroring adds have names that the source does not have.
    for (pattern, region) in by_mask {
        regions.entry(pattern.to_owned()).or_insert(region);
    }
    regions
}

/// What is wrong, and a way out.
type Problem = (String, String);

/// The region that `mask` says; `file` is the place of its file.
fn region(
    patterns: &Patterns<'_>,
    mask: &Mask,
    file: Option<PathBuf>,
    poses: &[PoseInput],
    target: &RestMesh,
    has_map: bool,
) -> Result<Region, Problem> {
    let surface = &target.surface;
    match (&mask.vertices, &mask.parts, mask.color, &mask.shape, file) {
        (Some(vertices), None, None, None, None) => {
            let count = surface.vertex_of.len();
            let mut inside = vec![false; surface.vertex_count()];
            for &v in vertices {
                let of_surface = surface.vertex_of.get(v as usize).ok_or_else(|| {
                    (format!("the target has no vertex {v}"), format!("its vertices are 0 to {}", count - 1))
                })?;
                of_surface.iter().for_each(|&v| inside[v as usize] = true);
            }
            Ok(Region::Inside(inside))
        }
        (None, Some(parts), None, None, None) => {
            let mesh = &target.sequence.rest;
            let names = |part: &mimesh_core::mesh::Part| -> Vec<String> {
                part.object.iter().chain(&part.groups).chain(&part.material).cloned().collect()
            };
            let all: Vec<String> = {
                let mut all: Vec<String> = mesh.parts.iter().flat_map(names).collect();
                all.sort();
                all.dedup();
                all
            };
            if let Some(unknown) = parts.items.iter().find(|name| !all.contains(name)) {
                let hint = did_you_mean(unknown, &all).unwrap_or_else(|| format!("parts: {}", some_of(&all)));
                return Err((format!("the target has no part called `{unknown}`"), hint));
            }
            let mut inside = vec![false; surface.vertex_count()];
            for part in mesh.parts.iter().filter(|part| names(part).iter().any(|name| parts.items.contains(name))) {
                let corners = part.polygons.clone().flat_map(|polygon| mesh.polygons.get(polygon));
                corners.filter_map(|&v| surface.vertex_of[v as usize]).for_each(|v| inside[v as usize] = true);
            }
            Ok(Region::Inside(inside))
        }
        (None, None, Some(channel), None, None) => {
            let Some(colors) = &target.sequence.rest.vertex_colors else {
                let hint = "paint its vertices in a format that keeps colours, or use `parts` or `vertices`";
                return Err(("the vertices of the target have no colours".into(), hint.into()));
            };
            let share = |&v: &u32| colors[v as usize][channel_index(channel)].clamp(0.0, 1.0);
            Ok(Region::Shares(surface.representative.iter().map(share).collect()))
        }
        (None, None, None, Some(shape), None) => {
            let Some(pose) = poses.iter().find(|pose| pose.name == *shape) else {
                let known = || format!("shapes: {}", some_of(patterns.names));
                let hint = did_you_mean(shape, patterns.names).unwrap_or_else(known);
                return Err((format!("no shape of the source is called `{shape}`"), hint));
            };
            if !has_map {
                let hint = "name a `correspondence`, or use `parts` or `vertices`";
                return Err(("nothing tells which of the target follows a shape of the source".into(), hint.into()));
            }
            Ok(Region::MovedBy(pose.clone()))
        }
        (None, None, None, None, Some(file)) => {
            let shares = read_mask(&file, surface.vertex_of.len())?;
            Ok(Region::Shares(surface.representative.iter().map(|&v| shares[v as usize]).collect()))
        }
        _ => Err((
            "a mask has one of the keys `vertices`, `parts`, `color`, `shape` and `file`".into(),
            "e.g. `{ parts: [Face] }`".into(),
        )),
    }
}

fn channel_index(channel: Channel) -> usize {
    match channel {
        Channel::Red => 0,
        Channel::Green => 1,
        Channel::Blue => 2,
        Channel::Alpha => 3,
    }
}
