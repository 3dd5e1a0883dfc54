//! The points of a file on their mesh.

use mimesh_core::mesh::MeshPoint;
use mimesh_document::{Diagnostic, Kind, Result};

use crate::{
    attacher::{Attached, Attacher, MAX_DISTANCE, is_too_far},
    indices::{self, IndexedPoint},
    points::{PointFile, PointPosition},
    remedies::FIT_UNIT_AXES,
    text::{extent, rounded},
    unit_axes::{self, MIN_POINTS, UnitAxes},
};

/// Points named in a message about many of them.
const MAX_NAMED: usize = 4;

/// The points of `file` on the mesh, in order; `unit_axes` is applied to those that are given in space.
///
/// # Errors
///
/// Every vertex and triangle that does not exist, and points that lie off the surface by more than [`MAX_DISTANCE`].
pub fn attach(file: &PointFile, attacher: &Attacher<'_>, unit_axes: UnitAxes) -> Result<Vec<Attached>> {
    indices::check(attacher.mesh, &indexed_points(file)).into_result()?;
    let attach = |position: &PointPosition| match position {
        PointPosition::OnMesh(point) => Attached::on_surface(*point),
        PointPosition::MeanOfVertices(vertices) => attacher.nearest_to_mean(vertices),
        PointPosition::InSpace(position) => attacher.attach(&unit_axes.apply(position)),
    };
    let attached: Vec<Attached> = file.points.iter().map(|point| attach(&point.position)).collect();
    match too_far(file, attacher, &attached, unit_axes) {
        Some(diagnostic) => Err(diagnostic.into()),
        None => Ok(attached),
    }
}

/// The points that are given by the numbers of vertices and triangles.
fn indexed_points(file: &PointFile) -> Vec<IndexedPoint> {
    let mut indexed = Vec::new();
    for (i, point) in file.points.iter().enumerate() {
        let points = match &point.position {
            PointPosition::OnMesh(point) => vec![*point],
            PointPosition::MeanOfVertices(vertices) => vertices.iter().copied().map(MeshPoint::Vertex).collect(),
            PointPosition::InSpace(_) => vec![],
        };
        let label = format!("point {}", file.name(i));
        let location = Some(point.location.clone());
        indexed.extend(points.into_iter().map(|point| IndexedPoint {
            label: label.clone(),
            point,
            location: location.clone(),
        }));
    }
    indexed
}

/// The diagnostic of all points that lie too far off the surface, at the first of them.
fn too_far(
    file: &PointFile,
    attacher: &Attacher<'_>,
    attached: &[Attached],
    unit_axes: UnitAxes,
) -> Option<Diagnostic> {
    let far: Vec<usize> = (0..attached.len()).filter(|&i| is_too_far(attached[i].distance)).collect();
    let (&first, others) = far.split_first()?;
    let positions: Vec<_> = file.positions_in_space().iter().map(|position| unit_axes.apply(position)).collect();
    let role = attacher.mesh.role;
    let also = if others.is_empty() {
        String::new()
    } else {
        let names: Vec<_> = others.iter().take(MAX_NAMED).map(|&i| file.name(i)).collect();
        let more = if others.len() > names.len() { ", …" } else { "" };
        format!(", and {} more of {} lie off it too ({}{more})", others.len(), file.points.len(), names.join(", "))
    };
    let message = format!(
        "point {} lies {} % of the diagonal off the {role}: expected {} % at most{also}; the points span {}, the {role} {}",
        file.name(first),
        rounded(100.0 * attached[first].distance),
        100.0 * MAX_DISTANCE,
        extent(&positions),
        extent(&attacher.mesh.surface.positions),
    );
    let diagnostic = Diagnostic::new(Kind::BadData, message).at(file.points[first].location.clone());
    let all_far = far.len() == file.points.len();
    Some(match unit_axes::detect(attacher, &positions) {
        Some(fitting) => {
            let hint = format!("they would fit {fitting}: export them in the unit and axes of the mesh");
            diagnostic.hint(hint).remedy(FIT_UNIT_AXES, "", "convert them with unit and axes fitted to the mesh")
        }
        None if all_far && positions.len() < MIN_POINTS => {
            diagnostic.hint(format!("were they picked on this {role}, in its place, and in its unit and axes?"))
        }
        None if all_far => {
            let question = format!("were they picked on this {role}, and in its place?");
            diagnostic.hint(format!("{question} no usual unit or exchange of axes makes them fit"))
        }
        None => diagnostic.hint("pick these points again on the surface, or remove them"),
    })
}
