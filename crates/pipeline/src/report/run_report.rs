//! What a run did: the contents of `run.json`, from which the summary is made.

use std::path::PathBuf;

use mimesh_core::{
    Figures,
    mesh::{MeshPoint, Topology},
    spatial::UpAxis,
};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::{process::Usage, stage::StageReport, statistics::Statistics};
use crate::{
    choices::Choice,
    compose::Variant,
    input::RestMesh,
    metrics::{Level, Verdict},
    staging::WrittenFile,
};

/// A run, whole.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Report {
    /// The program's version.
    pub mimesh: String,
    /// `done`, or `partly` if some poses failed.
    pub status: String,
    /// The pipeline's file.
    #[serde(serialize_with = "crate::json::path")]
    pub pipeline: PathBuf,
    /// The file that the run wrote this report into; empty in reports of older versions.
    #[serde(default, serialize_with = "crate::json::path")]
    pub place: PathBuf,
    /// Which of its runs this was, if it declares several.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub run: Option<RunOf>,
    /// Which of its poses these are, if the run was split; such a report is written into no file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub part: Option<PartReport>,
    /// Its settings in full, with defaults and with the values that were set beside the file.
    pub settings: Value,
    /// The values that were set beside the file.
    pub set: Vec<String>,
    /// Threads used.
    pub threads: usize,
    /// Every file read.
    pub inputs: Vec<InputReport>,
    /// The mesh that gave its motion.
    pub source: MeshFigures,
    /// The mesh that took it.
    pub target: MeshFigures,
    /// What was chosen where the pipeline leaves it open, in the order of its slots.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub choices: Vec<Choice>,
    /// Number of markers.
    pub markers: usize,
    /// The markers that a stage proposed; none where the user gave them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub proposed_markers: Vec<ProposedMarker>,
    /// The worst verdict of any pose and of what they share; none where nothing was measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub verdict: Option<Level>,
    /// The verdict on rest meshes, markers and map, whose faults all poses share; none where they were not measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rest_verdict: Option<Verdict>,
    /// How the pictures of the target see it; none where nothing was drawn.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub target_view: Option<MeshView>,
    /// The gates of the pipeline.
    #[serde(default, skip_serializing_if = "Map::is_empty")]
    pub gates: Map<String, Value>,
    /// The stages in their order.
    pub stages: Vec<StageReport>,
    /// The poses in their order.
    pub poses: Vec<PoseReport>,
    /// For each metric its statistics over all poses.
    #[serde(default, skip_serializing_if = "Map::is_empty")]
    pub metrics: Map<String, Value>,
    /// Every file written, without this one.
    pub outputs: Vec<WrittenFile>,
    /// Sentences about what looks wrong or was left out.
    pub warnings: Vec<String>,
    /// Seconds from the start of reading until this report; of several runs, those of this one.
    pub seconds: f64,
    /// What the process used, from its own start.
    pub process: Usage,
}

impl Report {
    /// The verdicts on map and markers and on all poses.
    pub fn verdicts(&self) -> impl Iterator<Item = &Verdict> {
        self.rest_verdict.iter().chain(self.poses.iter().filter_map(|pose| pose.verdict.as_ref()))
    }
}

/// One of the runs that a pipeline declares.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct RunOf {
    /// Its name, which `{name}` stands for.
    pub name: String,
    /// The target's name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub target: Option<String>,
    /// The keys that the matrix varies, with their values.
    #[serde(default, skip_serializing_if = "Map::is_empty")]
    pub matrix: Map<String, Value>,
}

impl RunOf {
    /// The run of `variant`; `None` for the only run of a file.
    pub fn new(variant: &Variant) -> Option<Self> {
        let Variant { name, target, values, .. } = variant;
        variant.is_declared().then(|| Self {
            name: name.clone(),
            target: target.clone(),
            matrix: values.iter().cloned().collect(),
        })
    }
}

/// Some of the poses of a run.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct PartReport {
    /// The poses by number, from 0, e.g. `0-3,7`; empty for a shard without poses.
    pub frames: String,
    /// The number of poses.
    pub poses: usize,
    /// The number of poses of the whole run.
    pub of: usize,
    /// The shard, e.g. `1/4`, if it is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shard: Option<String>,
    /// How many frames of a motion were computed before each stretch of frames, and thrown away.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub warm: Option<usize>,
}

/// How pictures see a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub struct MeshView {
    /// The axis that points up once it is turned.
    pub up: UpAxis,
    /// The rotation that turns it, column by column.
    pub turn: [[f64; 3]; 3],
}

/// A file that was read.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct InputReport {
    /// What it is.
    pub role: String,
    /// The file.
    #[serde(serialize_with = "crate::json::path")]
    pub path: PathBuf,
    /// Its size.
    pub bytes: u64,
    /// The hash of its contents.
    pub blake3: String,
}

/// A marker that a stage proposed.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct ProposedMarker {
    /// Its name.
    pub name: String,
    /// The point of the source's file.
    pub source: MeshPoint,
    /// The point of the target's file.
    pub target: MeshPoint,
    /// How sure it is, from 0 to 1.
    pub confidence: f64,
}

/// Counts and size of a mesh.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct MeshFigures {
    /// Vertices of the file.
    pub vertices: usize,
    /// Polygons of the file.
    pub polygons: usize,
    /// Vertices after welding seams, with those that no face uses.
    pub welded_vertices: usize,
    /// Triangles after cutting polygons.
    pub triangles: usize,
    /// Connected components.
    pub components: usize,
    /// Edges of more than two triangles.
    pub non_manifold_edges: usize,
    /// Length of the diagonal of the bounding box, in the unit of the file.
    pub diagonal: f64,
}

/// A pose.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
pub struct PoseReport {
    /// Its name.
    pub name: String,
    /// Why it failed, if it did.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<Value>,
    /// Whether its result was cached by an earlier run.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub reused: bool,
    /// What the transfer reports of it.
    pub figures: Figures,
    /// The verdict on it, without the faults that all poses share; `None` if it was not measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub verdict: Option<Verdict>,
    /// The verdict on what all poses share, as this one gives it; reported once for the run.
    #[serde(skip)]
    pub rest_verdict: Option<Verdict>,
    /// For each metric its statistics.
    #[serde(default, skip_serializing_if = "Statistics::is_empty")]
    pub metrics: Statistics,
    /// The statistics of the target at rest against the ground truth, as if nothing had been transferred.
    #[serde(rename = "nothing", default, skip_serializing_if = "Statistics::is_empty")]
    pub rest_baseline: Statistics,
}

impl MeshFigures {
    /// The counts and the size of a mesh.
    pub fn new(side: &RestMesh) -> Self {
        let mesh = &side.sequence.rest;
        Self {
            vertices: mesh.positions.len(),
            polygons: mesh.polygons.len(),
            welded_vertices: side.surface.vertex_count() + side.surface.strays.len(),
            triangles: side.surface.triangle_count(),
            components: side.surface.components().count(),
            non_manifold_edges: Topology::new(&side.surface.triangles).non_manifold.len(),
            diagonal: mesh.diagonal(),
        }
    }
}
