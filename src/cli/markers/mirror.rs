use serde_json::json;

use super::{Common, percent, told};
use crate::{
    cli::{Ended, terminal},
    markers::mirror::{self, Outcome, Plane},
    status::Status,
};

/// Adds the mirror partners that markers lack, across the plane of symmetry of each mesh.
///
/// A partner is the closest place to the mirrored position, on both sides; left and right change in its name. Pairs on the
/// plane are left alone. Mirroring again adds nothing.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  mimesh markers mirror half.yaml whole.yaml --pipeline horse-to-camel.yaml
  mimesh markers mirror half.cons whole.cons --source a.obj --target b.obj --axis z --target-offset 0.5")]
pub struct Mirror {
    #[command(flatten)]
    common: Common,
    /// The axis across which both meshes are symmetric
    #[arg(long, value_name = "AXIS", default_value = "x")]
    axis: Axis,
    /// The axis of the target, if it is another
    #[arg(long, value_name = "AXIS")]
    target_axis: Option<Axis>,
    /// Where the plane of the source crosses the axis, in its unit [default: the middle of its bounding box]
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    source_offset: Option<f64>,
    /// Where the plane of the target crosses the axis, in its unit [default: the middle of its bounding box]
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
    pub fn run(&self) -> Ended {
        let loaded = self.common.load()?;
        let mut found = loaded.markers(false)?;
        let sides = loaded.sides();
        found.markers.resolve(sides[0], sides[1])?;
        let axes = [self.axis, self.target_axis.unwrap_or(self.axis)];
        let offsets = [self.source_offset, self.target_offset];
        let planes = [0, 1].map(|k| {
            let middle = Plane::middle(sides[k], axes[k] as usize);
            Plane { offset: offsets[k].unwrap_or(middle.offset), ..middle }
        });
        let mirrored = mirror::mirror(&found.markers, sides, planes)?;
        let names: Vec<String> = (0..mirrored.markers.entries.len()).map(|i| mirrored.markers.name(i)).collect();
        found.markers = mirrored.markers;
        found.remember(sides[0], sides[1], loaded.mesh_files())?;
        let written = self.common.write(&loaded, &found.markers)?;
        let of = |wanted: fn(&Outcome) -> bool| mirrored.outcomes.iter().filter(|outcome| wanted(outcome)).count();
        let added = of(|outcome| matches!(outcome, Outcome::Added(..)));
        let on_plane = of(|outcome| matches!(outcome, Outcome::OnPlane));
        let paired = of(|outcome| matches!(outcome, Outcome::Partner(_)));
        let left = of(|outcome| matches!(outcome, Outcome::Left(_)));
        if self.common.json {
            let pair = |(i, outcome): (usize, &Outcome)| match outcome {
                Outcome::OnPlane => json!({ "marker": names[i], "on_plane": true }),
                Outcome::Partner(j) => json!({ "marker": names[i], "partner": names[*j] }),
                Outcome::Added(j, d) => json!({ "marker": names[i], "added": names[*j], "distances": d }),
                Outcome::Left(why) => json!({ "marker": names[i], "left": why }),
            };
            terminal::print_json(&json!({
                "markers": names.len(), "added": added, "on_plane": on_plane, "with_partner": paired, "left": left,
                "pairs": mirrored.outcomes.iter().enumerate().map(pair).collect::<Vec<_>>(), "written": written,
            }));
        } else {
            let mut text = format!(
                "{added} added, {paired} have a partner, {on_plane} lie on the plane, {left} left alone; {} markers now\n",
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
            terminal::print(&(text + &told(&written)));
        }
        Ok(Status::Done)
    }
}
