//! Pipelines that are read and checked, ready to run.

use std::{
    borrow::Cow,
    path::PathBuf,
    sync::{Arc, OnceLock},
};

use mimesh_core::{
    mesh::{Mesh, PosesAre},
    spatial::MeshUnits,
    stage::{Correspondence, Format, KeyPoints, Landmarks, Marker, Metric, ProximityGraph},
};
use mimesh_document::Document;
use mimesh_markers::MarkerFiles;

use super::{FileHashes, GroundTruth, HelpCommands, OutputChange, Outputs, PoseInput, RestMesh};
use crate::{
    choices::Choice, compose::Variant, formats::Formats, metrics::Gate, report::StageReport, shapes::ShapeEdit,
    spec::Pipeline,
};

/// A pipeline without mistakes, its rest meshes read.
#[derive(Debug)]
pub struct Prepared {
    /// The pipeline's file.
    pub file: PathBuf,
    /// The targets and values that distinguish it from the other runs of the file.
    pub variant: Variant,
    /// The settings, with what was chosen; paths of stages are relative to the current folder.
    pub pipeline: Pipeline,
    /// The values that were set beside the file.
    pub set: Vec<String>,
    /// The formats, with the pipeline's settings.
    pub formats: Formats,
    /// The mesh that gives its motion; runs of one file share it.
    pub source: Arc<RestMesh>,
    /// The mesh that takes the motion; combinations of one matrix share it.
    pub target: Arc<RestMesh>,
    /// The poses of the source, at least one.
    pub poses: Vec<PoseInput>,
    /// What becomes of each pose once the target has it, in the order of `poses`.
    pub shape_edits: Vec<ShapeEdit>,
    /// What the poses are to each other.
    pub poses_are: PosesAre,
    /// Pairs of points of the two surfaces; those that a stage proposes are there once it has run.
    pub markers: OnceLock<Vec<Marker>>,
    /// The user's own markers beside a stage that proposes others.
    pub clicks: Vec<Marker>,
    /// Whether stages may run programs of the user's.
    pub allow_commands: bool,
    /// The commands of the host that the page of the run names.
    pub help: HelpCommands,
    /// The script of the page's 3D view, if the pipeline asks for one.
    pub view_script: Option<Cow<'static, str>>,
    /// The proximity graph of the target, which the checks of stages needed; `None` if there is no such stage.
    pub proximity: Option<ProximityInput>,
    /// The known results.
    pub truth: GroundTruth,
    /// The metrics that every pose is measured with.
    pub metrics: Vec<Box<dyn Metric>>,
    /// The limits that statistics must keep.
    pub gates: Vec<Gate>,
    /// The files that are written.
    pub outputs: Outputs,
    /// The change of unit and axes of results in files of bare numbers.
    pub output_change: Option<OutputChange>,
    /// Every file that is read.
    pub inputs: Vec<InputFile>,
    /// Sizes and hashes of the inputs.
    pub hashes: Arc<FileHashes>,
    /// What was chosen where the pipeline leaves it open, in the order of its slots.
    pub choices: Vec<Choice>,
    /// The pipeline as it was written, with the places of its values.
    pub document: Document,
    /// Sentences about what looks wrong or was left out.
    pub warnings: Vec<String>,
    /// Sentences about what other runs have left, or do, where this one writes. The run says itself what has become of it.
    pub unfinished: Vec<String>,
    /// The time that reading and checking took, without the proximity graph.
    pub reading: StageReport,
}

impl Prepared {
    /// Pairs of points of the two surfaces; none until a stage that proposes them has run.
    pub fn markers(&self) -> &[Marker] {
        self.markers.get().map_or(&[], Vec::as_slice)
    }

    /// The change of unit and axes of results in files of `format`, if there is one.
    pub fn output_change(&self, format: &dyn Format) -> Option<&OutputChange> {
        self.output_change.as_ref().filter(|_| format.with_units(MeshUnits::default()).is_none())
    }

    /// The target at rest, as files of `format` have it.
    pub fn written_rest(&self, format: &dyn Format) -> &Mesh {
        self.output_change(format).map_or(&self.target.sequence.rest, OutputChange::rest)
    }

    /// The stage that proposes the markers, if there is one.
    pub fn landmarks(&self) -> Option<&dyn Landmarks> {
        self.pipeline.markers.as_ref()?.stage()
    }

    /// Seconds from the start of reading until the pipeline was ready to run.
    pub fn seconds(&self) -> f64 {
        self.reading.seconds + self.proximity.as_ref().map_or(0.0, |proximity| proximity.report.seconds)
    }
}

/// The part of a pipeline that key points are chosen by: its source, without mistakes.
#[derive(Debug)]
pub struct PreparedSource {
    /// The mesh that gives its motion.
    pub source: RestMesh,
    /// Its poses, at least one.
    pub poses: Vec<PoseInput>,
    /// The formats, with the pipeline's settings.
    pub formats: Formats,
    /// The stage that chooses.
    pub key_points: Box<dyn KeyPoints>,
    /// The pipeline's file of markers, as seen from the current folder.
    pub markers: Option<PathBuf>,
    /// The target's file, as the pipeline spells it.
    pub target: Option<PathBuf>,
    /// The files that the pipeline reads, as far as these slots name them.
    pub inputs: Vec<InputFile>,
}

/// The part of a pipeline that markers lie on: its two meshes at rest, without mistakes.
#[derive(Debug)]
pub struct Meshes {
    /// The mesh that gives its motion.
    pub source: RestMesh,
    /// The mesh that takes the motion.
    pub target: RestMesh,
    /// The pipeline's files of markers, as seen from the current folder.
    pub markers: Option<MarkerFiles>,
    /// The stage that proposes markers, if the pipeline has one.
    pub landmarks: Option<Box<dyn Landmarks>>,
    /// The stage that pairs triangles, if the pipeline names one.
    pub correspondence: Option<Box<dyn Correspondence>>,
}

/// The part of a pipeline that a person looks at: both meshes at rest, and the poses as far as there are any.
#[derive(Debug)]
pub struct PosedMeshes {
    /// The mesh that gives its motion.
    pub source: RestMesh,
    /// The mesh that takes the motion.
    pub target: RestMesh,
    /// The poses of the source; perhaps none.
    pub poses: Vec<PoseInput>,
    /// What the poses are to each other.
    pub poses_are: PosesAre,
    /// The frames a second at which a clip is taken, where the pipeline says it.
    pub fps: Option<f64>,
    /// The units and axes of source and target, as far as they are known.
    pub units: [MeshUnits; 2],
    /// The formats, with the pipeline's settings.
    pub formats: Formats,
    /// The pipeline's files of markers, as seen from the current folder.
    pub markers: Option<MarkerFiles>,
    /// The stage that proposes markers, if the pipeline has one.
    pub landmarks: Option<Box<dyn Landmarks>>,
    /// Sentences about what looks wrong or was left out.
    pub warnings: Vec<String>,
}

/// A proximity graph with the report of its computation.
#[derive(Clone, Debug)]
pub struct ProximityInput {
    /// The graph.
    pub graph: ProximityGraph,
    /// The report of the stage.
    pub report: StageReport,
}

/// A file that a run reads.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InputFile {
    /// What the file is, e.g. `source rest`.
    pub role: &'static str,
    /// The file.
    pub path: PathBuf,
}

impl InputFile {
    /// Whether it is the file of a pose.
    pub fn is_pose(&self) -> bool {
        self.role == "pose"
    }
}
