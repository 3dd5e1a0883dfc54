//! What the tests of several notations have in common.

use mimesh_core::mesh::MeshPoint;
use mimesh_document::Result;

use crate::points::{PointFile, PointPosition};

/// The names and positions in a file that could be read.
#[track_caller]
pub fn positions(read: Result<PointFile>) -> Vec<(Option<String>, PointPosition)> {
    let file = read.unwrap_or_else(|failure| panic!("{failure}"));
    file.points.into_iter().map(|point| (point.name, point.position)).collect()
}

pub fn vertex(vertex: u32) -> PointPosition {
    PointPosition::OnMesh(MeshPoint::Vertex(vertex))
}
