//! From positions in space to points of a mesh.

use nalgebra::Point3;

use super::{
    Side, indices,
    points::{NamedPoint, PointFile, Spot},
    usual::{self, Usual},
};
use crate::{
    core::{
        mesh::{SurfacePoint, bounding_box},
        spatial::ClosestPoint,
    },
    diagnostic::Kind,
    diagnostic::{Diagnostic, Diagnostics, Result},
};

/// Points farther off the surface than this, relative to the diagonal, are refused.
pub const FARTHEST: f64 = 0.05;
/// Places nearer to a vertex than this, relative to the diagonal, are that vertex: files keep six digits or so.
const SNAP: f64 = 1e-5;

/// A point on a mesh for a position in space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Attached {
    /// A vertex or a triangle of the mesh.
    pub point: SurfacePoint,
    /// How far the position was off it, relative to the diagonal of the mesh.
    pub distance: f64,
}

/// Finds points of one mesh.
pub struct Attacher<'a> {
    /// The mesh.
    pub side: Side<'a>,
    closest: ClosestPoint,
    /// The diagonal of its bounding box.
    pub diagonal: f64,
}

impl<'a> Attacher<'a> {
    /// Prepares to search `side`.
    ///
    /// # Errors
    ///
    /// If it has no triangle.
    pub fn new(side: Side<'a>) -> Result<Self> {
        let closest = ClosestPoint::new(&side.surface.positions, &side.surface.triangles)?;
        Ok(Self { side, closest, diagonal: side.surface.diagonal().max(f64::MIN_POSITIVE) })
    }

    /// Where `point` of the mesh is.
    ///
    /// # Panics
    ///
    /// If the mesh has no such vertex or triangle.
    pub fn position(&self, point: SurfacePoint) -> Point3<f64> {
        match point {
            SurfacePoint::Vertex(vertex) => self.side.mesh.positions[vertex as usize],
            point => point.position(self.side.surface, &self.side.surface.positions),
        }
    }

    /// The place on the mesh that is nearest to `position`; a vertex where it lies on one.
    pub fn attach(&self, position: &Point3<f64>) -> Attached {
        let surface = self.side.surface;
        let Some(found) = self.closest.find(position, f64::INFINITY, |_| true) else {
            // Not reached by finite positions, since a surface has triangles.
            return Attached { point: SurfacePoint::Vertex(0), distance: f64::INFINITY };
        };
        let corners = surface.triangles[found.triangle as usize];
        let off = |corner: u32| (surface.positions[corner as usize] - found.point).norm();
        let nearest = corners.into_iter().min_by(|a, b| off(*a).total_cmp(&off(*b))).unwrap_or(corners[0]);
        let point = if off(nearest) <= SNAP * self.diagonal {
            SurfacePoint::Vertex(surface.representative[nearest as usize])
        } else {
            SurfacePoint::Triangle(found.triangle, found.barycentric)
        };
        Attached { point, distance: found.distance / self.diagonal }
    }

    /// The vertex of the mesh nearest to `point` among the corners of its triangle, and how far off it lies, relative to
    /// the diagonal.
    pub fn nearest_vertex(&self, point: SurfacePoint) -> (u32, f64) {
        let at = self.position(point);
        match point {
            SurfacePoint::Vertex(vertex) => (vertex, 0.0),
            SurfacePoint::Triangle(triangle, _) => {
                let surface = self.side.surface;
                let corners = surface.triangles[triangle as usize].map(|corner| {
                    (
                        surface.representative[corner as usize],
                        (surface.positions[corner as usize] - at).norm() / self.diagonal,
                    )
                });
                corners.into_iter().min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or(corners[0])
            }
        }
    }

    /// `point` as a place on a triangle: of a vertex, the first triangle around it.
    pub fn triangle(&self, point: SurfacePoint) -> (u32, [f64; 3]) {
        match point {
            SurfacePoint::Triangle(triangle, barycentric) => (triangle, barycentric),
            SurfacePoint::Vertex(vertex) => {
                let surface = self.side.surface;
                let vertex = surface.vertex_of[vertex as usize];
                let around = surface.triangles.iter().position(|corners| corners.contains(&vertex));
                match around {
                    Some(t) => (t as u32, surface.triangles[t].map(|corner| f64::from(u8::from(corner == vertex)))),
                    None => {
                        // A vertex without triangles: the nearest place that has one.
                        let found = self.closest.find(&surface.positions[vertex as usize], f64::INFINITY, |_| true);
                        found.map_or((0, [1.0, 0.0, 0.0]), |found| (found.triangle, found.barycentric))
                    }
                }
            }
        }
    }

    /// The vertex nearest to the mean of `vertices`, all of which exist.
    fn middle(&self, vertices: &[u32]) -> Attached {
        let positions = &self.side.mesh.positions;
        let sum: nalgebra::Vector3<f64> = vertices.iter().map(|&v| positions[v as usize].coords).sum();
        let mean = Point3::from(sum / vertices.len() as f64);
        let off = |v: u32| (positions[v as usize] - mean).norm();
        let nearest = vertices.iter().copied().min_by(|a, b| off(*a).total_cmp(&off(*b)).then(a.cmp(b))).unwrap_or(0);
        Attached { point: SurfacePoint::Vertex(nearest), distance: 0.0 }
    }
}

/// The points of `file` on the mesh, in order; `usual` is done first to those given by position.
///
/// # Errors
///
/// Every vertex and triangle that does not exist, and points that lie off the surface by more than [`FARTHEST`].
pub fn attach(file: &PointFile, attacher: &Attacher<'_>, usual: Usual) -> Result<Vec<Attached>> {
    let side = attacher.side;
    let mut given = Vec::new();
    for (i, point) in file.points.iter().enumerate() {
        let label = format!("point {}", label(i, point));
        let mut add =
            |point: SurfacePoint, location| given.push(indices::Given { label: label.clone(), point, location });
        let location = Some(point.location.clone());
        match &point.spot {
            Spot::Vertex(vertex) => add(SurfacePoint::Vertex(*vertex), location),
            Spot::Vertices(vertices) => vertices.iter().for_each(|v| add(SurfacePoint::Vertex(*v), location.clone())),
            Spot::Triangle(triangle, barycentric) => add(SurfacePoint::Triangle(*triangle, *barycentric), location),
            Spot::Position(_) => {}
        }
    }
    let mut diagnostics = indices::check(side, &given);
    if !diagnostics.is_empty() {
        return Err(Diagnostics { diagnostics });
    }
    let attached: Vec<Attached> = file
        .points
        .iter()
        .map(|point| match &point.spot {
            Spot::Vertex(vertex) => Attached { point: SurfacePoint::Vertex(*vertex), distance: 0.0 },
            Spot::Vertices(vertices) => attacher.middle(vertices),
            Spot::Triangle(triangle, coordinates) => {
                Attached { point: SurfacePoint::Triangle(*triangle, *coordinates), distance: 0.0 }
            }
            Spot::Position(position) => attacher.attach(&usual.apply(position)),
        })
        .collect();
    diagnostics.extend(far(file, attacher, &attached, usual));
    if diagnostics.is_empty() { Ok(attached) } else { Err(Diagnostics { diagnostics }) }
}

/// The points of `file` that are given by position.
pub fn positions(file: &PointFile) -> Vec<Point3<f64>> {
    let position = |point: &NamedPoint| if let Spot::Position(position) = point.spot { Some(position) } else { None };
    file.points.iter().filter_map(position).collect()
}

/// That points lie too far off the surface: one diagnostic for all, at the first.
fn far(file: &PointFile, attacher: &Attacher<'_>, attached: &[Attached], usual: Usual) -> Option<Diagnostic> {
    let far: Vec<usize> = (0..attached.len()).filter(|&i| is_far(attached[i].distance)).collect();
    let first = *far.first()?;
    let positions: Vec<_> = positions(file).iter().map(|position| usual.apply(position)).collect();
    let side = attacher.side.name;
    let also = match &far[1..] {
        [] => String::new(),
        others => {
            let names: Vec<_> = others.iter().take(4).map(|&i| label(i, &file.points[i])).collect();
            let more = if others.len() > names.len() { ", …" } else { "" };
            format!(", and {} more of {} lie off it too ({}{more})", others.len(), file.points.len(), names.join(", "))
        }
    };
    let message = format!(
        "point {} lies {} % of the diagonal off the {side}: expected {} % at most{also}; the points span {}, the {side} {}",
        label(first, &file.points[first]),
        short(100.0 * attached[first].distance),
        100.0 * FARTHEST,
        span(&positions),
        span(&attacher.side.surface.positions),
    );
    let hint = match usual::fitting(attacher, &positions) {
        Some(fitting) => format!(
            "they would fit {fitting}: export them in the unit and axes of the mesh, or let `mimesh markers convert --fit` do it"
        ),
        None if far.len() == file.points.len() => {
            format!(
                "were they picked on this {side}, and in its place? no usual unit or exchange of axes makes them fit"
            )
        }
        None => "pick these points again on the surface, or remove them".into(),
    };
    Some(Diagnostic::new(Kind::BadData, message).at(file.points[first].location.clone()).hint(hint))
}

/// Whether a distance, relative to the diagonal, is more than is right; one that is no number is.
pub(super) fn is_far(distance: f64) -> bool {
    distance.is_nan() || distance > FARTHEST
}

/// The name of a point in messages, or its number from 1.
pub fn label(i: usize, point: &NamedPoint) -> String {
    point.name.clone().unwrap_or_else(|| (i + 1).to_string())
}

/// The bounding box of `positions` in words.
pub fn span(positions: &[Point3<f64>]) -> String {
    let (low, high) = bounding_box(positions);
    let axis = |name: &str, k: usize| format!("{name} {} to {}", short(low[k]), short(high[k]));
    format!("{}, {}, {}", axis("x", 0), axis("y", 1), axis("z", 2))
}

/// A number with three digits or so.
fn short(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let magnitude = value.abs().log10().floor() as i32;
    if !(-5..9).contains(&magnitude) {
        return format!("{value:.2e}");
    }
    let digits = (2 - magnitude).clamp(0, 8) as usize;
    let text = format!("{value:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}
