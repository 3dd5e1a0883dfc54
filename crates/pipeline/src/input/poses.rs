//! The poses of the source: where they are, and how they are read.

use std::path::PathBuf;

use mimesh_core::{
    Result,
    mesh::{ClipTime, PosesAre, check_finite},
    stage::Selection,
};
use nalgebra::Point3;
use rayon::prelude::*;

use super::RestMesh;
use crate::formats::Formats;

/// A pose of the source.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseInput {
    /// The name, which `{pose}` stands for.
    pub name: String,
    /// The time in a clip, if it is a frame of one.
    pub time: Option<ClipTime>,
    /// Where its positions are.
    pub from: PoseFrom,
}

/// Where the positions of a pose are.
#[derive(Clone, Debug, PartialEq)]
pub enum PoseFrom {
    /// In a file of its own.
    File(PathBuf),
    /// In the source's sequence, under this number.
    Held(usize),
}

/// What `poses` are to each other: frames of clips are frames, others by their names.
///
/// `declared` is what the pipeline says.
pub fn poses_are(declared: Option<PosesAre>, poses: &[PoseInput]) -> PosesAre {
    if let Some(declared) = declared {
        return declared;
    }
    if !poses.is_empty() && poses.iter().all(|pose| pose.time.is_some()) {
        return PosesAre::Frames;
    }
    PosesAre::of_names(poses.iter().map(|pose| pose.name.as_str()))
}

/// The vertices of the source's mesh in one pose (#V of the file).
///
/// # Errors
///
/// If the pose cannot be read, is no pose of the source, or is not finite.
pub fn read_pose(source: &RestMesh, formats: &Formats, from: &PoseFrom) -> Result<Vec<Point3<f64>>> {
    let positions = match from {
        PoseFrom::Held(i) => source.sequence.poses[*i].positions.get()?.into_owned(),
        PoseFrom::File(path) => {
            let Selection { meshes, same_vertices, .. } = &source.selection;
            let selection = Selection { meshes: meshes.clone(), same_vertices: *same_vertices, ..Selection::default() };
            source.in_own_units(formats.read_pose(path, &selection, &source.sequence.rest)?)
        }
    };
    check_finite(&positions)?;
    Ok(positions)
}

/// At most `count` poses of the source's surface, evenly spaced over `poses`.
///
/// Poses that cannot be read are left out; they are reported when their turn comes.
///
/// # Errors
///
/// Those of [`Surface::from_mesh`](mimesh_core::mesh::Surface::from_mesh), for poses of another length.
pub fn read_evenly_spaced(
    source: &RestMesh,
    formats: &Formats,
    poses: &[PoseInput],
    count: usize,
) -> Result<Vec<Vec<Point3<f64>>>> {
    let chosen = evenly_spaced(poses.len(), count);
    let readable: Vec<_> = chosen.par_iter().filter_map(|&i| read_pose(source, formats, &poses[i].from).ok()).collect();
    readable.iter().map(|positions| source.surface.from_mesh(positions)).collect()
}

/// At most `count` of the numbers 0 to `all` - 1, evenly spaced.
pub fn evenly_spaced(all: usize, count: usize) -> Vec<usize> {
    if count >= all { (0..all).collect() } else { (0..count).map(|k| k * all / count).collect() }
}
