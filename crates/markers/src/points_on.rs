//! The points of a marker file on one mesh.

use std::path::Path;

use mimesh_core::mesh::{MeshPoint, SurfacePoint};
use mimesh_document::Result;

use crate::{
    attach::attach,
    attacher::Attacher,
    indices::{check, indexed_points},
    mesh::MarkerMesh,
    notation::is_point_file,
    read::{read_markers, read_points},
    unit_axes::{self, UnitAxes},
};

/// The points in `file` on the surface of one mesh, as for a picture of it: of pairs the points of that side that are known.
///
/// # Errors
///
/// All that is wrong with the file, and points that are not on the mesh.
pub fn points_on(file: &Path, mesh: MarkerMesh<'_>) -> Result<Vec<SurfacePoint>> {
    let points: Vec<MeshPoint> = if is_point_file(file) {
        let points = read_points(file)?;
        let attacher = Attacher::new(mesh)?;
        let unit_axes = unit_axes::detect(&attacher, &points.positions_in_space()).unwrap_or(UnitAxes::IDENTITY);
        attach(&points, &attacher, unit_axes)?.into_iter().map(|attached| attached.point).collect()
    } else {
        let points = indexed_points(&read_markers(file)?, mesh.role);
        check(mesh, &points).into_result()?;
        points.into_iter().map(|indexed| indexed.point).collect()
    };
    Ok(points.into_iter().filter_map(|point| mesh.surface.point(point)).collect())
}
