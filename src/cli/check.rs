use std::{collections::HashSet, path::PathBuf};

use serde_json::json;

use super::{Ended, run::Overrides, terminal};
use crate::text::{count, pairs};
use crate::{
    diagnostic::Diagnostic,
    pipeline::{self, Prepared, check::PoseFrom},
    status::Status,
};

/// Finds the mistakes in a pipeline and in all runs that it declares, all at once, without computing anything.
///
/// Reads the rest meshes and markers; poses are read with `--poses`.
#[derive(Debug, clap::Args)]
pub struct Check {
    /// The pipeline's YAML file
    pipeline: PathBuf,
    #[command(flatten)]
    overrides: Overrides,
    /// Read every pose too
    #[arg(long)]
    poses: bool,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

impl Check {
    /// Runs the command.
    pub fn run(&self) -> Ended {
        let checked = pipeline::prepare_all(&self.pipeline, &self.overrides.options()).and_then(|all| {
            let diagnostics = if self.poses { wrong_poses(&all) } else { vec![] };
            if diagnostics.is_empty() { Ok(all) } else { Err(crate::diagnostic::Diagnostics { diagnostics }) }
        });
        match checked {
            Ok(all) if self.json => {
                let runs: Vec<_> = all.iter().map(|one| &one.variant.name).filter(|name| !name.is_empty()).collect();
                let warnings = warnings(&all);
                terminal::print_json(&json!({ "ok": true, "mistakes": [], "warnings": warnings, "runs": runs }));
            }
            Ok(all) => {
                warnings(&all).iter().for_each(|warning| terminal::warn(warning));
                match &all[..] {
                    [one] => terminal::print(&format!("ok: {}\n", overview(one))),
                    all => {
                        let rows: Vec<_> = all.iter().map(|one| (one.variant.name.clone(), overview(one))).collect();
                        terminal::print(&format!("ok: {}\n{}", count(all.len(), "run", "runs"), pairs(&rows)));
                    }
                }
            }
            Err(failure) if self.json => {
                let diagnostics: Vec<_> = failure.diagnostics.iter().map(Diagnostic::to_json).collect();
                terminal::print_json(&json!({ "ok": false, "mistakes": diagnostics }));
                return Ok(failure.kind().into());
            }
            Err(failure) => return Err(failure),
        }
        Ok(Status::Done)
    }
}

/// The warnings of all runs, each once.
fn warnings(all: &[Prepared]) -> Vec<&String> {
    let mut seen = HashSet::new();
    all.iter().flat_map(|one| &one.warnings).filter(|warning| seen.insert(*warning)).collect()
}

fn overview(prepared: &Prepared) -> String {
    let mesh = |side: &pipeline::check::Side| count(side.sequence.rest.positions.len(), "vertex", "vertices");
    let files = prepared.outputs.meshes.iter().map(|output| output.files().len()).sum::<usize>();
    let stage = |name: Option<&'static str>| name.unwrap_or("none");
    format!(
        "source of {}, {}; target of {}; {}; {} then {}; {} to write",
        mesh(&prepared.source),
        count(prepared.poses.len(), "pose", "poses"),
        mesh(&prepared.target),
        count(prepared.markers.len(), "marker", "markers"),
        stage(prepared.pipeline.correspondence.as_ref().map(|stage| stage.typetag_name())),
        stage(prepared.pipeline.transfer.as_ref().map(|stage| stage.typetag_name())),
        count(files, "file", "files"),
    )
}

/// What is wrong with the files of poses, each of which is read once.
fn wrong_poses(all: &[Prepared]) -> Vec<Diagnostic> {
    let mut seen = HashSet::new();
    let read = |(prepared, pose): (&Prepared, &pipeline::check::PoseInput)| {
        let PoseFrom::File(file) = &pose.from else { return None };
        // Files of one name may be poses of another source.
        if !seen.insert((file.clone(), prepared.source.path.clone())) {
            return None;
        }
        let rest = &prepared.source.sequence.rest;
        let format = prepared.formats.reader(file).ok()?;
        let checked = format.read_pose(file, rest).and_then(|positions| crate::core::mesh::check_finite(&positions));
        checked.err().map(|error| pipeline::check::in_file(file, error))
    };
    all.iter().flat_map(|one| one.poses.iter().map(move |pose| (one, pose))).filter_map(read).collect()
}
