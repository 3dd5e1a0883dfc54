//! The parts of a project.

use std::sync::{Arc, PoisonError, RwLock, atomic::AtomicU64};

use mimesh_core::{mesh::PosesAre, spatial::MeshUnits, stage::Landmarks};
use mimesh_document::path;
use mimesh_pipeline::{Formats, Prepared, input::PoseInput};
use serde_json::Value;

use super::recent::RecentPoses;
use crate::{markers::MarkerStore, meshes::Meshes, pipeline::PipelineStore, scalars::ScalarView};

/// What is open.
#[derive(Debug)]
pub struct Project {
    /// Differs from that of every other project, also of earlier servers.
    pub number: u64,
    /// Its number when its pipeline was opened: another clip gives the project another number.
    pub opened: u64,
    /// The name, for the title.
    pub name: String,
    /// The meshes at rest.
    pub meshes: Arc<Meshes>,
    /// The poses of the source; perhaps none.
    pub poses: Vec<PoseInput>,
    /// What the poses are to each other.
    pub poses_are: PosesAre,
    /// The clips of the source's file, with their seconds.
    pub clips: Vec<(String, f64)>,
    /// The frames a second of a clip.
    pub fps: Option<f64>,
    /// The formats, with the pipeline's settings.
    pub formats: Formats,
    /// The units and axes of both meshes, as far as they are known.
    pub units: [MeshUnits; 2],
    /// The stage that proposes markers, if the pipeline names one.
    pub landmarks: Option<Box<dyn Landmarks>>,
    /// The document of markers.
    pub markers: Arc<MarkerStore>,
    /// The pipeline.
    pub pipeline: Arc<PipelineStore>,
    /// Counts changes of masks by pages.
    pub masks_saved: AtomicU64,
    /// The part of the pipeline's value by which the meshes were read.
    pub(super) opened_by: Value,
    /// Poses that were read lately.
    pub(super) recent: RecentPoses,
    pub(super) ready: RwLock<Option<Arc<Ready>>>,
}

/// The pipeline without mistakes, at one of its revisions.
#[derive(Debug)]
pub struct Ready {
    /// The revision of the pipeline.
    pub revision: u64,
    /// The pipeline, with the markers of that time.
    pub prepared: Prepared,
    /// The colour maps that its metrics give.
    pub scalars: Vec<ScalarView>,
}

impl Ready {
    /// The place of a pose of the source among those of the pipeline, which may leave some out and add mirrored ones.
    pub fn place_of(&self, pose: &PoseInput) -> Option<usize> {
        let Prepared { poses, shape_edits, .. } = &self.prepared;
        poses.iter().zip(shape_edits).position(|(other, edit)| other.from == pose.from && edit.mirrored.is_none())
    }
}

impl Project {
    /// The pipeline at the last revision without mistakes.
    pub fn ready(&self) -> Option<Arc<Ready>> {
        self.ready.read().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Notes what a check of the pipeline gave.
    pub fn set_ready(&self, ready: Option<Arc<Ready>>) {
        *self.ready.write().unwrap_or_else(PoisonError::into_inner) = ready;
    }

    /// Which pose is at a place among those of `prepared`; `None` for a shape that is made of another.
    pub fn index_of(&self, prepared: &Prepared, place: usize) -> Option<usize> {
        let (pose, edit) = (prepared.poses.get(place)?, prepared.shape_edits.get(place)?);
        self.poses.iter().position(|other| other.from == pose.from).filter(|_| edit.mirrored.is_none())
    }

    /// Whether the pipeline names other meshes or poses now than when the project was opened.
    pub fn is_outdated(&self) -> bool {
        let value = self.pipeline.value();
        value.is_object() && meshes_of(&value) != self.opened_by
    }

    /// Makes the pipeline name the file of markers, if it does not yet.
    pub fn name_markers(&self) {
        let folder = self.pipeline.file().parent().unwrap_or(std::path::Path::new(""));
        let value = self.pipeline.value();
        let named = value.get("markers").and_then(Value::as_str).map(|file| folder.join(file));
        if named.is_some_and(|named| same_file(&named, self.markers.file())) {
            return self.pipeline.save_new();
        }
        let file = self.markers.file();
        let name = file.strip_prefix(folder).unwrap_or(file).to_string_lossy().into_owned();
        // A text that is no YAML is left as it is; the next change of markers tries again.
        let _ = self.pipeline.set_silently(&path(["markers"]), &name.into());
    }
}

fn same_file(a: &std::path::Path, b: &std::path::Path) -> bool {
    mimesh_document::paths::identity(a) == mimesh_document::paths::identity(b)
}

/// The parts of a pipeline by which meshes and poses are read.
pub(super) fn meshes_of(value: &Value) -> Value {
    let keys = ["include", "variables", "targets", "source", "target", "formats"];
    keys.into_iter().filter_map(|key| Some((key.to_owned(), value.get(key)?.clone()))).collect()
}
