//! The keys of results: hashes of all that a result depends on.

use std::path::Path;

use blake3::{Hash, Hasher};
use mimesh_core::{mesh::Surface, stage::Marker};
use mimesh_document::Step;
use nalgebra::Point3;
use rayon::prelude::*;
use serde::Serialize;
use serde_json::{Map, Value, json};

use super::store::Key;
use crate::{
    formats::Formats,
    input::{FileHashes, GroundTruth, PoseFrom, PoseInput, Prepared, RestMesh, evenly_spaced},
    json::{to_bytes, to_value},
    programs::program_file,
    schema::{FileSetting, SchemaNode, file_settings},
};

/// The key of a stage's result, and the inputs that it is the hash of.
#[derive(Clone, Debug, PartialEq)]
pub struct StageKey {
    /// Settings as JSON, everything else as hashes, by name.
    pub inputs: Map<String, Value>,
    /// The hash of the inputs.
    pub key: Key,
}

impl StageKey {
    fn new(stage: &str, inputs: &[(&str, Value)]) -> Self {
        let inputs: Map<String, Value> =
            inputs.iter().map(|(name, value)| ((*name).to_owned(), value.clone())).collect();
        // serde_json keeps the order of settings, which is that of their declaration.
        Self { key: Key(blake3::hash(&to_bytes(&(stage, &inputs)))), inputs }
    }

    fn hex(&self) -> String {
        self.key.0.to_hex().to_string()
    }
}

/// The keys of a run.
#[derive(Clone, Debug)]
pub struct RunKeys {
    /// The key of the markers that a stage proposes, if there is one.
    pub landmarks: Option<StageKey>,
    /// The key of the proximity graph, if there is one.
    pub proximity: Option<StageKey>,
    /// The key of the triangle map, if there is one.
    pub correspondence: Option<StageKey>,
    /// The key of the bound transfer.
    pub transfer: StageKey,
    /// The hash of the contents of each pose; `None` for a pose that cannot be read.
    poses: Vec<Option<Hash>>,
    /// The hash of the metrics with their settings.
    metrics: Hash,
    /// The hash of the ground truth of each pose; `None` for one that cannot be read.
    ground_truths: Vec<Option<Hash>>,
}

impl RunKeys {
    /// The stages that run once, in their order.
    pub const STAGES: [&'static str; 4] = ["landmarks", "proximity", "correspondence", "transfer"];

    /// The keys for `prepared`, computed by `program`.
    pub fn new(prepared: &Prepared, program: &str) -> Self {
        let (source, target) = (hash_of_mesh(&prepared.source), hash_of_mesh(&prepared.target));
        let pipeline = &prepared.pipeline;
        let hashes = &prepared.hashes;
        let proximity = pipeline.proximity.as_ref().map(|stage| proximity_of(stage, &target, hashes, program));
        let proximity_hex = to_value(&proximity.as_ref().map(StageKey::hex));
        let landmarks = prepared.landmarks().map(|stage| {
            let (settings, files) = settings_and_files("markers", to_value(stage), hashes);
            let command = stage.command().and_then(|command| program_file(command.first()?));
            StageKey::new(
                "landmarks",
                &[
                    ("program", program.into()),
                    ("files", files),
                    ("settings", settings),
                    ("command", to_value(&command.and_then(|file| hashes.hash(&file)))),
                    ("clicks", hash_of_markers(&prepared.clicks).into()),
                    ("source", source.clone().into()),
                    ("target", target.clone().into()),
                ],
            )
        });
        // Proposed markers are not known before the run, but all that they depend on is.
        let markers: Value = match &landmarks {
            Some(key) => key.hex().into(),
            None => hash_of_markers(prepared.markers()).into(),
        };
        let correspondence = pipeline.correspondence.as_ref().map(|stage| {
            let (settings, files) = settings_and_files("correspondence", to_value(stage), hashes);
            StageKey::new(
                "correspondence",
                &[
                    ("program", program.into()),
                    ("files", files),
                    ("settings", settings),
                    ("source", source.clone().into()),
                    ("target", target.clone().into()),
                    ("markers", markers.clone()),
                    ("proximity", proximity_hex.clone()),
                ],
            )
        });
        let poses: Vec<_> = prepared
            .poses
            .par_iter()
            .map(|pose| hash_of_pose(&prepared.source, &source, pose, &prepared.formats, hashes))
            .collect();
        let (settings, files) = settings_and_files("transfer", to_value(&pipeline.transfer), hashes);
        let wanted = pipeline.transfer.as_ref().map_or(0, |transfer| transfer.poses_wanted());
        let transfer = StageKey::new(
            "transfer",
            &[
                ("program", program.into()),
                ("files", files),
                ("settings", settings),
                ("source", source.into()),
                ("target", target.into()),
                ("markers", markers),
                ("proximity", proximity_hex),
                ("correspondence", to_value(&correspondence.as_ref().map(StageKey::hex))),
                ("poses it learns from", hash_of_chosen(&poses, wanted)),
                ("poses are", to_value(&prepared.poses_are)),
            ],
        );
        let metrics = settings_and_files("metrics", to_value(&prepared.metrics), hashes);
        let metrics = blake3::hash(&to_bytes(&(program, metrics)));
        let ground_truths = (0..poses.len()).into_par_iter().map(|i| hash_of_ground_truth(prepared, i)).collect();
        Self { landmarks, proximity, correspondence, transfer, poses, metrics, ground_truths }
    }

    /// The [stages](Self::STAGES) with their keys; `None` for one that the pipeline leaves out.
    pub fn stages(&self) -> [(&'static str, Option<&StageKey>); 4] {
        let keys =
            [self.landmarks.as_ref(), self.proximity.as_ref(), self.correspondence.as_ref(), Some(&self.transfer)];
        std::array::from_fn(|i| (Self::STAGES[i], keys[i]))
    }

    /// The key of the measurements of pose `i`, which depend on the two poses before it too.
    pub fn metrics(&self, i: usize, motion: bool) -> Option<Key> {
        let result = |i: usize| if motion { self.frame(i) } else { self.pose(i) };
        let before = |back: usize| i.checked_sub(back).and_then(result).map_or(blake3::hash(b"none"), |key| key.0);
        Some(self.of_poses("metrics", &[result(i)?.0, before(1), before(2), self.metrics, self.ground_truths[i]?]))
    }

    /// The key of pose `i`'s result, where poses stand alone.
    pub fn pose(&self, i: usize) -> Option<Key> {
        Some(self.of_poses("pose", &[self.poses[i]?]))
    }

    /// The key of frame `i`'s result, which depends on all frames before it.
    pub fn frame(&self, i: usize) -> Option<Key> {
        let before: Vec<_> = self.poses[..i].iter().map(|pose| pose.unwrap_or(blake3::hash(b"unreadable"))).collect();
        Some(self.of_poses("frame", &[&before[..], &[self.poses[i]?]].concat()))
    }

    fn of_poses(&self, kind: &str, poses: &[Hash]) -> Key {
        let mut hasher = Hasher::new();
        hasher.update(kind.as_bytes());
        hasher.update(self.transfer.key.0.as_bytes());
        poses.iter().for_each(|pose| _ = hasher.update(pose.as_bytes()));
        Key(hasher.finalize())
    }
}

/// The key of the proximity graph that `stage` makes of `target`, computed by `program`.
pub fn proximity_key<S: Serialize + ?Sized>(
    stage: &S,
    target: &RestMesh,
    hashes: &FileHashes,
    program: &str,
) -> StageKey {
    proximity_of(stage, &hash_of_mesh(target), hashes, program)
}

/// The key of the seams of `source` that `poses` part, decided by `program`; `None` if a pose cannot be read.
///
/// `source` has all its seams welded.
pub fn opened_seams_key(
    source: &RestMesh,
    poses: &[PoseInput],
    formats: &Formats,
    hashes: &FileHashes,
    program: &str,
) -> Option<StageKey> {
    let of_source = hash_of_mesh(source);
    let of_poses: Option<Vec<String>> = poses
        .par_iter()
        .map(|pose| Some(hash_of_pose(source, &of_source, pose, formats, hashes)?.to_hex().to_string()))
        .collect();
    Some(StageKey::new(
        "opened_seams",
        &[
            ("program", program.into()),
            ("weld_tolerance", source.welding.tolerance.into()),
            ("source", of_source.into()),
            ("poses", to_value(&of_poses?)),
        ],
    ))
}

fn proximity_of<S: Serialize + ?Sized>(stage: &S, target: &str, hashes: &FileHashes, program: &str) -> StageKey {
    let (settings, files) = settings_and_files("proximity", to_value(stage), hashes);
    StageKey::new(
        "proximity",
        &[("program", program.into()), ("files", files), ("settings", settings), ("target", target.into())],
    )
}

/// The `settings` in `slot` without the paths of files, and for each of these files its extension and its hash.
fn settings_and_files(slot: &str, mut settings: Value, hashes: &FileHashes) -> (Value, Value) {
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
fn hash_of_chosen(poses: &[Option<Hash>], wanted: usize) -> Value {
    let chosen = evenly_spaced(poses.len(), wanted).into_iter();
    let hex: Vec<String> =
        chosen.map(|i| poses[i].map_or_else(String::new, |hash| hash.to_hex().to_string())).collect();
    json!(blake3::hash(hex.join(" ").as_bytes()).to_hex().to_string())
}

/// The hash of a pose of `source`, whose own hash is `of_source`.
fn hash_of_pose(
    source: &RestMesh,
    of_source: &str,
    pose: &PoseInput,
    formats: &Formats,
    hashes: &FileHashes,
) -> Option<Hash> {
    let mut hasher = Hasher::new();
    match &pose.from {
        PoseFrom::Held(i) => update_points(&mut hasher, &source.sequence.poses[*i].positions.get()),
        PoseFrom::File(path) => {
            // How a file is read may depend on the mesh at rest.
            hasher.update(of_source.as_bytes());
            hasher.update(source.poses_change.to_string().as_bytes());
            update_file(&mut hasher, formats, hashes, path)?;
        }
    }
    Some(hasher.finalize())
}

/// The hash of the ground truth of pose `i`, or of there being none.
fn hash_of_ground_truth(prepared: &Prepared, i: usize) -> Option<Hash> {
    let mut hasher = Hasher::new();
    match &prepared.truth {
        GroundTruth::None => _ = hasher.update(b"none"),
        GroundTruth::Held(by_name) => {
            if let Some(positions) = by_name.get(&prepared.poses[i].name) {
                update_points(&mut hasher, positions);
            }
        }
        GroundTruth::Files { files, .. } => update_file(&mut hasher, &prepared.formats, &prepared.hashes, &files[i])?,
    }
    Some(hasher.finalize())
}

fn hash_of_mesh(mesh: &RestMesh) -> String {
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

fn hash_of_markers(markers: &[Marker]) -> String {
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
