//! Carrying markers to a mesh that was edited, by the former positions of their points.

use nalgebra::Point3;

use mimesh_core::mesh::MeshPoint;
use mimesh_document::{Diagnostic, Kind, Result};

use crate::{
    attacher::{Attacher, MAX_DISTANCE, is_too_far},
    indices::{check, indexed_points},
    mesh::{MarkerMesh, MeshRole, POSITION_TOLERANCE},
    model::MarkerFile,
    remedies::{FORCE_REATTACH, OLD_MESH},
    text::extent,
    unit_axes::{self, UnitAxes},
};

/// Points that move farther than this, relative to the diagonal, are doubtful.
const MAX_CERTAIN_MOVE: f64 = 0.01;
/// Points whose surface turns so that the cosine falls below this may have come to another side of a thin part.
const MIN_NORMAL_COSINE: f64 = 0.5;
/// Points named in a message about many of them.
const MAX_NAMED: usize = 6;

/// The move of a point.
#[derive(Clone, Debug, PartialEq)]
pub struct Move {
    /// The name of its marker.
    pub name: String,
    /// The position that the point had.
    pub from: Point3<f64>,
    /// The point on the edited mesh.
    pub point: MeshPoint,
    /// The distance that it moved, relative to the diagonal of the edited mesh.
    pub distance: f64,
    /// The reason why it is doubtful, if it is.
    pub doubt: Option<String>,
}

/// Moves the points of one side of `markers` to the edited mesh `new`: each to the vertex at its former position, else to the
/// closest place of the surface.
///
/// Former positions are those on the mesh `old`, or without it those that `markers` give.
///
/// # Errors
///
/// If a former position is not known, or (unless `force`) points come to lie more than 5 % of the diagonal away.
pub fn reattach(
    markers: &mut MarkerFile,
    old: Option<MarkerMesh<'_>>,
    new: MarkerMesh<'_>,
    force: bool,
) -> Result<Vec<Move>> {
    let role = new.role;
    let attacher = Attacher::new(new)?;
    let origins = match old {
        Some(old) => positions_on(markers, MarkerMesh { role, ..old })?,
        None => recorded_positions(markers, role)?,
    };
    let mut moves = Vec::new();
    for (i, origin) in origins.into_iter().enumerate() {
        let name = markers.name(i);
        let pair = &mut markers.pairs[i];
        let (Some(before), Some(from)) = (pair.point(role), origin) else { continue };
        let (point, to) = destination(&attacher, before, &from);
        let distance = (to - from).norm() / attacher.diagonal;
        let doubt = if distance > MAX_CERTAIN_MOVE {
            Some(format!("moved by {:.1} % of the diagonal", 100.0 * distance))
        } else if point != before && old.is_some_and(|old| turns(old, before, new, point)) {
            Some("the surface there faces another way".into())
        } else {
            None
        };
        pair.at[role.index()] = Some(to);
        match role {
            MeshRole::Source => pair.source = Some(point),
            MeshRole::Target => pair.target = Some(point),
        }
        moves.push(Move { name, from, point, distance, doubt });
    }
    match too_far(&moves, &attacher) {
        Some(diagnostic) if !force => Err(diagnostic.into()),
        _ => Ok(moves),
    }
}

/// The point of the edited mesh for a point that was at `from`, and its position: the same point if it is still there.
fn destination(attacher: &Attacher<'_>, point: MeshPoint, from: &Point3<f64>) -> (MeshPoint, Point3<f64>) {
    let mesh = attacher.mesh;
    match mesh.position(point) {
        Some(position) if (position - from).norm() <= POSITION_TOLERANCE * attacher.diagonal => (point, position),
        _ => {
            let found = attacher.attach(from).point;
            (found, mesh.position(found).unwrap_or(*from))
        }
    }
}

/// Whether the surface at `after` faces another way than it did at `before`.
fn turns(old: MarkerMesh<'_>, before: MeshPoint, new: MarkerMesh<'_>, after: MeshPoint) -> bool {
    let (a, b) = (old.normal(before), new.normal(after));
    a.norm() > 0.0 && b.norm() > 0.0 && a.dot(&b) < MIN_NORMAL_COSINE * a.norm() * b.norm()
}

/// The positions of the points on the mesh that they were made on; `None` for those that are still to be found.
fn positions_on(markers: &MarkerFile, old: MarkerMesh<'_>) -> Result<Vec<Option<Point3<f64>>>> {
    check(old, &indexed_points(markers, old.role)).into_result()?;
    Ok(markers.pairs.iter().map(|pair| old.position(pair.point(old.role)?)).collect())
}

/// The positions that the markers give; `None` for points that are still to be found.
fn recorded_positions(markers: &MarkerFile, role: MeshRole) -> Result<Vec<Option<Point3<f64>>>> {
    let k = role.index();
    if let Some(pair) = markers.pairs.iter().find(|pair| pair.point(role).is_some() && pair.at[k].is_none()) {
        let message = format!("the markers do not give the positions that their points of the {role} had");
        let words = format!("give the {role} that they were made on");
        let diagnostic = Diagnostic { kind: Kind::Usage, ..pair.diagnostic(message) };
        return Err(diagnostic.remedy(OLD_MESH, role.name(), words).into());
    }
    Ok(markers.pairs.iter().map(|pair| pair.at[k].filter(|_| pair.point(role).is_some())).collect())
}

/// The diagnostic of all points that lie too far off the edited mesh.
fn too_far(moves: &[Move], attacher: &Attacher<'_>) -> Option<Diagnostic> {
    let far: Vec<&Move> = moves.iter().filter(|moved| is_too_far(moved.distance)).collect();
    let first = far.first()?;
    let role = attacher.mesh.role;
    let positions: Vec<_> = moves.iter().map(|moved| moved.from).collect();
    let names: Vec<_> = far.iter().take(MAX_NAMED).map(|moved| moved.name.as_str()).collect();
    let message = format!(
        "{} of {} points lie more than {} % of the diagonal off the edited {role}, {} by {:.1} %: {}; the points span {}, the \
         {role} {}",
        far.len(),
        moves.len(),
        100.0 * MAX_DISTANCE,
        first.name,
        100.0 * first.distance,
        names.join(", "),
        extent(&positions),
        extent(&attacher.mesh.surface.positions)
    );
    let diagnostic = Diagnostic::new(Kind::BadData, message);
    let fitting = unit_axes::detect(attacher, &positions, false).filter(|unit_axes| *unit_axes != UnitAxes::IDENTITY);
    Some(match fitting {
        Some(fitting) => diagnostic
            .hint(format!("they would fit {fitting}: bring the edited mesh back to its old unit and axes for this")),
        None => {
            let diagnostic = diagnostic.hint("check that it is the same mesh, in the same place");
            diagnostic.remedy(FORCE_REATTACH, "", "carry them over all the same")
        }
    })
}
