//! The points of a marker file on one mesh.

use std::path::Path;

use mimesh_core::mesh::{MeshPoint, SurfacePoint};
use mimesh_document::Result;

use crate::{
    attach::attach,
    attacher::{Attacher, is_too_far},
    indices::{check, indexed_points},
    mesh::{MarkerMesh, MeshRole},
    notation::{Notation, is_point_file},
    points::PointFile,
    read::{read_markers, read_points, read_two_sets},
    scene::{self, ScenePoints},
    unit_axes::{self, UnitAxes},
};

/// The points in `file` on the surface of one mesh, as for a picture of it: of pairs the points of that side that are known.
///
/// # Errors
///
/// All that is wrong with the file, and points that are not on the mesh.
pub fn points_on(file: &Path, mesh: MarkerMesh<'_>, scenes: &dyn ScenePoints) -> Result<Vec<SurfacePoint>> {
    let scene = if Notation::of(file).is_none() { scene::read(file, scenes) } else { None };
    let points: Vec<MeshPoint> = if let Some(nodes) = scene {
        // Which of the nodes are meant is known beside those of the other mesh only.
        let attacher = Attacher::new(mesh)?;
        let attached = nodes?.positions_in_space().into_iter().map(|position| attacher.attach(&position));
        attached.filter(|attached| !is_too_far(attached.distance)).map(|attached| attached.point).collect()
    } else if is_point_file(file) {
        let points = side(file, mesh)?;
        let attacher = Attacher::new(mesh)?;
        let detected = unit_axes::detect(&attacher, &points.positions_in_space(), points.anatomy.is_some());
        let unit_axes = detected.unwrap_or(UnitAxes::IDENTITY);
        attach(&points, &attacher, unit_axes)?.into_iter().map(|attached| attached.point).collect()
    } else {
        let points = indexed_points(&read_markers(file)?, mesh.role);
        check(mesh, &points).into_result()?;
        points.into_iter().map(|indexed| indexed.point).collect()
    };
    Ok(points.into_iter().filter_map(|point| mesh.surface.point(point)).collect())
}

/// The points of `mesh` in a file of points, which may hold both sides.
fn side(file: &Path, mesh: MarkerMesh<'_>) -> Result<PointFile> {
    if Notation::of(file) == Some(Notation::Amira)
        && let Ok([source, target]) = read_two_sets(file)
    {
        return Ok(if mesh.role == MeshRole::Source { source } else { target });
    }
    read_points(file)
}
