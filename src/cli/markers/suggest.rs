//! `mimesh markers suggest`: the point to click next.

use mimesh_core::stage::Work;
use mimesh_core::{
    mesh::{Surface, SurfacePoint},
    stage::{Marker, TransferPair},
};
use mimesh_document::diagnostic::{Diagnostic, Kind, Result};
use mimesh_markers::{IntoDiagnostic, MarkerStatus, MeshRole, PointSource};
use mimesh_pipeline::{Formats, input::Meshes, propose::propose, text::count};
use serde_json::json;

use crate::cli::{
    CommandResult,
    markers::{percent, propose::MeshArguments},
    status::Status,
    terminal,
};

/// Names the point whose click would help most: where fits from both sides disagree, away from the points that are known.
///
/// Known are the pairs of --clicks, and if none of these is proposed, what the stage proposes beside them, as in a run.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  mimesh markers suggest horse.obj camel.obj --clicks pairs.yaml
  mimesh markers suggest --pipeline horse-to-camel.yaml --json")]
pub struct Suggest {
    #[command(flatten)]
    meshes: MeshArguments,
    /// Print the point as JSON
    #[arg(long)]
    json: bool,
}

impl Suggest {
    /// Runs the command.
    pub fn run(&self) -> CommandResult {
        let (meshes, stage) = self.meshes.read()?;
        let Known { pairs, are_clicks } = known(&meshes, &self.meshes.formats())?;
        let known = if are_clicks {
            let sides = [&meshes.source, &meshes.target];
            let proposed = propose(stage.as_ref(), sides, &pairs, self.meshes.allow_commands(), Work::UNWATCHED);
            match proposed {
                Ok(proposal) => proposal.markers(),
                // Clicks say more than nothing where the shapes alone say too little.
                Err(_) if !pairs.is_empty() => pairs,
                Err(failure) => return Err(failure),
            }
        } else {
            pairs
        };
        let pair = TransferPair {
            source: &meshes.source.surface,
            target: meshes.target.seen_surface(),
            markers: &known,
            proximity: None,
        };
        let suggested = stage.suggest(pair).map_err(IntoDiagnostic::into_diagnostic)?;
        let Some(suggested) = suggested else {
            let message = format!("the stage {} suggests no points", stage.typetag_name());
            return Err(Diagnostic::new(Kind::Usage, message)
                .hint("take another one, e.g. `--type extremities`")
                .into());
        };
        let (source, target) = (&meshes.source.surface, &meshes.target.surface);
        let on_source = source.mesh_point(suggested.source);
        let on_target = suggested.target.map(|point| target.mesh_point(point));
        if self.json {
            let place = |surface: &Surface, point: SurfacePoint| {
                let place = point.position(surface, &surface.positions);
                [place.x, place.y, place.z]
            };
            terminal::print_json(&json!({
                "source": on_source, "source_at": place(source, suggested.source),
                "target": on_target, "target_at": suggested.target.map(|point| place(target, point)),
                "doubt": suggested.doubt, "known": known.len(),
            }));
            return Ok(Status::Done);
        }
        let mut text = format!("click next, beside {}:\n", count(known.len(), "known pair", "known pairs"));
        text += &format!("  on the source at {}\n", described(source, suggested.source));
        if let Some(point) = suggested.target {
            text += &format!("  its partner is now near {} of the target\n", described(target, point));
        }
        text += &match suggested.doubt {
            Some(doubt) => format!("  fits from both sides disagree around it by {} of the diagonal\n", percent(doubt)),
            None => "  the known pairs are too few for a fit; this is the place farthest from them\n".to_owned(),
        };
        terminal::print(&text);
        Ok(Status::Done)
    }
}

/// The pairs that files give.
struct Known {
    pairs: Vec<Marker>,
    /// Whether all are confirmed, so that a stage has not proposed any yet.
    are_clicks: bool,
}

/// The pairs of the files of `meshes`, none if these name no files.
fn known(meshes: &Meshes, formats: &Formats) -> Result<Known> {
    let Some(files) = &meshes.markers else { return Ok(Known { pairs: vec![], are_clicks: true }) };
    let on = [meshes.source.for_markers(MeshRole::Source), meshes.target.for_markers(MeshRole::Target)];
    let mut markers = PointSource::read(files, formats)?.attach(on, false)?.markers;
    markers.pairs.retain(|pair| pair.source.is_some() && pair.target.is_some());
    let are_clicks = markers.pairs.iter().all(|pair| pair.status == MarkerStatus::Confirmed);
    Ok(Known { pairs: markers.resolve(on)?, are_clicks })
}

/// A point for people: the vertex nearest to it, and where it is.
fn described(surface: &Surface, point: SurfacePoint) -> String {
    let place = point.position(surface, &surface.positions);
    let nearest = point.corners(surface).into_iter().max_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |corner| corner.0);
    let vertex = surface.representative[nearest as usize];
    format!("vertex {vertex} ({:.4}, {:.4}, {:.4})", place.x, place.y, place.z)
}
