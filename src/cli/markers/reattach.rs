use std::path::PathBuf;

use serde_json::json;

use super::{Common, percent, read_mesh, told};
use crate::{
    cli::{Ended, terminal},
    diagnostic::{Diagnostics, Result},
    markers::{MarkerFile, given, reattach},
    pipeline::hash_file,
    status::Status,
};

/// Carries markers to meshes that were edited, by where their points were.
///
/// Give the edited meshes, and with --old-source or --old-target the meshes that the markers were made on; without these,
/// a .yaml is taken at its word where its points were (`at`). A point goes to the vertex that lies where it was, else to
/// the closest place of the surface.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  mimesh markers reattach pairs.yaml new.yaml --pipeline horse-to-camel.yaml
  mimesh markers reattach pairs.cons new.cons --source horse.obj --target camel.obj --old-target camel-before.obj")]
pub struct Reattach {
    #[command(flatten)]
    common: Common,
    /// The source mesh that the markers were made on
    #[arg(long, value_name = "MESH")]
    old_source: Option<PathBuf>,
    /// The target mesh that the markers were made on
    #[arg(long, value_name = "MESH")]
    old_target: Option<PathBuf>,
}

impl Reattach {
    /// Runs the command.
    pub fn run(&self) -> Ended {
        let loaded = self.common.load()?;
        let mut markers = match given::read(&loaded.files)? {
            given::Given::Both(markers) => markers,
            given::Given::Sides(_) => loaded.markers(false)?.markers,
        };
        let [source, target] = loaded.sides();
        let files = loaded.mesh_files();
        let olds = [&self.old_source, &self.old_target];
        let mut moves = vec![];
        let mut diagnostics = vec![];
        for (k, side) in [source, target].into_iter().enumerate() {
            let old = olds[k].as_ref().map(|file| read_mesh(file)).transpose()?;
            if old.is_none() && !has_changed(&markers, side.name, files[k], olds[1 - k].is_some()) {
                moves.push(vec![]);
                continue;
            }
            let old = old.as_ref().map(|old| old.for_markers(side.name));
            match reattach::reattach(&mut markers, old, side, self.common.force) {
                Ok(of_side) => moves.push(of_side),
                Err(failure) => diagnostics.extend(failure.diagnostics),
            }
        }
        if !diagnostics.is_empty() {
            return Err(Diagnostics { diagnostics });
        }
        given::remember(&mut markers, source, target, files)?;
        let written = self.common.write(&loaded, &markers)?;
        self.report(&moves, &written)?;
        Ok(Status::Done)
    }

    fn report(&self, moves: &[Vec<reattach::Move>], written: &[PathBuf]) -> Result<()> {
        let sides = ["source", "target"].into_iter().zip(moves);
        if self.common.json {
            let of = |moved: &reattach::Move| {
                json!({
                    "marker": moved.name, "from": [moved.from.x, moved.from.y, moved.from.z],
                    "moved": moved.distance, "doubt": moved.doubt,
                })
            };
            let sides: serde_json::Map<String, serde_json::Value> =
                sides.map(|(side, moves)| (side.to_owned(), moves.iter().map(of).collect())).collect();
            terminal::print_json(&json!({ "points": sides, "written": written }));
            return Ok(());
        }
        let mut text = String::new();
        for (side, moves) in sides {
            let Some(farthest) = moves.iter().max_by(|a, b| a.distance.total_cmp(&b.distance)) else {
                text.push_str(&format!("{side}: unchanged\n"));
                continue;
            };
            let doubtful: Vec<_> = moves.iter().filter(|moved| moved.doubt.is_some()).collect();
            text.push_str(&format!(
                "{side}: {} points, the farthest moved by {} of the diagonal ({}), {} doubtful\n",
                moves.len(),
                percent(farthest.distance),
                farthest.name,
                doubtful.len()
            ));
            for moved in doubtful {
                text.push_str(&format!("  {}: {}\n", moved.name, moved.doubt.as_deref().unwrap_or_default()));
            }
        }
        terminal::print(&(text + &told(written)));
        Ok(())
    }
}

/// Whether the points of a side have to be looked at: unless its mesh is the one that the markers were made on. A side of
/// which nothing is known is taken to be the same if the other side's old mesh was given.
fn has_changed(markers: &MarkerFile, side: &str, file: Option<&PathBuf>, other_given: bool) -> bool {
    let known = markers.reference(side).and_then(|reference| reference.blake3.as_deref());
    match (known, file) {
        (Some(hash), Some(file)) => hash_file(file).map_or(true, |found| !found.eq_ignore_ascii_case(hash)),
        _ => !other_given,
    }
}
