//! The results of a run as meshes, and the known results of its poses.

use mimesh_core::stage::Selection;
use std::{
    collections::HashMap,
    path::{Path, PathBuf},
};

use mimesh_core::{
    mesh::{Mesh, Pose, Surface},
    stage::Generator,
};
use mimesh_pipeline::{
    Formats, OneOrMany, Report, check::in_file, input::evenly_spaced, metrics::point_error, placeholder::with_pose,
    report::PoseReport,
};
use nalgebra::Point3;

use crate::cli::compare::written_files::WrittenFiles;

/// The result of one pose.
pub struct PosedResult {
    /// The name of the pose.
    pub name: String,
    /// The mesh in the pose.
    pub mesh: Mesh,
}

/// Reads the results of a run from the first of its outputs that can be read: at most `max_poses`, spread over all.
///
/// # Errors
///
/// A sentence if no file can be read.
pub fn read_results(
    report: &Report,
    written: &WrittenFiles,
    formats: &Formats,
    max_poses: usize,
) -> Result<Vec<PosedResult>, String> {
    let patterns: OneOrMany = serde_json::from_value(report.settings["output"].clone()).unwrap_or_default();
    for pattern in &patterns.items {
        if pattern.contains("{pose}") {
            let results = read_pose_files(report, written, formats, pattern, max_poses);
            if !results.is_empty() {
                return Ok(results);
            }
        } else if let Some(path) = written.find(&PathBuf::from(with_pose(pattern, "")))
            && formats.reader(path).is_ok()
        {
            let sequence =
                formats.read(path, &Selection::default()).map_err(|error| in_file(path, error).to_string())?;
            let posed = |pose: &Pose| PosedResult {
                name: pose.name.clone(),
                mesh: Mesh { positions: pose.positions.get().into_owned(), ..sequence.rest.clone() },
            };
            let shown = evenly_spaced(sequence.poses.len(), max_poses);
            return Ok(shown.into_iter().map(|i| posed(&sequence.poses[i])).collect());
        }
    }
    Err("its results are not where they were written".into())
}

/// Reads the files of an output with a file for each pose; files that cannot be read are left out.
fn read_pose_files(
    report: &Report,
    written: &WrittenFiles,
    formats: &Formats,
    pattern: &str,
    max_poses: usize,
) -> Vec<PosedResult> {
    let read = |pose: &PoseReport| {
        let path = written.find(&PathBuf::from(with_pose(pattern, &pose.name)))?;
        let mesh = read_rest(formats, path)?;
        Some(PosedResult { name: pose.name.clone(), mesh })
    };
    let shown = evenly_spaced(report.poses.len(), max_poses);
    shown.into_iter().filter_map(|i| read(&report.poses[i])).collect()
}

fn read_rest(formats: &Formats, path: &Path) -> Option<Mesh> {
    Some(formats.read(path, &Selection::default()).ok()?.rest)
}

/// The known results of a run.
pub struct GroundTruth {
    /// The target at rest.
    rest: Mesh,
    /// The positions of each pose, by the name of the pose.
    poses: HashMap<String, Vec<Point3<f64>>>,
}

impl GroundTruth {
    /// Reads the known results of a run; `None` if it has none, or if they cannot be read.
    pub fn read(report: &Report, formats: &Formats) -> Option<Self> {
        if let Some(generator) = report.settings["target"].get("generator") {
            let generator: Box<dyn Generator> = serde_json::from_value(generator.clone()).ok()?;
            let sequence = generator.make().ok()?;
            let poses = sequence.poses.into_iter().map(|pose| (pose.name, pose.positions.get().into_owned())).collect();
            return Some(Self { rest: sequence.rest, poses });
        }
        let rest = read_rest(formats, inputs_of_role(report, "target rest").next()?)?;
        let files: Vec<&Path> = inputs_of_role(report, "truth").collect();
        if files.len() != report.poses.len() {
            return None;
        }
        let read = |(pose, file): (&PoseReport, &&Path)| {
            Some((pose.name.clone(), formats.read_pose(file, &Selection::default(), &rest).ok()?))
        };
        let poses = report.poses.iter().zip(&files).filter_map(read).collect();
        Some(Self { rest, poses })
    }

    /// The error of each vertex of `result`; `None` if the truth has other vertices or lacks the pose.
    pub fn errors(&self, result: &PosedResult) -> Option<Vec<f64>> {
        let truth = self.poses.get(&result.name)?;
        let surface = Surface::new(&self.rest).ok()?;
        point_error(&self.rest, &surface, &result.mesh.positions, truth).ok().map(|measured| measured.field)
    }
}

fn inputs_of_role<'a>(report: &'a Report, role: &'static str) -> impl Iterator<Item = &'a Path> {
    report.inputs.iter().filter(move |input| input.role == role).map(|input| &*input.path)
}
