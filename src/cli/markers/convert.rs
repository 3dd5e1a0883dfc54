use serde_json::json;

use super::{Common, percent, told};
use crate::{
    cli::{Ended, terminal},
    core::mesh::SurfacePoint,
    markers::{MarkerFile, MarkerFiles, given::OnMeshes},
    status::Status,
    text::count,
};

/// Writes markers in another notation, and tells how far points lay off their mesh.
///
/// Reads .cons and .yaml (both sides in one file); MeshLab's .pp, Wrap's .json and .txt, named points as .csv and .json (a
/// file a side). Writes them too: `{side}` in the name stands for `source` and `target`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  mimesh markers convert horse.pp camel.pp pairs.yaml --source horse.obj --target camel.obj
  mimesh markers convert pairs.cons 'points-{side}.json' --pipeline horse-to-camel.yaml
  mimesh markers convert one-based.cons pairs.cons --from-one both --pipeline horse-to-camel.yaml")]
pub struct Convert {
    #[command(flatten)]
    common: Common,
    /// Bring points in another usual unit (100, 0.01, 1000, …), or with Y and Z exchanged, to the mesh
    #[arg(long)]
    fit: bool,
    /// Subtract 1 from the vertices and triangles of this side of a .cons or .yaml
    #[arg(long, value_name = "SIDE")]
    from_one: Option<FromOne>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum FromOne {
    Source,
    Target,
    Both,
}

impl Convert {
    /// Runs the command.
    pub fn run(&self) -> Ended {
        let loaded = self.common.load()?;
        let mut found = loaded.markers(self.fit)?;
        if let Some(sides) = self.from_one
            && matches!(loaded.files, MarkerFiles::One(_))
        {
            found.markers = counted_from_zero(&found.markers, sides);
        }
        let [source, target] = loaded.sides();
        // Points that are to be found have no place yet; the others must be on their meshes.
        let complete = found.markers.entries.iter().filter(|entry| entry.target.is_some()).cloned().collect();
        MarkerFile { entries: complete, ..MarkerFile::default() }.resolve(source, target)?;
        found.remember(source, target, loaded.mesh_files())?;
        let written = self.common.write(&loaded, &found.markers)?;
        if self.common.json {
            terminal::print_json(&json!({
                "markers": found.markers.entries.len(),
                "source": side_json(&found, 0), "target": side_json(&found, 1), "written": written,
            }));
        } else {
            let mut text = format!("{}\n", count(found.markers.entries.len(), "marker", "markers"));
            (0..2).for_each(|k| text.push_str(&side_text(&found, k)));
            terminal::print(&(text + &told(&written)));
        }
        Ok(Status::Done)
    }
}

fn counted_from_zero(markers: &MarkerFile, sides: FromOne) -> MarkerFile {
    // A 0 that cannot be counted down is out of every range afterwards, and told so.
    let down = |point: SurfacePoint| match point {
        SurfacePoint::Vertex(vertex) => SurfacePoint::Vertex(vertex.wrapping_sub(1)),
        SurfacePoint::Triangle(triangle, at) => SurfacePoint::Triangle(triangle.wrapping_sub(1), at),
    };
    let mut markers = markers.clone();
    for entry in &mut markers.entries {
        if sides != FromOne::Target {
            entry.source = down(entry.source);
        }
        if sides != FromOne::Source {
            entry.target = entry.target.map(down);
        }
    }
    markers
}

/// How far the points of a side lay off its surface, in a line.
fn side_text(found: &OnMeshes, k: usize) -> String {
    let side = ["source", "target"][k];
    let distances = &found.distances[k];
    let Some((name, farthest)) = distances.iter().max_by(|a, b| a.1.total_cmp(&b.1)) else { return String::new() };
    let mean = distances.iter().map(|(_, distance)| distance).sum::<f64>() / distances.len() as f64;
    let usual = found.usual[k].map_or(String::new(), |usual| format!(" ({usual})"));
    format!(
        "{side}: {} by position{usual}; off the surface by {} of the diagonal in the mean, {} at most ({name})\n",
        distances.len(),
        percent(mean),
        percent(*farthest)
    )
}

fn side_json(found: &OnMeshes, k: usize) -> serde_json::Value {
    let points: Vec<_> =
        found.distances[k].iter().map(|(name, distance)| json!({ "name": name, "distance": distance })).collect();
    json!({ "by_position": points, "fitted": found.usual[k].map(|usual| usual.to_string()) })
}
