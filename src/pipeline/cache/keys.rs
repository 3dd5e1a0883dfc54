//! What the result of each stage depends on.

use std::path::Path;

use rayon::prelude::*;
use serde_json::{Map, Value, json};

use super::store::Key;
use crate::{
    core::{
        mesh::{MeshSequence, Surface},
        stage::Marker,
    },
    pipeline::{
        check::{PoseFrom, PoseInput, Prepared, Side, Truth},
        hash_file, poses,
    },
};

/// All that a result depends on, by name; its hash is the key.
#[derive(Clone, Debug, PartialEq)]
pub struct Recipe {
    /// Settings as JSON, everything else as hashes.
    pub ingredients: Map<String, Value>,
    /// The hash of the ingredients.
    pub key: Key,
}

impl Recipe {
    fn new(stage: &str, ingredients: Value) -> Self {
        let Value::Object(ingredients) = ingredients else { unreachable!("ingredients have names") };
        // serde_json keeps the order of settings, which is that of their declaration.
        let text = serde_json::to_vec(&(stage, &ingredients)).unwrap_or_default();
        Self { key: Key(blake3::hash(&text)), ingredients }
    }
}

/// The recipes of a run.
#[derive(Clone, Debug)]
pub struct Recipes {
    /// Of the proximity graph, if there is one.
    pub proximity: Option<Recipe>,
    /// Of the triangle map, if there is one.
    pub correspondence: Option<Recipe>,
    /// Of the bound transfer.
    pub transfer: Recipe,
    /// The contents of each pose; `None` for one that cannot be read.
    pub poses: Vec<Option<blake3::Hash>>,
    /// The metrics, with their settings.
    metrics: blake3::Hash,
    /// The known result of each pose; `None` for one that cannot be read.
    truths: Vec<Option<blake3::Hash>>,
}

impl Recipes {
    /// The recipes for `prepared`, computed by `program`.
    pub fn new(prepared: &Prepared, program: &str) -> Self {
        let (source, target) = (of_side(&prepared.source), of_side(&prepared.target));
        let pipeline = &prepared.pipeline;
        let settings = |stage: Option<Value>| {
            let stage = stage.unwrap_or_default();
            let files = files_in(&stage);
            (stage, files)
        };
        let proximity = pipeline.proximity.as_ref().map(|stage| {
            let (settings, files) = settings(serde_json::to_value(stage).ok());
            Recipe::new(
                "proximity",
                json!({ "program": program, "settings": settings, "files": files, "target": target }),
            )
        });
        let of_proximity = proximity.as_ref().map(|recipe| recipe.key.0.to_hex().to_string());
        let markers = of_markers(&prepared.markers);
        let correspondence = pipeline.correspondence.as_ref().map(|stage| {
            let (settings, files) = settings(serde_json::to_value(stage).ok());
            Recipe::new(
                "correspondence",
                json!({
                    "program": program, "settings": settings, "files": files, "source": source, "target": target,
                    "markers": markers, "proximity": of_proximity,
                }),
            )
        });
        let poses: Vec<_> = prepared.poses.par_iter().map(|pose| of_pose(prepared, &source, pose)).collect();
        let wanted = pipeline.transfer.as_ref().map_or(0, |transfer| transfer.poses_wanted());
        let learned: Vec<String> = poses::spread(poses.len(), wanted)
            .into_iter()
            .map(|i| poses[i].map_or_else(String::new, |hash| hash.to_hex().to_string()))
            .collect();
        let (settings, files) = settings(serde_json::to_value(&pipeline.transfer).ok());
        let transfer = Recipe::new(
            "transfer",
            json!({
                "program": program, "settings": settings, "files": files, "source": source, "target": target,
                "markers": markers, "proximity": of_proximity,
                "correspondence": correspondence.as_ref().map(|recipe| recipe.key.0.to_hex().to_string()),
                "poses it learns from": blake3::hash(learned.join(" ").as_bytes()).to_hex().to_string(),
            }),
        );
        let metrics = serde_json::to_value(&prepared.metrics).unwrap_or_default();
        let metrics = serde_json::to_vec(&(program, files_in(&metrics), &metrics)).unwrap_or_default();
        let truths = (0..poses.len()).into_par_iter().map(|i| of_truth(prepared, i)).collect();
        Self { proximity, correspondence, transfer, poses, metrics: blake3::hash(&metrics), truths }
    }

    /// The key of what metrics say of pose `i`, which depends on the two before it too.
    pub fn judged(&self, i: usize, motion: bool) -> Option<Key> {
        let of = |i: usize| if motion { self.frame(i) } else { self.pose(i) };
        let before = |back: usize| i.checked_sub(back).and_then(of).map_or(blake3::hash(b"none"), |key| key.0);
        Some(self.of_poses("judged", &[of(i)?.0, before(1), before(2), self.metrics, self.truths[i]?]))
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

    fn of_poses(&self, kind: &str, poses: &[blake3::Hash]) -> Key {
        let mut hasher = blake3::Hasher::new();
        hasher.update(kind.as_bytes());
        hasher.update(self.transfer.key.0.as_bytes());
        poses.iter().for_each(|pose| _ = hasher.update(pose.as_bytes()));
        Key(hasher.finalize())
    }
}

/// The hash of the running program: a stage of another program may compute something else, whatever its version says.
pub fn program() -> Option<String> {
    hash_file(&std::env::current_exe().ok()?).ok()
}

/// The hashes of all files that settings name.
fn files_in(settings: &Value) -> Value {
    fn collect(value: &Value, files: &mut Map<String, Value>) {
        match value {
            Value::String(text) if !text.is_empty() && Path::new(text).is_file() => {
                if let Ok(hash) = hash_file(Path::new(text)) {
                    files.insert(text.clone(), hash.into());
                }
            }
            Value::Array(list) => list.iter().for_each(|item| collect(item, files)),
            Value::Object(map) => map.values().for_each(|item| collect(item, files)),
            _ => {}
        }
    }
    let mut files = Map::new();
    collect(settings, &mut files);
    Value::Object(files)
}

fn of_pose(prepared: &Prepared, source: &str, pose: &PoseInput) -> Option<blake3::Hash> {
    let mut hasher = blake3::Hasher::new();
    match &pose.from {
        PoseFrom::Held(i) => {
            let positions = &prepared.source.sequence.poses[*i].positions;
            positions.iter().for_each(|p| update(&mut hasher, p.coords.as_slice()));
        }
        // How a file is read may depend on the mesh at rest and on the settings of its format.
        PoseFrom::File(path) => {
            hasher.update(source.as_bytes());
            hasher.update(serde_json::to_string(prepared.formats.all()).unwrap_or_default().as_bytes());
            hasher.update(path.extension().unwrap_or_default().as_encoded_bytes());
            hasher.update(hash_file(path).ok()?.as_bytes());
        }
    }
    Some(hasher.finalize())
}

/// The known result of pose `i`, or that there is none.
fn of_truth(prepared: &Prepared, i: usize) -> Option<blake3::Hash> {
    let mut hasher = blake3::Hasher::new();
    match &prepared.truth {
        Truth::None => _ = hasher.update(b"none"),
        Truth::Held(by_name) => {
            let positions = by_name.get(&prepared.poses[i].name).into_iter().flatten();
            positions.for_each(|p| update(&mut hasher, p.coords.as_slice()));
        }
        Truth::Files(files) => {
            hasher.update(serde_json::to_string(prepared.formats.all()).unwrap_or_default().as_bytes());
            hasher.update(files[i].extension().unwrap_or_default().as_encoded_bytes());
            hasher.update(hash_file(&files[i]).ok()?.as_bytes());
        }
    }
    Some(hasher.finalize())
}

fn of_side(side: &Side) -> String {
    let mut hasher = blake3::Hasher::new();
    let MeshSequence { rest, .. } = &side.sequence;
    let Surface { positions, triangles, polygon_of, vertex_of, representative, part_names, part_of, other_names } =
        &side.surface;
    hasher.update(&(rest.positions.len() as u64).to_le_bytes());
    hasher.update(&(positions.len() as u64).to_le_bytes());
    rest.positions.iter().chain(positions).for_each(|p| update(&mut hasher, p.coords.as_slice()));
    for numbers in [polygon_of, vertex_of, representative, part_of] {
        hasher.update(&(numbers.len() as u64).to_le_bytes());
        numbers.iter().for_each(|n| _ = hasher.update(&n.to_le_bytes()));
    }
    triangles.iter().flatten().for_each(|n| _ = hasher.update(&n.to_le_bytes()));
    let names = serde_json::to_vec(&(part_names, other_names)).unwrap_or_default();
    hasher.update(&names);
    hasher.finalize().to_hex().to_string()
}

fn of_markers(markers: &[Marker]) -> String {
    let all: Vec<_> = markers.iter().map(|marker| (&marker.name, marker.source, marker.target)).collect();
    blake3::hash(&serde_json::to_vec(&all).unwrap_or_default()).to_hex().to_string()
}

fn update(hasher: &mut blake3::Hasher, numbers: &[f64]) {
    numbers.iter().for_each(|x| _ = hasher.update(&x.to_le_bytes()));
}
