//! Meshes with their poses.

use std::{
    path::{Path, PathBuf},
    sync::{Arc, OnceLock},
};

use mimesh_core::{
    Error,
    mesh::{Document, Mesh, MeshSequence, Polygons, Pose, Positions, Surface, check_finite},
    stage::{ClipChoice, ClipTimes, PoseChoice, Selection},
};
use mimesh_pipeline::{Formats, Reach, check::in_file};
use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use serde_json::json;

use crate::{
    array::{View, indices, points},
    error::{Outcome, exception, exception_of},
    save::{SavedPose, save},
    work,
};

/// A mesh at rest with its poses; it does not change.
#[pyclass(frozen)]
pub struct MeshData {
    /// The mesh.
    pub sequence: Arc<MeshSequence>,
    content: OnceLock<String>,
    surface: OnceLock<Arc<Surface>>,
}

impl From<MeshSequence> for MeshData {
    fn from(sequence: MeshSequence) -> Self {
        Arc::new(sequence).into()
    }
}

impl From<Arc<MeshSequence>> for MeshData {
    fn from(sequence: Arc<MeshSequence>) -> Self {
        Self { sequence, content: OnceLock::new(), surface: OnceLock::new() }
    }
}

impl MeshData {
    /// The surface that stages see.
    pub fn surface(&self) -> mimesh_core::Result<Arc<Surface>> {
        if let Some(surface) = self.surface.get() {
            return Ok(surface.clone());
        }
        let mut surface = Surface::new(&self.sequence.rest)?;
        let inward = mimesh_core::mesh::inward_components(&surface);
        surface.turn_components(&inward);
        Ok(self.surface.get_or_init(|| Arc::new(surface)).clone())
    }

    /// A name that stands for the content of the mesh and its poses.
    pub fn content(&self) -> mimesh_core::Result<String> {
        if let Some(content) = self.content.get() {
            return Ok(content.clone());
        }
        let content = content_of(&self.sequence)?;
        Ok(self.content.get_or_init(|| content).clone())
    }
}

#[pymethods]
impl MeshData {
    /// A mesh of positions (n × 3), the corners of all its polygons and their numbers.
    #[new]
    fn new(
        py: Python<'_>,
        vertices: PyReadonlyArray2<'_, f64>,
        corners: PyReadonlyArray1<'_, u32>,
        sizes: PyReadonlyArray1<'_, u32>,
    ) -> PyResult<Self> {
        let made = || {
            let (mut rest, corners) = (indices(&corners)?, Polygons::default());
            let mut polygons = corners;
            for &size in indices(&sizes)? {
                let (polygon, others) = rest.split_at_checked(size as usize).ok_or_else(|| {
                    Error::data("polygons with more corners than there are", "give each polygon its own corners")
                })?;
                polygons.push(polygon);
                rest = others;
            }
            let mesh = Mesh { positions: points(&vertices)?, polygons, ..Mesh::default() };
            mesh.validate()?;
            Ok(MeshSequence { rest: mesh, ..MeshSequence::default() }.into())
        };
        made().map_err(|error| exception_of(py, error))
    }

    /// The same mesh with these poses and no others.
    fn with_poses(
        &self,
        py: Python<'_>,
        names: Vec<String>,
        positions: Vec<PyReadonlyArray2<'_, f64>>,
    ) -> PyResult<Self> {
        let rest = &self.sequence.rest;
        let mut poses = Vec::new();
        for (name, positions) in names.into_iter().zip(&positions) {
            let read = points(positions).and_then(|positions| {
                let count = rest.positions.len();
                if positions.len() != count {
                    let message = format!("pose {name}: {} vertices, the mesh has {count}", positions.len());
                    return Err(Error::data(message, "a pose has the vertices of the mesh, in the same order"));
                }
                check_finite(&positions)?;
                Ok(positions)
            });
            poses.push(Pose::new(name, read.map_err(|error| exception_of(py, error))?));
        }
        Ok(MeshSequence { poses, ..MeshSequence::clone(&self.sequence) }.into())
    }

    /// The same polygons with vertices elsewhere, without poses and without what its file says beside.
    fn with_vertices(&self, py: Python<'_>, vertices: PyReadonlyArray2<'_, f64>) -> PyResult<Self> {
        let positions = points(&vertices).and_then(|positions| {
            Error::check_shape("vertices", self.sequence.rest.positions.len(), positions.len())?;
            check_finite(&positions)?;
            Ok(positions)
        });
        let positions = positions.map_err(|error| exception_of(py, error))?;
        let mut sequence = MeshSequence::clone(&self.sequence);
        sequence.rest.positions = positions;
        // What its file says of the old shape is wrong now.
        (sequence.rest.document, sequence.rest.normals) = (Document::default(), None);
        sequence.poses.clear();
        Ok(sequence.into())
    }

    /// The positions at rest, n × 3.
    fn vertices(&self) -> View {
        View::points(self.sequence.clone(), |sequence| &sequence.rest.positions)
    }

    /// The corners of all polygons, one polygon after the other.
    fn corners(&self) -> View {
        View::indices(self.sequence.clone(), |sequence| sequence.rest.polygons.corners())
    }

    /// The number of corners of each polygon.
    fn sizes(&self) -> View {
        let sizes: Vec<u32> = self.sequence.rest.polygons.iter().map(|polygon| polygon.len() as u32).collect();
        View::indices(Arc::new(sizes), Vec::as_slice)
    }

    /// The polygons cut into triangles, fans from their first corners.
    fn triangles(&self) -> View {
        View::triangles(Arc::new(self.sequence.rest.polygons.fans().0), Vec::as_slice)
    }

    /// The names of the poses.
    fn pose_names(&self) -> Vec<String> {
        self.sequence.poses.iter().map(|pose| pose.name.clone()).collect()
    }

    /// The positions of a pose, n × 3.
    fn pose(&self, py: Python<'_>, index: usize) -> PyResult<View> {
        let pose = &self.sequence.poses[index];
        match &pose.positions {
            Positions::Held(_) => {
                Ok(View::points(self.sequence.clone(), move |sequence| match &sequence.poses[index].positions {
                    Positions::Held(positions) => positions,
                    Positions::Computed(..) => &[],
                }))
            }
            computed => {
                let positions = py.detach(|| Ok(computed.get()?.into_owned()));
                let positions: Vec<_> = positions.map_err(|error| exception_of(py, error))?;
                Ok(View::points(Arc::new(positions), Vec::as_slice))
            }
        }
    }

    /// What else the file says, as JSON: clips, named points, warnings.
    fn facts(&self) -> String {
        let clips = self.sequence.animations.iter().map(|clip| json!({ "name": clip.name, "seconds": clip.seconds }));
        let landmarks = self.sequence.landmarks.iter().map(|landmark| json!([landmark.name, landmark.point]));
        json!({
            "clips": clips.collect::<Vec<_>>(),
            "landmarks": landmarks.collect::<Vec<_>>(),
            "warnings": self.sequence.warnings,
        })
        .to_string()
    }

    /// A name that stands for the content of the mesh and its poses.
    fn content_hash(&self, py: Python<'_>) -> PyResult<String> {
        py.detach(|| self.content()).map_err(|error| exception_of(py, error))
    }

    /// Writes the mesh, and its poses where the format takes them.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<Vec<PathBuf>> {
        let sequence = self.sequence.clone();
        let written = work::run(py, None, move |_| {
            let poses = sequence.poses.iter().map(SavedPose::of).collect::<Vec<_>>();
            save(&path, &sequence.rest, &poses)
        })?;
        written.map_err(|failure| exception(py, &failure))
    }
}

/// Reads a file; its poses are its morph targets, else the frames of `clip` or of its first clip that lasts.
#[pyfunction]
pub fn load(
    py: Python<'_>,
    path: PathBuf,
    meshes: Vec<String>,
    clip: Option<String>,
    frames_per_second: f64,
) -> PyResult<MeshData> {
    let read = work::run(py, None, move |_| read(&path, meshes, clip, frames_per_second))?;
    read.map(MeshData::from).map_err(|failure| exception(py, &failure))
}

fn read(path: &Path, meshes: Vec<String>, clip: Option<String>, fps: f64) -> Outcome<MeshSequence> {
    let formats = Formats::new(vec![], Reach::new(path.parent()));
    formats.reader_of(path)?;
    let clips = |name: &str| {
        let times = ClipTimes::PerSecond(fps);
        PoseChoice::Clips(ClipChoice { clips: vec![name.to_owned()], times, ..ClipChoice::default() })
    };
    let poses = clip.as_deref().map_or(PoseChoice::Shapes, clips);
    let selection = Selection { meshes, poses, keep_document: true, ..Selection::default() };
    let read = |selection: &Selection| formats.read(path, selection).map_err(|error| in_file(path, error));
    let sequence = read(&selection)?;
    if clip.is_some() || !sequence.poses.is_empty() {
        return Ok(sequence);
    }
    let lasting = sequence.animations.iter().find(|clip| clip.seconds > 0.0);
    match lasting.or(sequence.animations.first()) {
        Some(first) => Ok(read(&Selection { poses: clips(&first.name), ..selection })?),
        None => Ok(sequence),
    }
}

/// The hash of everything in a mesh that pipelines look at.
fn content_of(sequence: &MeshSequence) -> mimesh_core::Result<String> {
    let mut hasher = blake3::Hasher::new();
    let mut text = |text: &str| {
        hasher.update(&(text.len() as u64).to_le_bytes());
        hasher.update(text.as_bytes());
    };
    let rest = &sequence.rest;
    text(&format!("{:?}", rest.parts));
    text(&format!("{:?}", sequence.landmarks));
    for pose in &sequence.poses {
        text(&format!("{:?} {:?}", pose.name, pose.time));
    }
    let mut bytes = Vec::with_capacity(rest.positions.len() * 24);
    let mut points = |points: &[nalgebra::Point3<f64>]| {
        bytes.clear();
        bytes.extend(points.iter().flat_map(|p| [p.x, p.y, p.z]).flat_map(f64::to_le_bytes));
        hasher.update(&bytes);
    };
    points(&rest.positions);
    for pose in &sequence.poses {
        points(&pose.positions.get()?);
    }
    for polygon in rest.polygons.iter() {
        hasher.update(&(polygon.len() as u32).to_le_bytes());
        polygon.iter().for_each(|corner| _ = hasher.update(&corner.to_le_bytes()));
    }
    Ok(hasher.finalize().to_hex().to_string())
}
