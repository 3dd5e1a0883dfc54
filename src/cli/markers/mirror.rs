//! `mimesh markers mirror`: markers completed across planes of symmetry.

use mimesh_markers::{Outcome, Plane, mirror};
use serde_json::json;

use crate::cli::{
    CommandResult,
    markers::{Common, percent, written_lines},
    status::Status,
    terminal,
};

/// Adds missing mirror partners of markers, across the plane of symmetry of each mesh.
///
/// The partner of a marker is the point closest to its mirrored position, on both meshes. Its name has left and right
/// exchanged. Markers on the plane are left alone. Mirroring again adds nothing.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  mimesh markers mirror half.yaml whole.yaml --pipeline horse-to-camel.yaml
  mimesh markers mirror half.cons whole.cons --source a.obj --target b.obj --axis z --target-offset 0.5")]
pub struct Mirror {
    #[command(flatten)]
    common: Common,
    /// The axis perpendicular to the plane of symmetry
    #[arg(long, value_name = "AXIS", default_value = "x")]
    axis: Axis,
    /// The axis for the target [default: that of --axis]
    #[arg(long, value_name = "AXIS")]
    target_axis: Option<Axis>,
    /// The position of the source's plane on the axis, in the source's unit [default: the middle of its bounding box]
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    source_offset: Option<f64>,
    /// The position of the target's plane on the axis, in the target's unit [default: the middle of its bounding box]
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    target_offset: Option<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Axis {
    X,
    Y,
    Z,
}

impl Mirror {
    /// Runs the command.
    pub fn run(&self) -> CommandResult {
        let loaded = self.common.load()?;
        let mut attached = loaded.markers(false)?;
        let meshes = loaded.meshes();
        attached.markers.resolve(meshes)?;
        let axes = [self.axis, self.target_axis.unwrap_or(self.axis)];
        let offsets = [self.source_offset, self.target_offset];
        let planes = [0, 1].map(|k| {
            let middle = Plane::middle(meshes[k], axes[k] as usize);
            Plane { offset: offsets[k].unwrap_or(middle.offset), ..middle }
        });
        let mirrored = mirror(&attached.markers, meshes, planes)?;
        let names: Vec<String> = (0..mirrored.markers.pairs.len()).map(|i| mirrored.markers.name(i)).collect();
        attached.markers = mirrored.markers;
        attached.markers.record_positions(meshes, loaded.mesh_files());
        let written = self.common.write(&loaded, &attached.markers)?;
        let count = |is_counted: fn(&Outcome) -> bool| mirrored.outcomes.iter().filter(|o| is_counted(o)).count();
        let added = count(|outcome| matches!(outcome, Outcome::Added(..)));
        let on_plane = count(|outcome| matches!(outcome, Outcome::OnPlane));
        let paired = count(|outcome| matches!(outcome, Outcome::Partner(_)));
        let left = count(|outcome| matches!(outcome, Outcome::Left(_)));
        if self.common.json {
            let pair = |(i, outcome): (usize, &Outcome)| match outcome {
                Outcome::OnPlane => json!({ "marker": names[i], "on_plane": true }),
                Outcome::Partner(j) => json!({ "marker": names[i], "partner": names[*j] }),
                Outcome::Added(j, d) => json!({ "marker": names[i], "added": names[*j], "distances": d }),
                Outcome::Left(why) => json!({ "marker": names[i], "left": why }),
            };
            terminal::print_json(&json!({
                "markers": names.len(), "added": added, "on_plane": on_plane, "with_partner": paired, "left": left,
                "pairs": mirrored.outcomes.iter().enumerate().map(pair).collect::<Vec<_>>(), "written": terminal::all_shown(&written),
            }));
        } else {
            let mut text = format!(
                "{added} added, {paired} have a partner, {on_plane} lie on the plane, {left} left alone; \
                 {} markers now\n",
                names.len()
            );
            for (i, outcome) in mirrored.outcomes.iter().enumerate() {
                match outcome {
                    Outcome::Added(j, [s, t]) => text.push_str(&format!(
                        "  {} -> {}: {} of the diagonal off the source, {} off the target\n",
                        names[i],
                        names[*j],
                        percent(*s),
                        percent(*t)
                    )),
                    Outcome::Left(why) => text.push_str(&format!("  {}: left alone, {why}\n", names[i])),
                    Outcome::OnPlane | Outcome::Partner(_) => {}
                }
            }
            terminal::print(&(text + &written_lines(&written)));
        }
        Ok(Status::Done)
    }
}
