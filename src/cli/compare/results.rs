//! The results of a run as meshes, and the known results of its poses.

use std::{
    collections::HashMap,
    path::{Path, PathBuf},
};

use mimesh_core::{
    mesh::{Mesh, MeshSequence, Pose, Surface},
    spatial::{MeshUnits, UnitAxes},
    stage::{Generator, PoseChoice, RestShape, Selection},
};
use mimesh_pipeline::{
    Formats, OneOrMany, Report,
    check::in_file,
    input::evenly_spaced,
    metrics::point_error,
    placeholder::{POSE, with_pose},
    report::PoseReport,
    spec::Target,
};
use nalgebra::Point3;
use serde_json::Value;

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
            let sequence = read_sequence(formats, path, &target_selection(report))?;
            let renamed = report.outputs.iter().find(|output| output.path.file_name() == path.file_name());
            let results: Vec<_> = report
                .poses
                .iter()
                .filter_map(|pose| {
                    // Beside the results a file may hold shapes of the target's own.
                    let name = renamed.and_then(|output| output.renamed.get(&pose.name)).unwrap_or(&pose.name);
                    Some((pose, sequence.poses.iter().find(|held| held.name == *name)?))
                })
                .collect();
            let change = back_to_target(report, formats, path);
            let posed = |(pose, held): &(&PoseReport, &Pose)| {
                let positions = held.positions.get().map_err(|error| error.to_string())?;
                let mesh = Mesh { positions: changed(change, &positions), ..sequence.rest.clone() };
                Ok(PosedResult { name: pose.name.clone(), mesh })
            };
            let shown = evenly_spaced(results.len(), max_poses);
            return shown.into_iter().map(|i| posed(&results[i])).collect();
        }
    }
    Err("its results are not where they were written".into())
}

/// The change that takes results in `file` back into the unit and axes of the target.
fn back_to_target(report: &Report, formats: &Formats, file: &Path) -> UnitAxes {
    if formats.writer(file).is_ok_and(|(format, _)| format.with_units(MeshUnits::default()).is_some()) {
        return UnitAxes::IDENTITY;
    }
    let units = |of: &Value, unit: &str, up: &str| MeshUnits {
        unit: serde_json::from_value(of[unit].clone()).ok(),
        up: serde_json::from_value(of[up].clone()).ok(),
    };
    let target = inputs_of_role(report, "target rest").next().and_then(|target| formats.reader(target).ok());
    let read = target.map(|format| format.reads_in()).unwrap_or_default();
    let written = units(&report.settings, "output_unit", "output_up");
    UnitAxes::between(written, units(&report.settings["target"], "unit", "up").or(read))
}

fn changed(change: UnitAxes, positions: &[Point3<f64>]) -> Vec<Point3<f64>> {
    positions.iter().map(|p| change.apply(p)).collect()
}

/// The part of the target's file that a run read, in its shape at rest.
fn target_selection(report: &Report) -> Selection {
    let target: Option<Target> = serde_json::from_value(report.settings["target"].clone()).ok();
    target.and_then(|target| target.rest).map(|rest| rest.selection()).unwrap_or_default()
}

/// Reads the poses of `path`, at rest as `selection` has it if the file holds that shape.
fn read_sequence(formats: &Formats, path: &Path, selection: &Selection) -> Result<MeshSequence, String> {
    let shapes = |selection: &Selection| Selection { poses: PoseChoice::Shapes, ..selection.clone() };
    let stored = Selection { rest: RestShape::Stored, ..selection.clone() };
    let read = formats.read(path, &shapes(selection)).or_else(|_| formats.read(path, &shapes(&stored)));
    read.map_err(|error| in_file(path, error).to_string())
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
        let positions = changed(back_to_target(report, formats, path), &mesh.positions);
        Some(PosedResult { name: pose.name.clone(), mesh: Mesh { positions, ..mesh } })
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
    /// The rest and the poses of `sequence`; `None` if one cannot be read.
    fn held(sequence: MeshSequence) -> Option<Self> {
        let positions = |pose: Pose| Some((pose.name, pose.positions.get().ok()?.into_owned()));
        let poses = sequence.poses.into_iter().map(positions).collect::<Option<_>>()?;
        Some(Self { rest: sequence.rest, poses })
    }

    /// Reads the known results of a run; `None` if it has none, or if they cannot be read.
    pub fn read(report: &Report, formats: &Formats) -> Option<Self> {
        if let Some(generator) = report.settings["target"].get("generator") {
            let generator: Box<dyn Generator> = serde_json::from_value(generator.clone()).ok()?;
            let sequence = generator.make().ok()?;
            return Self::held(sequence);
        }
        let selection = target_selection(report);
        let rest = formats.read(inputs_of_role(report, "target rest").next()?, &selection).ok()?.rest;
        let files: Vec<&Path> = inputs_of_role(report, "truth").collect();
        let has_all = report.settings["truth"].as_str().is_some_and(|truth| !truth.contains(POSE));
        if let [file] = files[..]
            && has_all
        {
            let sequence = read_sequence(formats, file, &selection).ok()?;
            return Some(Self { rest, ..Self::held(sequence)? });
        }
        if files.len() != report.poses.len() {
            return None;
        }
        let stored = Selection { rest: RestShape::Stored, ..selection };
        let read = |(pose, file): (&PoseReport, &&Path)| {
            Some((pose.name.clone(), formats.read_pose(file, &stored, &rest).ok()?))
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
