//! The markers that a project begins with.

use std::path::PathBuf;

use mimesh_markers::{MarkerFiles, PointSource, from_landmarks, notation::Notation};
use mimesh_pipeline::Formats;

use crate::{
    markers::{Origin, file, pair::Content},
    meshes::Meshes,
};

/// The file of the document, and the pairs that it begins with if there is no such file.
///
/// A `.yaml` of markers that the pipeline names is edited itself. Other files are read once, and edited as a file of ours (`own`).
pub(super) fn initial_markers(
    named: Option<&MarkerFiles>,
    own: PathBuf,
    meshes: &Meshes,
    formats: &Formats,
) -> (PathBuf, Vec<(Content, Origin)>) {
    if let Some(file) = named.and_then(MarkerFiles::one)
        && Notation::of(file) == Some(Notation::Yaml)
    {
        return (file.clone(), vec![]);
    }
    let markers = match named {
        // What is wrong with them is among the diagnostics of the pipeline.
        Some(files) => PointSource::read(files, formats)
            .and_then(|read| read.attach(meshes.for_markers(), false))
            .map(|on| on.markers)
            .ok(),
        None => Some(from_landmarks(&meshes.sides[0].sequence, &meshes.sides[1].sequence)),
    };
    let pairs = markers.map(|markers| markers.pairs).unwrap_or_default();
    (own, pairs.iter().map(|pair| (file::content(pair), Origin::File)).collect())
}
