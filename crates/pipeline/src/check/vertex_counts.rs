//! Files of poses and known results that have another number of vertices than their mesh, found without reading them whole.

use std::path::Path;

use mimesh_core::{
    mesh::Mesh,
    stage::{Selection, check_vertices},
};
use mimesh_document::Diagnostic;

use super::rest_meshes::in_file;
use crate::{
    formats::Formats,
    input::{GroundTruth, PoseFrom, PoseInput, Prepared},
};

/// What tells that `file` is no pose of `rest`, if that can be seen.
fn other_count(formats: &Formats, file: &Path, selection: &Selection, rest: &Mesh) -> Option<Diagnostic> {
    let count = formats.vertex_count(file, selection)?;
    check_vertices(file, rest, count).err().map(|error| in_file(file, error))
}

/// Diagnostics of all poses of `prepared` if none of them can be one: the run would fail with every one, after its stages.
///
/// Where one may be a pose nothing is said, since the run tells of the others as it comes to them.
pub fn no_pose_fits(prepared: &Prepared) -> Vec<Diagnostic> {
    let (selection, rest) = (&prepared.source.selection, &prepared.source.sequence.rest);
    let other = |pose: &PoseInput| match &pose.from {
        PoseFrom::File(file) => other_count(&prepared.formats, file, selection, rest),
        PoseFrom::Held(_) => None,
    };
    prepared.poses.iter().map(other).collect::<Option<_>>().unwrap_or_default()
}

/// Diagnostics of the poses and known results of `prepared` that have another number of vertices than their mesh.
pub fn other_vertex_counts(prepared: &Prepared) -> Vec<Diagnostic> {
    let (source, target) = (&prepared.source, &prepared.target);
    let poses = prepared.poses.iter().filter_map(|pose| match &pose.from {
        PoseFrom::File(file) => other_count(&prepared.formats, file, &source.selection, &source.sequence.rest),
        PoseFrom::Held(_) => None,
    });
    let truth = match &prepared.truth {
        GroundTruth::Files { files, .. } => &files[..],
        _ => &[],
    };
    let of_truth = |file: &Path| other_count(&prepared.formats, file, &target.selection, &target.sequence.rest);
    poses.chain(truth.iter().filter_map(|file| of_truth(file))).collect()
}
