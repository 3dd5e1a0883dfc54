//! Numbers of vertices and triangles that a mesh does not have, and the likely reason.

use mimesh_core::mesh::MeshPoint;
use mimesh_document::{Diagnostic, Diagnostics, Kind, Location};

use crate::{
    mesh::{MarkerMesh, MeshRole},
    model::MarkerFile,
    remedies::FROM_ONE,
};

/// A point that is given by number.
#[derive(Clone, Debug)]
pub struct IndexedPoint {
    /// The name in messages, e.g. `marker 3`.
    pub label: String,
    /// The numbers.
    pub point: MeshPoint,
    /// The place in its file.
    pub location: Option<Location>,
}

impl IndexedPoint {
    fn diagnostic(&self, message: String) -> Diagnostic {
        Diagnostic { location: self.location.clone(), ..Diagnostic::new(Kind::BadData, message) }
    }

    fn vertex(&self) -> Option<usize> {
        match self.point {
            MeshPoint::Vertex(vertex) => Some(vertex as usize),
            MeshPoint::Triangle(..) => None,
        }
    }
}

/// The points of `markers` on the mesh `role`, those that are known.
pub fn indexed_points(markers: &MarkerFile, role: MeshRole) -> Vec<IndexedPoint> {
    let mut points = Vec::new();
    for (i, pair) in markers.pairs.iter().enumerate() {
        if let Some(point) = pair.point(role) {
            let label = format!("marker {}", markers.name(i));
            points.push(IndexedPoint { label, point, location: pair.location.clone() });
        }
    }
    points
}

/// Checks that `mesh` has all of `points`: one diagnostic if all wrong numbers have one cause, else one each.
pub fn check(mesh: MarkerMesh<'_>, points: &[IndexedPoint]) -> Diagnostics {
    let wrong: Vec<(&IndexedPoint, String)> =
        points.iter().filter_map(|point| Some((point, missing(mesh, point.point)?))).collect();
    let Some((first, message)) = wrong.first() else { return Diagnostics::default() };
    let (role, triangles) = (mesh.role, mesh.surface.triangle_count());
    let message = match wrong.len() {
        1 => format!("{}: {message}", first.label),
        count => format!("{}: {message}; so it is with {count} of {}", first.label, points.len()),
    };
    if count_from_one(mesh, points, &wrong) {
        let message = format!("{message}; none of them is vertex 0, so the numbers of the {role} seem to count from 1");
        let hint = format!("subtract 1 from each number of the {role}");
        let words = "convert the markers from numbers that count from 1";
        return Diagnostics::from(first.diagnostic(message).hint(hint).remedy(FROM_ONE, role.name(), words));
    }
    if are_triangles(points, &wrong, triangles) {
        let message =
            format!("{message}; all are below the number of its triangles, {triangles}, so they may be triangles");
        let hint = "give vertices, or in a .yaml places on triangles: `{ triangle: 12, barycentric: [0.2, 0.3, 0.5] }`";
        return Diagnostics::from(first.diagnostic(message).hint(hint));
    }
    let hint = "vertices and triangles count from 0; were source and target swapped, or has the mesh changed since?";
    let each = wrong.iter().map(|(point, message)| point.diagnostic(format!("{}: {message}", point.label)).hint(hint));
    Diagnostics { list: each.collect() }
}

/// In words that `mesh` has no such vertex or triangle, or no face uses the vertex; `None` if it is a point of the surface.
pub fn missing(mesh: MarkerMesh<'_>, point: MeshPoint) -> Option<String> {
    let (kind, index, count) = match point {
        MeshPoint::Vertex(vertex) => ("vertex", vertex, mesh.mesh.positions.len()),
        MeshPoint::Triangle(triangle, _) => ("triangle", triangle, mesh.surface.triangle_count()),
    };
    let last = count.saturating_sub(1);
    if index as usize >= count {
        return Some(format!("the {} has no {kind} {index}: expected 0 to {last}", mesh.role));
    }
    mesh.surface.point(point).is_none().then(|| format!("{kind} {index} of the {} belongs to no polygon", mesh.role))
}

/// Whether the only wrong vertex is the number of vertices, and vertex 0 never occurs.
fn count_from_one(mesh: MarkerMesh<'_>, points: &[IndexedPoint], wrong: &[(&IndexedPoint, String)]) -> bool {
    let count = mesh.mesh.positions.len();
    points.len() > 1
        && wrong.iter().all(|(point, _)| point.vertex() == Some(count))
        && points.iter().all(|point| point.vertex() != Some(0))
}

/// Whether all vertices, several of which are wrong, could be triangles.
fn are_triangles(points: &[IndexedPoint], wrong: &[(&IndexedPoint, String)], triangles: usize) -> bool {
    wrong.len() > 1
        && wrong.iter().all(|(point, _)| point.vertex().is_some())
        && points.iter().filter_map(IndexedPoint::vertex).all(|vertex| vertex < triangles)
}
