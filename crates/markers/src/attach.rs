//! The points of a file on their mesh.

use mimesh_core::mesh::MeshPoint;
use mimesh_document::{Diagnostic, Kind, Result};

use crate::{
    attacher::{Attached, Attacher, MAX_DISTANCE, is_too_far},
    indices::{self, IndexedPoint},
    points::{NamedPoint, PointFile, PointPosition},
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
    let in_space = |point: &NamedPoint| Some(attacher.attach(&unit_axes.apply(&point.in_space()?)));
    let in_space: Vec<Option<Attached>> = file.points.iter().map(in_space).collect();
    let mut diagnostics = indices::check(attacher.mesh, &indexed_points(file));
    diagnostics.list.extend(too_far(file, attacher, &in_space, unit_axes));
    diagnostics.into_result()?;
    let attach = |(point, in_space): (&NamedPoint, Option<Attached>)| match (&point.position, in_space) {
        (_, Some(attached)) => attached,
        (PointPosition::OnMesh(point), _) => Attached::on_surface(*point),
        (PointPosition::MeanOfVertices(vertices), _) => attacher.nearest_to_mean(vertices),
        // Not reached, since what is given in space has been attached.
        (PointPosition::InSpace(position), None) => attacher.attach(&unit_axes.apply(position)),
    };
    Ok(file.points.iter().zip(in_space).map(attach).collect())
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

/// The diagnostic of all points given in space that lie too far off the surface, at the first of them.
fn too_far(
    file: &PointFile,
    attacher: &Attacher<'_>,
    attached: &[Option<Attached>],
    unit_axes: UnitAxes,
) -> Option<Diagnostic> {
    let distance = |i: usize| attached[i].map_or(0.0, |attached| attached.distance);
    let far: Vec<usize> = (0..attached.len()).filter(|&i| is_too_far(distance(i))).collect();
    let (&first, others) = far.split_first()?;
    let given = file.positions_in_space();
    let positions: Vec<_> = given.iter().map(|position| unit_axes.apply(position)).collect();
    let role = attacher.mesh.role;
    let also = if others.is_empty() {
        String::new()
    } else {
        let names = named(file, others);
        format!(", and {} more of {} lie off it too ({names})", others.len(), file.points.len())
    };
    let message = format!(
        "point {} lies {} % of the diagonal off the {role}: expected {} % at most{also}; the points span {}, the {role} {}",
        file.name(first),
        rounded(100.0 * distance(first)),
        100.0 * MAX_DISTANCE,
        extent(&positions),
        extent(&attacher.mesh.surface.positions),
    );
    let diagnostic = Diagnostic::new(Kind::BadData, message).at(file.points[first].location.clone());
    let mostly_far = 2 * far.len() > positions.len();
    let detected = unit_axes::detect(attacher, &given, file.anatomy.is_some()).filter(|found| *found != unit_axes);
    Some(match detected {
        Some(fitting) => {
            let strays = strays(file, attacher, fitting);
            let hint = match &strays[..] {
                [] => format!("they would fit {fitting}: export them in the unit and axes of the mesh"),
                strays => format!(
                    "all but {} would fit {fitting}: export them in the unit and axes of the mesh; pick {} again on the surface, \
                     or remove {}",
                    named(file, strays),
                    if strays.len() == 1 { "that point" } else { "those" },
                    if strays.len() == 1 { "it" } else { "them" },
                ),
            };
            diagnostic.hint(hint).remedy(FIT_UNIT_AXES, "", "convert them with unit and axes fitted to the mesh")
        }
        None if mostly_far && positions.len() < MIN_POINTS => {
            diagnostic.hint(format!("were they picked on this {role}, in its place, and in its unit and axes?"))
        }
        None if mostly_far => {
            let question = format!("were they picked on this {role}, and in its place?");
            diagnostic.hint(format!("{question} no usual unit or exchange of axes makes them fit"))
        }
        None => diagnostic.hint("pick these points again on the surface, or remove them"),
    })
}

/// The points, by number, that lie too far off the surface under `unit_axes`.
fn strays(file: &PointFile, attacher: &Attacher<'_>, unit_axes: UnitAxes) -> Vec<usize> {
    let is_stray = |i: &usize| {
        let position = file.points[*i].in_space();
        position.is_some_and(|position| is_too_far(attacher.attach(&unit_axes.apply(&position)).distance))
    };
    (0..file.points.len()).filter(is_stray).collect()
}

/// The names of `points`, by number, as far as there is room for them.
fn named(file: &PointFile, points: &[usize]) -> String {
    let names: Vec<_> = points.iter().take(MAX_NAMED).map(|&i| file.name(i)).collect();
    let more = if points.len() > names.len() { ", …" } else { "" };
    format!("{}{more}", names.join(", "))
}
