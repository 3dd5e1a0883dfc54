//! `mimesh check`: the errors in a pipeline, without a run.

use std::{collections::HashSet, path::PathBuf};

use mimesh_document::diagnostic::{Diagnostic, Diagnostics};
use serde_json::json;
use {
    mimesh_pipeline as pipeline,
    mimesh_pipeline::{
        Prepared,
        choices::rows,
        input::{GroundTruth, PoseFrom, PoseInput, RestMesh},
        text::{count, pairs},
    },
};

use crate::cli::{
    CommandResult, cache::CacheOptions, flags::with_flags, overrides::Overrides, status::Status, terminal,
};

/// Finds all mistakes in a pipeline and in the runs that it declares, without running them.
///
/// The command reads the rest meshes and the markers, and the poses of a source whose boundaries coincide. Of other poses and of known
/// results it counts the vertices, as far as a look at the file tells them. With `--poses` it reads all of them. It computes nothing but
/// the seams that open and the proximity graph, which the checks of stages look at.
#[derive(Debug, clap::Args)]
pub struct Check {
    /// The pipeline's YAML file
    pipeline: PathBuf,
    #[command(flatten)]
    overrides: Overrides,
    /// Read every pose and every known result too
    #[arg(long)]
    poses: bool,
    #[command(flatten)]
    cache: CacheOptions,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

impl Check {
    /// Runs the command.
    pub fn run(&self) -> CommandResult {
        let cache = self.cache.open()?;
        let checked =
            pipeline::prepare_all(&self.pipeline, &self.overrides.options(), cache.as_ref()).and_then(|all| {
                let list = match self.poses {
                    true => unreadable_poses(&all),
                    false => all.iter().flat_map(pipeline::check::other_vertex_counts).collect(),
                };
                let mut wrong = Diagnostics { list };
                wrong.deduplicate();
                wrong.into_result().map(|()| all)
            });
        match checked {
            Ok(all) if self.json => {
                let runs: Vec<_> = all.iter().map(|run| &run.variant.name).filter(|name| !name.is_empty()).collect();
                let warnings = warnings(&all);
                let choices: Vec<_> = all.iter().map(|run| &run.choices).collect();
                let choices = match &choices[..] {
                    [one] => json!(one),
                    several => json!(several),
                };
                terminal::print_json(&json!({
                    "ok": true, "mistakes": [], "warnings": warnings, "runs": runs, "choices": choices,
                    "not_read": self.not_read(&all),
                }));
            }
            Ok(all) => {
                warnings(&all).iter().for_each(|warning| terminal::warn(warning));
                match &all[..] {
                    [run] => terminal::print(&format!("ok: {}\n{}", overview(run), chosen(run))),
                    all => {
                        let rows: Vec<_> = all.iter().map(|run| (run.variant.name.clone(), overview(run))).collect();
                        let chosen = all.iter().map(|run| (&run.variant.name, chosen(run)));
                        let chosen = chosen.filter(|(_, text)| !text.is_empty());
                        let chosen: String = chosen.map(|(name, text)| format!("{name}: {text}")).collect();
                        let runs = count(all.len(), "run", "runs");
                        terminal::print(&format!("ok: {runs}\n{}{chosen}", pairs(&rows)));
                    }
                }
                if let Some(text) = not_read_text(self.not_read(&all)) {
                    terminal::print(&text);
                }
            }
            Err(failure) if self.json => {
                let diagnostics: Vec<_> = failure.list.iter().map(|d| with_flags(d).to_json()).collect();
                terminal::print_json(&json!({ "ok": false, "mistakes": diagnostics }));
                return Ok(failure.kind().into());
            }
            Err(failure) => return Err(failure),
        }
        Ok(Status::Done)
    }
}

impl Check {
    /// How many files of poses and of known results were only looked at.
    fn not_read(&self, all: &[Prepared]) -> usize {
        let files: HashSet<&PathBuf> = all.iter().flat_map(|run| pose_files(run).chain(truth_files(run))).collect();
        if self.poses { 0 } else { files.len() }
    }
}

/// What the check has left to the run, in a line.
fn not_read_text(files: usize) -> Option<String> {
    let files = (files > 0).then(|| count(files, "file of a pose", "files of poses"))?;
    Some(format!("not read: the shapes in {files}; `--poses` reads them\n"))
}

fn pose_files(run: &Prepared) -> impl Iterator<Item = &PathBuf> {
    run.poses.iter().filter_map(|pose| match &pose.from {
        PoseFrom::File(file) => Some(file),
        PoseFrom::Held(_) => None,
    })
}

fn truth_files(run: &Prepared) -> impl Iterator<Item = &PathBuf> {
    let files = match &run.truth {
        GroundTruth::Files { files, .. } => &files[..],
        _ => &[],
    };
    files.iter()
}

/// The warnings of all runs, without repetitions.
pub(super) fn warnings(all: &[Prepared]) -> Vec<&String> {
    let mut seen = HashSet::new();
    all.iter()
        .flat_map(|run| run.warnings.iter().chain(&run.unfinished))
        .filter(|warning| seen.insert(*warning))
        .collect()
}

/// What was chosen for a run, after a line of its own; nothing where nothing was.
fn chosen(prepared: &Prepared) -> String {
    match prepared.choices.is_empty() {
        true => String::new(),
        false => format!("chosen by the meshes\n{}", rows(&prepared.choices)),
    }
}

/// The sizes and the stages of a run, in a line.
fn overview(prepared: &Prepared) -> String {
    let files = prepared.outputs.meshes.iter().map(|output| output.files().len()).sum::<usize>();
    let correspondence = prepared.pipeline.correspondence.as_ref().map(|stage| stage.typetag_name());
    let transfer = prepared.pipeline.transfer.as_ref().map(|stage| stage.typetag_name());
    format!(
        "source of {}, {}; target of {}; {}; {} then {}; {} to write",
        vertices(&prepared.source),
        count(prepared.poses.len(), "pose", "poses"),
        vertices(&prepared.target),
        markers(prepared),
        correspondence.unwrap_or("none"),
        transfer.unwrap_or("none"),
        count(files, "file", "files"),
    )
}

/// How many markers there are, or the stage that is going to propose them.
fn markers(prepared: &Prepared) -> String {
    match prepared.landmarks() {
        Some(stage) => format!("markers by {}", stage.typetag_name()),
        None => count(prepared.markers().len(), "marker", "markers"),
    }
}

fn vertices(mesh: &RestMesh) -> String {
    count(mesh.sequence.rest.positions.len(), "vertex", "vertices")
}

/// Reads the file of every pose once, and gives a diagnostic for each that is unusable.
fn unreadable_poses(all: &[Prepared]) -> Vec<Diagnostic> {
    let mut seen = HashSet::new();
    let read = |(prepared, pose): (&Prepared, &PoseInput)| {
        let PoseFrom::File(file) = &pose.from else { return None };
        // The same file may be a pose of several sources.
        if !seen.insert((file.clone(), prepared.source.path.clone())) {
            return None;
        }
        let rest = &prepared.source.sequence.rest;
        let read = prepared.formats.read_pose(file, &prepared.source.selection, rest);
        let checked = read.and_then(|positions| mimesh_core::mesh::check_finite(&positions));
        checked.err().map(|error| pipeline::check::in_file(file, error))
    };
    let poses = all.iter().flat_map(|run| run.poses.iter().map(move |pose| (run, pose))).filter_map(read);
    let mut wrong: Vec<_> = poses.collect();
    wrong.extend(all.iter().flat_map(unreadable_truth));
    wrong
}

/// Reads the file of every known result once, and gives a diagnostic for each that is unusable.
fn unreadable_truth(prepared: &Prepared) -> Vec<Diagnostic> {
    let rest = &prepared.target.sequence.rest;
    let read = |(i, pose): (usize, &PoseInput)| {
        let positions = prepared.truth.positions(i, &pose.name, rest, &prepared.formats);
        let checked = positions.and_then(|known| known.map_or(Ok(()), |known| mimesh_core::mesh::check_finite(&known)));
        let file = truth_files(prepared).nth(i)?;
        checked.err().map(|error| pipeline::check::in_file(file, error))
    };
    prepared.poses.iter().enumerate().filter_map(read).collect()
}
