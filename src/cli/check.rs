use std::path::PathBuf;

use serde_json::json;

use super::{Ended, run::Overrides, terminal, text::count};
use crate::{
    mistake::Mistake,
    pipeline::{self, Prepared, check::PoseFrom},
    status::Status,
};

/// Finds the mistakes in a pipeline, all at once, without computing anything.
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
        let checked = pipeline::prepare(&self.pipeline, &self.overrides.options()).and_then(|prepared| {
            let mistakes = if self.poses { wrong_poses(&prepared) } else { vec![] };
            if mistakes.is_empty() { Ok(prepared) } else { Err(crate::mistake::Failure { mistakes }) }
        });
        match checked {
            Ok(prepared) if self.json => {
                terminal::print_json(&json!({ "ok": true, "mistakes": [], "warnings": prepared.warnings }));
            }
            Ok(prepared) => {
                prepared.warnings.iter().for_each(|warning| terminal::warn(warning));
                terminal::print(&overview(&prepared));
            }
            Err(failure) if self.json => {
                let mistakes: Vec<_> = failure.mistakes.iter().map(Mistake::to_json).collect();
                terminal::print_json(&json!({ "ok": false, "mistakes": mistakes }));
                return Ok(failure.status());
            }
            Err(failure) => return Err(failure),
        }
        Ok(Status::Done)
    }
}

fn overview(prepared: &Prepared) -> String {
    let mesh = |side: &pipeline::check::Side| count(side.sequence.rest.positions.len(), "vertex", "vertices");
    let files = prepared.outputs.meshes.iter().map(|output| output.files().len()).sum::<usize>();
    let stage = |name: Option<&'static str>| name.unwrap_or("none");
    format!(
        "ok: source of {}, {}; target of {}; {}; {} then {}; {} to write\n",
        mesh(&prepared.source),
        count(prepared.poses.len(), "pose", "poses"),
        mesh(&prepared.target),
        count(prepared.markers.len(), "marker", "markers"),
        stage(prepared.pipeline.correspondence.as_ref().map(|stage| stage.typetag_name())),
        stage(prepared.pipeline.transfer.as_ref().map(|stage| stage.typetag_name())),
        count(files, "file", "files"),
    )
}

/// What is wrong with the files of poses.
fn wrong_poses(prepared: &Prepared) -> Vec<Mistake> {
    let rest = &prepared.source.sequence.rest;
    let read = |pose: &pipeline::check::PoseInput| {
        let PoseFrom::File(file) = &pose.from else { return None };
        let format = prepared.formats.reader(file).ok()?;
        let checked = format.read_pose(file, rest).and_then(|positions| crate::core::mesh::check_finite(&positions));
        checked.err().map(|error| pipeline::check::in_file(file, error))
    };
    prepared.poses.iter().filter_map(read).collect()
}
