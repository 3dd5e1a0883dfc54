//! Markers by a stage, as a run and a person ask for them.

use mimesh_core::stage::{Landmarks, Marker, Proposal, TransferPair, Work};
use mimesh_document::{Diagnostic, Kind, diagnostic::Result};
use mimesh_markers::{IntoDiagnostic, MarkerFile, MarkerPair, MarkerStatus, MeshRole};

use crate::{
    handedness,
    input::{Meshes, RestMesh},
};

/// Remedy: allow stages to run programs.
pub const ALLOW_COMMANDS: &str = "allow_commands";

/// The pairs that `landmarks` proposes between two meshes at rest, beside the user's `clicks`; a warning tells where the target looks
/// mirrored. The stage reports to `work` how much is done.
///
/// # Errors
///
/// Those of the stage, and for a stage that runs a program where that is not allowed.
pub fn propose(
    landmarks: &dyn Landmarks,
    [source, target]: [&RestMesh; 2],
    clicks: &[Marker],
    allow_commands: bool,
    work: Work<'_>,
) -> Result<Proposal> {
    if let Some(command) = landmarks.command().filter(|_| !allow_commands) {
        return Err(not_allowed(command).into());
    }
    let pair =
        TransferPair { source: &source.surface, target: target.seen_surface(), markers: clicks, proximity: None };
    let proposal = landmarks.propose_watched(pair, work).and_then(|proposal| proposal.check(pair).map(|()| proposal));
    let mut proposal = proposal.map_err(IntoDiagnostic::into_diagnostic)?;
    if let Some(warning) = handedness::warning_of_markers(source, target, &proposal.markers()) {
        proposal.figures.warn(warning);
    }
    Ok(proposal)
}

/// The refusal of a program that the user did not allow; whoever wrote the pipeline may be a stranger.
fn not_allowed(command: &[String]) -> Diagnostic {
    let message = format!("it would run the command `{}`", command.join(" "));
    let hint = "look at it, and allow commands if you trust it";
    Diagnostic::new(Kind::Usage, message).remedy(ALLOW_COMMANDS, "", hint)
}

/// A proposal as the contents of a file: the first `clicked` pairs are confirmed, the others proposed.
pub fn as_file(proposal: &Proposal, meshes: &Meshes, clicked: usize) -> MarkerFile {
    let pair = |(index, proposed): (usize, &mimesh_core::stage::ProposedPair)| {
        let is_clicked = index < clicked;
        let source = meshes.source.surface.mesh_point(proposed.marker.source);
        let target = meshes.target.surface.mesh_point(proposed.marker.target);
        MarkerPair {
            name: Some(proposed.marker.name.clone()),
            status: if is_clicked { MarkerStatus::Confirmed } else { MarkerStatus::Proposed },
            // Four digits are more than it is worth.
            confidence: (!is_clicked).then(|| (proposed.confidence * 1e4).round() / 1e4),
            ..MarkerPair::new(source, target)
        }
    };
    let pairs = proposal.pairs.iter().enumerate().map(pair).collect();
    let mut file = MarkerFile { pairs, ..MarkerFile::default() };
    let files = [meshes.source.path.as_deref(), meshes.target.path.as_deref()];
    let on = [meshes.source.for_markers(MeshRole::Source), meshes.target.for_markers(MeshRole::Target)];
    file.record_positions(on, files);
    file
}
