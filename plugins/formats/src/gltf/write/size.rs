//! The size of a GLB before it is written.

use mimesh_core::{Result, mesh::Mesh};

use super::{options::Options, output::check_length, patch, plan::Plan};
use crate::gltf::document::{self, GltfDocument};

/// Checks that a GLB of `mesh` with `poses` poses in which every vertex moves goes into its 4 GiB, JSON not counted.
///
/// # Errors
///
/// [`Error::Data`](mimesh_core::Error::Data) with the estimate and the limit.
pub fn check(options: &Options, mesh: &Mesh, poses: usize) -> Result<()> {
    let (rest, vertices, with_normals) = match patch::document(mesh) {
        Some(document) => (bytes_of(document), mesh.positions.len(), mesh.normals.is_some()),
        None => {
            let corners = mesh.polygons.corner_count();
            let colors = if mesh.vertex_colors.is_some() { 16 } else { 0 };
            let images = mesh.materials.iter().filter_map(|material| material.base_color_image.as_deref());
            let images = images.map(|image| image.contents.as_ref().map_or(0, |bytes| bytes.len() as u64)).sum::<u64>();
            let rest_bytes = |vertices: usize| rest_bytes(corners, vertices) + colors * vertices as u64 + images;
            // No corner has more than one vertex of its own, so that the cuts along seams need not be counted as a rule.
            let most = corners + mesh.positions.len();
            if fits(rest_bytes(most), most, options.pose_normals, poses) {
                return Ok(());
            }
            let vertices = Plan::new(mesh).objects.iter().map(|object| object.vertices.len()).sum();
            (rest_bytes(vertices), vertices, true)
        }
    };
    check_length(length(rest, vertices, options.pose_normals && with_normals, poses)).map(|_| ())
}

fn fits(rest: u64, vertices: usize, normals: bool, poses: usize) -> bool {
    check_length(length(rest, vertices, normals, poses)).is_ok()
}

/// The length with one displacement a vertex and pose, and one of its normal.
fn length(rest: u64, vertices: usize, normals: bool, poses: usize) -> u64 {
    let a_vertex: u64 = if normals { 24 } else { 12 };
    rest.saturating_add((vertices as u64).saturating_mul(a_vertex).saturating_mul(poses as u64))
}

/// Positions, normals, texture coordinates; three indices of four bytes a triangle, fewer than a corner each has.
fn rest_bytes(corners: usize, vertices: usize) -> u64 {
    32 * vertices as u64 + 12 * corners as u64
}

/// All bytes that a file brings with it.
fn bytes_of(document: &GltfDocument) -> u64 {
    let images = document.images.iter().map(|(_, bytes)| &**bytes);
    let parts = images.chain(document.decompressed.values()).chain(document.unpacked.values());
    let parts: u64 = parts.map(|bytes| bytes.len() as u64).sum();
    parts + document::bytes_of(&document.buffers) as u64
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use super::*;
    use crate::Glb;

    #[test]
    fn too_many_poses_of_too_many_vertices_are_refused() {
        let positions = (0..3000).map(|i| Point3::new(f64::from(i), f64::from(i * i), 0.0)).collect();
        let triangles: Vec<_> = (0..1000).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let mesh = Mesh::from_triangles(positions, &triangles);
        let with = Glb::default().options();
        let without = Options { pose_normals: false, ..with };
        // 3000 vertices of 24 bytes: 2^32 bytes are reached after 59,652 poses, in half as many without normals.
        check(&with, &mesh, 59_600).unwrap();
        let error = check(&with, &mesh, 59_700).unwrap_err();
        let expected = 59_700_u64 * 3000 * 24 + 32 * 3000 + 12 * 3000;
        assert!(error.to_string().contains(&format!("{expected} bytes")), "{error}");
        assert!(error.hint().is_some_and(|hint| hint.contains("pose_normals")));
        check(&without, &mesh, 119_200).unwrap();
        check(&without, &mesh, 119_400).unwrap_err();
        check(&with, &mesh, usize::MAX).unwrap_err();
    }
}
