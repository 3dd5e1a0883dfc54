//! Vertices and triangles that a mesh does not have, and what they tell about how the numbers were made.

use super::Side;
use crate::{
    core::mesh::SurfacePoint,
    diagnostic::Kind,
    diagnostic::{Diagnostic, Location},
};

/// A point given by number.
#[derive(Clone, Debug)]
pub(super) struct Given {
    /// Its name in messages, e.g. `marker 3`.
    pub label: String,
    /// The numbers.
    pub point: SurfacePoint,
    /// Where it stands.
    pub location: Option<Location>,
}

impl Given {
    fn diagnostic(&self, message: String) -> Diagnostic {
        let diagnostic = Diagnostic::new(Kind::BadData, message);
        match &self.location {
            Some(location) => diagnostic.at(location.clone()),
            None => diagnostic,
        }
    }
}

/// What is wrong with the numbers of `points` on the mesh `side`: one diagnostic if all have one cause, else one each.
pub(super) fn check(side: Side<'_>, points: &[Given]) -> Vec<Diagnostic> {
    let wrong: Vec<(&Given, String)> =
        points.iter().filter_map(|given| Some((given, on_surface(side, given.point).err()?))).collect();
    let Some((first, told)) = wrong.first() else { return vec![] };
    let name = side.name;
    let count = side.mesh.positions.len();
    let so_with =
        if wrong.len() > 1 { format!("; so it is with {} of {}", wrong.len(), points.len()) } else { String::new() };
    let vertex =
        |given: &Given| if let SurfacePoint::Vertex(vertex) = given.point { Some(vertex as usize) } else { None };
    let vertices = || points.iter().filter_map(vertex);
    if points.len() > 1 && wrong.iter().all(|(given, _)| vertex(given) == Some(count)) && vertices().all(|v| v != 0) {
        let message = format!(
            "{}: {told}{so_with}; none of them is vertex 0, so the numbers of the {name} seem to count from 1",
            first.label
        );
        let hint = format!(
            "subtract 1 from each number of the {name}, or let `mimesh markers convert --from-one {name}` do it"
        );
        return vec![first.diagnostic(message).hint(hint)];
    }
    let triangles = side.surface.triangle_count();
    if wrong.len() > 1 && wrong.iter().all(|(given, _)| vertex(given).is_some()) && vertices().all(|v| v < triangles) {
        let message = format!(
            "{}: {told}{so_with}; all are below the number of its triangles, {triangles}, so they may be triangles",
            first.label
        );
        let hint = "give vertices, or in a .yaml places on triangles: `{ triangle: 12, barycentric: [0.2, 0.3, 0.5] }`";
        return vec![first.diagnostic(message).hint(hint)];
    }
    let hint = "vertices and triangles count from 0; were source and target swapped, or has the mesh changed since?";
    wrong.into_iter().map(|(given, told)| given.diagnostic(format!("{}: {told}", given.label)).hint(hint)).collect()
}

/// The point of the surface for a point of the mesh.
///
/// # Errors
///
/// That the mesh has no such vertex or triangle, in words.
pub(super) fn on_surface(side: Side<'_>, point: SurfacePoint) -> std::result::Result<SurfacePoint, String> {
    let check = |what: &str, index: u32, count: usize| {
        let last = count.saturating_sub(1);
        if (index as usize) < count {
            Ok(())
        } else {
            Err(format!("the {} has no {what} {index}: expected 0 to {last}", side.name))
        }
    };
    match point {
        SurfacePoint::Vertex(vertex) => {
            check("vertex", vertex, side.mesh.positions.len())?;
            Ok(SurfacePoint::Vertex(side.surface.vertex_of[vertex as usize]))
        }
        SurfacePoint::Triangle(triangle, _) => {
            check("triangle", triangle, side.surface.triangle_count())?;
            Ok(point)
        }
    }
}
