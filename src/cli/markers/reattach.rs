//! `mimesh markers reattach`: markers carried to edited meshes.

use std::path::{Path, PathBuf};

use mimesh_document::{
    diagnostic::{Diagnostics, Result},
    files::hash_file,
};
use mimesh_markers::{MarkerFile, MeshRole, Move, PointSource, reattach};
use serde_json::json;

use crate::cli::{
    CommandResult,
    markers::{Common, percent, read_mesh, written_lines},
    status::Status,
    terminal,
};

/// Carries markers to edited meshes, by the positions of their points.
///
/// Give the edited meshes, and the meshes that the markers were made on with --old-source and --old-target. Without the
/// latter, a .yaml gives the positions (`at`). A point goes to the vertex at its position, else to the closest point of
/// the surface.
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
    pub fn run(&self) -> CommandResult {
        let loaded = self.common.load()?;
        let mut markers = match PointSource::read(&loaded.files, &loaded.formats)? {
            PointSource::Pairs(markers) => markers,
            PointSource::Sides(_) => loaded.markers(false)?.markers,
        };
        let files = loaded.mesh_files();
        let formats = self.common.roots.formats();
        let old_files = [&self.old_source, &self.old_target];
        let mut moves = vec![];
        let mut diagnostics = vec![];
        for (k, mesh) in loaded.meshes().into_iter().enumerate() {
            let old = old_files[k].as_ref().map(|file| read_mesh(&formats, file)).transpose()?;
            if old.is_none() && !has_changed(&markers, mesh.role, files[k], old_files[1 - k].is_some()) {
                moves.push(vec![]);
                continue;
            }
            let old = old.as_ref().map(|old| old.for_markers(mesh.role));
            match reattach(&mut markers, old, mesh, self.common.force) {
                Ok(side) => moves.push(side),
                Err(failure) => diagnostics.extend(failure.list),
            }
        }
        if !diagnostics.is_empty() {
            return Err(Diagnostics { list: diagnostics });
        }
        markers.record_positions(loaded.meshes(), files);
        let written = self.common.write(&loaded, &markers)?;
        self.report(&moves, &written)?;
        Ok(Status::Done)
    }

    /// Prints the moves of each side and the written files.
    fn report(&self, moves: &[Vec<Move>], written: &[PathBuf]) -> Result<()> {
        let sides = ["source", "target"].into_iter().zip(moves);
        if self.common.json {
            let move_json = |moved: &Move| {
                json!({
                    "marker": moved.name, "from": [moved.from.x, moved.from.y, moved.from.z],
                    "moved": moved.distance, "doubt": moved.doubt,
                })
            };
            let sides: serde_json::Map<String, serde_json::Value> =
                sides.map(|(side, moves)| (side.to_owned(), moves.iter().map(move_json).collect())).collect();
            terminal::print_json(&json!({ "points": sides, "written": terminal::all_shown(written) }));
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
        terminal::print(&(text + &written_lines(written)));
        Ok(())
    }
}

/// Whether the mesh of a side is another than the one that the markers were made on.
///
/// If the markers do not record a hash of that mesh, a side counts as unchanged if only the other side's old mesh is
/// given.
fn has_changed(markers: &MarkerFile, role: MeshRole, file: Option<&Path>, other_given: bool) -> bool {
    let known = markers.reference(role).and_then(|reference| reference.blake3.as_deref());
    match (known, file) {
        (Some(hash), Some(file)) => hash_file(file).map_or(true, |found| !found.eq_ignore_ascii_case(hash)),
        _ => !other_given,
    }
}
