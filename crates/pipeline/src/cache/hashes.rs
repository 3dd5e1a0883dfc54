//! Hashes of what results depend on: settings, meshes, poses, markers, files.

use std::path::Path;

use blake3::{Hash, Hasher};
use mimesh_core::{mesh::Surface, stage::Marker};
use mimesh_document::Step;
use nalgebra::Point3;
use serde_json::{Value, json};

use crate::{
    formats::Formats,
    input::{FileHashes, GroundTruth, PoseFrom, PoseInput, Prepared, RestMesh, evenly_spaced},
    json::to_bytes,
    schema::{FileSetting, SchemaNode, file_settings},
    shapes::{Region, ShapeEdit},
};

/// The `settings` in `slot` without the paths of files, and for each of these files its extension and its hash.
pub(super) fn settings_and_files(slot: &str, mut settings: Value, hashes: &FileHashes) -> (Value, Value) {
    let node = SchemaNode::pipeline().entry(&Step::Key(slot.into()), None);
    let files = node.map(|node| file_settings(node, &settings)).unwrap_or_default();
    let mut hashed = Vec::new();
    for FileSetting { path, file } in files {
        let extension = file.extension().unwrap_or_default().to_string_lossy().into_owned();
        hashed.push(json!([extension, hashes.hash(&file)]));
        if let Some(setting) = path.iter().try_fold(&mut settings, |value, step| step.get_mut(value)) {
            *setting = Value::Null;
        }
    }
    (settings, Value::Array(hashed))
}

/// The hash of the poses that a transfer learns from: `wanted` of `poses`.
pub(super) fn hash_of_chosen(poses: &[Option<Hash>], wanted: usize) -> Value {
    let chosen = evenly_spaced(poses.len(), wanted).into_iter();
    let hex: Vec<String> =
        chosen.map(|i| poses[i].map_or_else(String::new, |hash| hash.to_hex().to_string())).collect();
    json!(blake3::hash(hex.join(" ").as_bytes()).to_hex().to_string())
}

/// The hash of a pose of `source`, whose own hash is `of_source`.
pub(super) fn hash_of_pose(
    source: &RestMesh,
    of_source: &str,
    pose: &PoseInput,
    formats: &Formats,
    hashes: &FileHashes,
) -> Option<Hash> {
    let mut hasher = Hasher::new();
    match &pose.from {
        PoseFrom::Held(i) => update_points(&mut hasher, &source.sequence.poses[*i].positions.get().ok()?),
        PoseFrom::File(path) => {
            // How a file is read may depend on the mesh at rest.
            hasher.update(of_source.as_bytes());
            hasher.update(source.poses_change.to_string().as_bytes());
            update_file(&mut hasher, formats, hashes, path)?;
        }
    }
    Some(hasher.finalize())
}

/// The hash of what becomes of a shape: `Some(None)` if it stays as it is, `None` if a file cannot be read.
pub(super) fn hash_of_edit(edit: &ShapeEdit, prepared: &Prepared, of_source: &str) -> Option<Option<Hash>> {
    if edit.is_none() {
        return Some(None);
    }
    let mut hasher = Hasher::new();
    hasher.update(&to_bytes(&(edit.mirrored, edit.strength)));
    match edit.region.as_deref() {
        None => {}
        Some(Region::MovedBy(pose)) => {
            let of_pose = hash_of_pose(&prepared.source, of_source, pose, &prepared.formats, &prepared.hashes)?;
            hasher.update(of_pose.as_bytes());
        }
        Some(region) => _ = hasher.update(&to_bytes(region)),
    }
    Some(Some(hasher.finalize()))
}

/// The hash of a pose with what becomes of it.
pub(super) fn with_edit(pose: Hash, edit: Option<Option<Hash>>) -> Option<Hash> {
    Some(match edit? {
        None => pose,
        Some(edit) => blake3::hash(&[pose.as_bytes().as_slice(), edit.as_bytes()].concat()),
    })
}

/// The hash of the ground truth of pose `i`, or of there being none.
pub(super) fn hash_of_ground_truth(prepared: &Prepared, i: usize) -> Option<Hash> {
    let mut hasher = Hasher::new();
    match &prepared.truth {
        GroundTruth::None => _ = hasher.update(b"none"),
        GroundTruth::Held(by_name) => {
            if let Some(positions) = by_name.get(&prepared.poses[i].name) {
                update_points(&mut hasher, &positions.get().ok()?);
            }
        }
        GroundTruth::Files { files, .. } => update_file(&mut hasher, &prepared.formats, &prepared.hashes, &files[i])?,
    }
    Some(hasher.finalize())
}

pub(super) fn hash_of_mesh(mesh: &RestMesh) -> String {
    let mut hasher = Hasher::new();
    let rest = &mesh.sequence.rest;
    let Surface {
        positions,
        triangles,
        polygon_of,
        vertex_of,
        representative,
        // Given by the positions at rest and the triangles.
        strays: _,
        part_names,
        part_of,
        other_names,
    } = &mesh.surface;
    hasher.update(&(rest.positions.len() as u64).to_le_bytes());
    hasher.update(&(positions.len() as u64).to_le_bytes());
    update_points(&mut hasher, &rest.positions);
    update_points(&mut hasher, positions);
    let vertex_of: Vec<u32> = vertex_of.iter().map(|v| v.unwrap_or(u32::MAX)).collect();
    for numbers in [polygon_of, &vertex_of, representative, part_of] {
        hasher.update(&(numbers.len() as u64).to_le_bytes());
        numbers.iter().for_each(|n| _ = hasher.update(&n.to_le_bytes()));
    }
    triangles.iter().flatten().for_each(|n| _ = hasher.update(&n.to_le_bytes()));
    hasher.update(&to_bytes(&(part_names, other_names, mesh.mirror_axis())));
    hasher.finalize().to_hex().to_string()
}

pub(super) fn hash_of_markers(markers: &[Marker]) -> String {
    let all: Vec<_> = markers.iter().map(|marker| (&marker.name, marker.source, marker.target)).collect();
    blake3::hash(&to_bytes(&all)).to_hex().to_string()
}

fn update_points(hasher: &mut Hasher, points: &[Point3<f64>]) {
    points.iter().flat_map(|p| p.coords.as_slice()).for_each(|x| _ = hasher.update(&x.to_le_bytes()));
}

/// Adds a mesh file: its contents and those of the files that it names, and the settings of formats and the extension, on which
/// its reading depends.
fn update_file(hasher: &mut Hasher, formats: &Formats, hashes: &FileHashes, path: &Path) -> Option<()> {
    hasher.update(&to_bytes(formats.all()));
    hasher.update(path.extension().unwrap_or_default().as_encoded_bytes());
    for file in formats.files(path) {
        hasher.update(hashes.hash(&file)?.as_bytes());
    }
    Some(())
}
