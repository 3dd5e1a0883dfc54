//! `mimesh markers convert`: markers in another notation.

use std::path::PathBuf;

use mimesh_core::mesh::MeshPoint;
use mimesh_document::diagnostic::{Diagnostic, Kind, Location, Result};
use mimesh_markers::{AttachedMarkers, MarkerFile, Note, notation::Notation};
use mimesh_pipeline::text::count;
use serde_json::json;

use crate::cli::{
    CommandResult,
    markers::{Common, percent, written_lines},
    status::Status,
    terminal,
};

/// Writes markers in another notation, and reports the distances of points to their mesh.
///
/// Files of pairs are .cons and .yaml. Files of points, one for each side, are MeshLab's .pp, Wrap's .json and .txt,
/// and named points as .csv or .json. The command reads and writes them all. It also reads points of 3D Slicer
/// (.mrk.json, .fcsv), .pts, Avizo's .landmarkAscii, and the empties of a .glb. In the name of files to write, `{side}`
/// stands for `source` and `target`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  mimesh markers convert horse.pp camel.pp pairs.yaml --source horse.obj --target camel.obj
  mimesh markers convert pairs.cons 'points-{side}.json' --pipeline horse-to-camel.yaml
  mimesh markers convert one-based.cons pairs.cons --from-one both --pipeline horse-to-camel.yaml")]
pub struct Convert {
    #[command(flatten)]
    common: Common,
    /// Fit points in another unit (a factor of 100, 0.01, 1000, …) or with Y and Z exchanged to the mesh
    #[arg(long)]
    fit: bool,
    /// Subtract 1 from the numbers of vertices and triangles of this side of a .cons or .yaml
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
    pub fn run(&self) -> CommandResult {
        let loaded = self.common.load()?;
        if self.from_one.is_some() && !holds_pairs(loaded.files.one()) {
            let hint = "files of points count from 0; correct the numbers in the files, or remove `--from-one`";
            return Err(usage("it counts the numbers of a .cons or .yaml only".into()).hint(hint).into());
        }
        let mut attached = loaded.markers(self.fit)?;
        if let Some(sides) = self.from_one {
            attached.markers = counted_from_zero(&attached.markers, sides)?;
        }
        // Pairs without a target are still incomplete; the others must be on their meshes.
        let complete = attached.markers.pairs.iter().filter(|pair| pair.target.is_some()).cloned().collect();
        MarkerFile { pairs: complete, ..MarkerFile::default() }.resolve(loaded.meshes())?;
        attached.markers.record_positions(loaded.meshes(), loaded.mesh_files());
        let written = self.common.write(&loaded, &attached.markers)?;
        if self.common.json {
            terminal::print_json(&json!({
                "markers": attached.markers.pairs.len(), "notes": notes_json(&attached.notes),
                "source": side_json(&attached, 0), "target": side_json(&attached, 1), "written": terminal::all_shown(&written),
            }));
        } else {
            let mut text = format!("{}\n", count(attached.markers.pairs.len(), "marker", "markers"));
            (0..2).for_each(|k| text.push_str(&side_text(&attached, k)));
            for Note { about, chosen, why } in &attached.notes {
                text.push_str(&format!("{about}: {chosen}: {why}\n"));
            }
            terminal::print(&(text + &written_lines(&written)));
        }
        Ok(Status::Done)
    }
}

/// Whether `file` holds pairs by number: two sets of positions in one file are none.
fn holds_pairs(file: Option<&PathBuf>) -> bool {
    file.is_some_and(|file| Notation::of(file) != Some(Notation::Amira))
}

/// The markers with numbers that count from 0, if those of `sides` count from 1.
fn counted_from_zero(markers: &MarkerFile, sides: FromOne) -> Result<MarkerFile> {
    let mut markers = markers.clone();
    for pair in &mut markers.pairs {
        if sides != FromOne::Target {
            pair.source = pair.source.map(minus_one).transpose()?;
        }
        if sides != FromOne::Source {
            pair.target = pair.target.map(minus_one).transpose()?;
        }
    }
    Ok(markers)
}

fn minus_one(point: MeshPoint) -> Result<MeshPoint> {
    let before = |element: &str, number: u32| {
        let message = format!("{element} 0, but `--from-one` counts from 1");
        number.checked_sub(1).ok_or_else(|| usage(message).hint("the numbers of this side count from 0 already"))
    };
    Ok(match point {
        MeshPoint::Vertex(vertex) => MeshPoint::Vertex(before("vertex", vertex)?),
        MeshPoint::Triangle(triangle, weights) => MeshPoint::Triangle(before("triangle", triangle)?, weights),
    })
}

fn usage(message: String) -> Diagnostic {
    Diagnostic::new(Kind::Usage, message).at(Location::Argument("--from-one".into()))
}

/// The distances of the points of side `k` to its surface, in a line.
fn side_text(attached: &AttachedMarkers, k: usize) -> String {
    let side = ["source", "target"][k];
    let distances = &attached.distances[k];
    let Some((name, farthest)) = distances.iter().max_by(|a, b| a.1.total_cmp(&b.1)) else { return String::new() };
    let mean = distances.iter().map(|(_, distance)| distance).sum::<f64>() / distances.len() as f64;
    let unit_axes = attached.unit_axes[k].map_or(String::new(), |unit_axes| format!(" ({unit_axes})"));
    format!(
        "{side}: {} by position{unit_axes}; off the surface by {} of the diagonal on average, at most {} ({name})\n",
        distances.len(),
        percent(mean),
        percent(*farthest)
    )
}

fn notes_json(notes: &[Note]) -> Vec<serde_json::Value> {
    let note = |Note { about, chosen, why }: &Note| json!({ "about": about, "chosen": chosen, "why": why });
    notes.iter().map(note).collect()
}

fn side_json(attached: &AttachedMarkers, k: usize) -> serde_json::Value {
    let points: Vec<_> =
        attached.distances[k].iter().map(|(name, distance)| json!({ "name": name, "distance": distance })).collect();
    json!({ "by_position": points, "fitted": attached.unit_axes[k].map(|unit_axes| unit_axes.to_string()) })
}
