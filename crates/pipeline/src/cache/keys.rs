//! The keys of results: hashes of all that a result depends on.

use std::collections::HashSet;

use blake3::{Hash, Hasher};
use rayon::prelude::*;
use serde::Serialize;
use serde_json::{Map, Value};

use super::{
    hashes::{
        hash_of_chosen, hash_of_edit, hash_of_ground_truth, hash_of_markers, hash_of_mesh, hash_of_pose,
        settings_and_files, with_edit,
    },
    store::Key,
};
use crate::{
    formats::Formats,
    input::{FileHashes, PoseInput, Prepared, RestMesh, evenly_spaced},
    json::{to_bytes, to_value},
    metrics::MEASURED_BEFORE,
    programs::program_file,
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
    /// The hash of the contents of each pose; `None` for a pose that cannot be read, or is not asked for.
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
        Self::where_wanted(prepared, program, |_| true)
    }

    /// The keys for `prepared` without those of poses other than `poses`, which stand alone: only they, the two before each and those that
    /// the transfer learns from are read.
    pub fn of_part(prepared: &Prepared, program: &str, poses: &[usize]) -> Self {
        let learned = prepared.pipeline.transfer.as_ref().map_or(0, |transfer| transfer.poses_wanted());
        let mut wanted: HashSet<usize> = evenly_spaced(prepared.poses.len(), learned).into_iter().collect();
        wanted.extend(poses.iter().flat_map(|&i| i.saturating_sub(MEASURED_BEFORE)..=i));
        Self::where_wanted(prepared, program, |i| wanted.contains(&i))
    }

    fn where_wanted(prepared: &Prepared, program: &str, wanted: impl Fn(usize) -> bool + Sync) -> Self {
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
            .enumerate()
            .map(|(i, pose)| match wanted(i) {
                true => hash_of_pose(&prepared.source, &source, pose, &prepared.formats, hashes),
                false => None,
            })
            .collect();
        let of_edits = prepared.shape_edits.par_iter().enumerate().map(|(i, edit)| match wanted(i) {
            true => hash_of_edit(edit, prepared, &source),
            false => None,
        });
        let poses_alone = poses;
        let poses: Vec<_> =
            poses_alone.par_iter().zip(of_edits).map(|(pose, edit)| with_edit((*pose)?, edit)).collect();
        let (settings, files) = settings_and_files("transfer", to_value(&pipeline.transfer), hashes);
        let learned = pipeline.transfer.as_ref().map_or(0, |transfer| transfer.poses_wanted());
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
                ("poses it learns from", hash_of_chosen(&poses_alone, learned)),
                ("poses are", to_value(&prepared.poses_are)),
            ],
        );
        let metrics = settings_and_files("metrics", to_value(&prepared.metrics), hashes);
        let metrics = blake3::hash(&to_bytes(&(program, metrics)));
        let of_ground_truth = |i: usize| if wanted(i) { hash_of_ground_truth(prepared, i) } else { None };
        let ground_truths = (0..poses.len()).into_par_iter().map(of_ground_truth).collect();
        Self { landmarks, proximity, correspondence, transfer, poses, metrics, ground_truths }
    }

    /// The [stages](Self::STAGES) with their keys; `None` for one that the pipeline leaves out.
    pub fn stages(&self) -> [(&'static str, Option<&StageKey>); 4] {
        let keys =
            [self.landmarks.as_ref(), self.proximity.as_ref(), self.correspondence.as_ref(), Some(&self.transfer)];
        std::array::from_fn(|i| (Self::STAGES[i], keys[i]))
    }

    /// The key of the measurements of pose `i`, which depend on the two poses before it too; `result` gives the keys of their results.
    pub fn metrics(&self, i: usize, result: impl Fn(usize) -> Option<Key>) -> Option<Key> {
        let before = |back: usize| i.checked_sub(back).and_then(&result).map_or(blake3::hash(b"none"), |key| key.0);
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

    /// The key of frame `i`'s result in a motion that begins at frame `begin`, `warm` frames before the part that it is for. It is not
    /// the exact result, which depends on all frames before it, and has another key.
    pub fn warm_frame(&self, i: usize, begin: usize, warm: usize) -> Option<Key> {
        let before = self.poses.get(begin..i)?.iter().map(|pose| pose.unwrap_or(blake3::hash(b"unreadable")));
        let place = blake3::hash(&[begin, warm].map(|number| (number as u64).to_le_bytes()).concat());
        Some(self.of_poses("warm", &std::iter::once(place).chain(before).chain([self.poses[i]?]).collect::<Vec<_>>()))
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
