//! Carrying markers to a mesh that was edited, by where their points were.

use nalgebra::{Point3, Vector3};

use super::{
    Entry, MarkerFile, Side,
    attach::{Attacher, FARTHEST, is_far, span},
    indices::{self, on_surface},
    resolve::SAME_PLACE,
    usual::{self, Usual},
};
use crate::{
    core::mesh::SurfacePoint,
    diagnostic::Kind,
    diagnostic::{Diagnostic, Diagnostics, Result},
};

/// Points that move farther than this, relative to the diagonal, are doubtful.
const DOUBTFUL: f64 = 0.01;
/// Points whose surface turns by more than this (its cosine) may have come to another side of a thin part.
const TURNED: f64 = 0.5;

/// What became of a point.
#[derive(Clone, Debug, PartialEq)]
pub struct Move {
    /// Its marker.
    pub name: String,
    /// Where it was.
    pub from: Point3<f64>,
    /// The point on the edited mesh.
    pub point: SurfacePoint,
    /// How far it moved, relative to the diagonal of the edited mesh.
    pub distance: f64,
    /// Why it is doubtful, if it is.
    pub doubt: Option<String>,
}

/// Moves the points of one side of `markers` to the mesh `new`: each to the vertex that lies where it was, else to the
/// closest place of the surface.
///
/// Where they were is told by the mesh `old`, or else by the positions in `markers`.
///
/// # Errors
///
/// If neither tells it of every point, or (unless `force`) points come to lie more than 5 % of the diagonal away.
pub fn reattach(markers: &mut MarkerFile, old: Option<Side<'_>>, new: Side<'_>, force: bool) -> Result<Vec<Move>> {
    let k = usize::from(new.name != "source");
    let attacher = Attacher::new(new)?;
    let before = old.map(Attacher::new).transpose()?;
    let origins = origins(markers, before.as_ref(), new.name)?;
    let mut moves = Vec::new();
    for (i, entry) in markers.entries.iter_mut().enumerate() {
        let (Some(point), Some(from)) = (entry.of(new.name), origins[i]) else { continue };
        let near = |p: &Point3<f64>| (p - from).norm() <= SAME_PLACE * attacher.diagonal;
        let kept = on_surface(new, point).is_ok() && near(&attacher.position(point));
        let found = if kept { point } else { attacher.attach(&from).point };
        let to = attacher.position(found);
        let distance = (to - from).norm() / attacher.diagonal;
        let turned = before.as_ref().is_some_and(|before| {
            let (a, b) = (normal(before.side, point), normal(new, found));
            a.norm() > 0.0 && b.norm() > 0.0 && a.dot(&b) < TURNED * a.norm() * b.norm()
        });
        let doubt = match (distance > DOUBTFUL, turned && !kept) {
            (true, _) => Some(format!("moved by {:.1} % of the diagonal", 100.0 * distance)),
            (false, true) => Some("the surface there faces another way".into()),
            (false, false) => None,
        };
        let name = entry.name.clone().unwrap_or_else(|| (i + 1).to_string());
        moves.push(Move { name, from, point: found, distance, doubt });
        entry.at[k] = Some(to);
        match new.name {
            "source" => entry.source = found,
            _ => entry.target = Some(found),
        }
    }
    match too_far(&moves, &attacher) {
        Some(diagnostic) if !force => Err(diagnostic.into()),
        _ => Ok(moves),
    }
}

/// Where the points of a side were; `None` for those that are still to be found.
fn origins(
    markers: &MarkerFile,
    before: Option<&Attacher<'_>>,
    side: &'static str,
) -> Result<Vec<Option<Point3<f64>>>> {
    let k = usize::from(side != "source");
    let Some(before) = before else {
        let unknown = |entry: &&Entry| entry.of(side).is_some() && entry.at[k].is_none();
        if let Some(entry) = markers.entries.iter().find(unknown) {
            let message = format!("the markers do not say where their points of the {side} were");
            let hint = format!("give the {side} that they were made on: `--old-{side} MESH`");
            return Err(Diagnostic { kind: Kind::Usage, ..entry.diagnostic(message) }.hint(hint).into());
        }
        return Ok(markers.entries.iter().map(|entry| entry.at[k].filter(|_| entry.of(side).is_some())).collect());
    };
    let given = |(i, entry): (usize, &Entry)| {
        let point = entry.of(side)?;
        Some(indices::Given { label: format!("marker {}", markers.name(i)), point, location: entry.location.clone() })
    };
    let given: Vec<_> = markers.entries.iter().enumerate().filter_map(given).collect();
    let diagnostics = indices::check(before.side, &given);
    if !diagnostics.is_empty() {
        return Err(Diagnostics { diagnostics });
    }
    Ok(markers.entries.iter().map(|entry| Some(before.position(entry.of(side)?))).collect())
}

/// The normal of a mesh at a point, of any length: of a vertex the mean of the triangles around it.
fn normal(side: Side<'_>, point: SurfacePoint) -> Vector3<f64> {
    let surface = side.surface;
    let of = |triangle: usize| {
        let [a, b, c] = surface.corners(&surface.positions, triangle);
        (b - a).cross(&(c - a))
    };
    match point {
        SurfacePoint::Triangle(triangle, _) => of(triangle as usize),
        SurfacePoint::Vertex(vertex) => {
            let vertex = surface.vertex_of[vertex as usize];
            let around = surface.triangles.iter().enumerate().filter(|(_, corners)| corners.contains(&vertex));
            around.map(|(triangle, _)| of(triangle)).sum()
        }
    }
}

/// That points are farther off the edited mesh than is right.
fn too_far(moves: &[Move], attacher: &Attacher<'_>) -> Option<Diagnostic> {
    let far: Vec<&Move> = moves.iter().filter(|moved| is_far(moved.distance)).collect();
    let first = far.first()?;
    let side = attacher.side.name;
    let positions: Vec<_> = moves.iter().map(|moved| moved.from).collect();
    let names: Vec<_> = far.iter().take(6).map(|moved| moved.name.as_str()).collect();
    let message = format!(
        "{} of {} points lie more than {} % of the diagonal off the edited {side}, {} by {:.1} %: {}; the points span {}, the \
         {side} {}",
        far.len(),
        moves.len(),
        100.0 * FARTHEST,
        first.name,
        100.0 * first.distance,
        names.join(", "),
        span(&positions),
        span(&attacher.side.surface.positions)
    );
    let hint = match usual::fitting(attacher, &positions).filter(|usual| *usual != Usual::NOTHING) {
        Some(fitting) => {
            format!("they would fit {fitting}: bring the edited mesh back to its old unit and axes for this")
        }
        None => "is it the same mesh, in the same place? `--force` carries them over all the same".into(),
    };
    Some(Diagnostic::new(Kind::BadData, message).hint(hint))
}
