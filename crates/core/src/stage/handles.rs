//! Requirements on handles that every implementation of [`Weights`](super::Weights) shares. All refuse the same in the same
//! words.

use crate::{
    Error, Result,
    mesh::{Surface, SurfacePoint},
    operators::is_degenerate,
    spatial::Nearest,
};

/// The points that may become handles, each at a vertex of a surface.
#[derive(Clone, Debug)]
pub struct HandlePoints {
    vertices: Vec<u32>,
    /// The vertices as the mesh counts them.
    of_mesh: Vec<u32>,
}

impl HandlePoints {
    /// Takes each point to its vertex: the corner with the greatest barycentric coordinate, the first of equal ones.
    ///
    /// # Errors
    ///
    /// [`Error::Data`] for a point that is not on the surface.
    pub fn new(surface: &Surface, points: &[SurfacePoint]) -> Result<Self> {
        let vertex = |(k, point): (usize, &SurfacePoint)| {
            let (what, index, count) = match *point {
                SurfacePoint::Vertex(vertex) => ("vertex", vertex, surface.vertex_count()),
                SurfacePoint::Triangle(triangle, _) => ("triangle", triangle, surface.triangle_count()),
            };
            if index as usize >= count {
                return Err(Error::data(
                    format!("point {k}: the surface has no {what} {index}: expected 0 to {}", count - 1),
                    "give points of this mesh, counted from 0",
                ));
            }
            let corners = point.corners(surface);
            if corners.iter().any(|c| !c.1.is_finite()) {
                return Err(Error::data(
                    format!("point {k}: its barycentric coordinates on triangle {index} are not finite"),
                    "give three numbers that sum to 1",
                ));
            }
            let greatest = corners.iter().skip(1).fold(corners[0], |best, &c| if c.1 > best.1 { c } else { best });
            Ok(greatest.0)
        };
        let vertices = points.iter().enumerate().map(vertex).collect::<Result<Vec<_>>>()?;
        let of_mesh = vertices.iter().map(|&v| surface.representative[v as usize]).collect();
        Ok(Self { vertices, of_mesh })
    }

    /// The vertices of all points.
    pub fn all(&self) -> &[u32] {
        &self.vertices
    }

    /// The vertices of the points with these numbers.
    ///
    /// # Errors
    ///
    /// [`Error::Data`] if there is none, one does not exist, or two are the same or at the same vertex.
    pub fn choose(&self, handles: &[usize]) -> Result<Vec<u32>> {
        if handles.is_empty() {
            return Err(Error::data("no handle to give weights to", "give at least one point"));
        }
        if let Some(missing) = handles.iter().find(|&&h| h >= self.vertices.len()) {
            return Err(Error::data(
                format!("there is no point {missing}: {} were given", self.vertices.len()),
                "choose handles among the points, counted from 0",
            ));
        }
        let mut sorted: Vec<usize> = (0..handles.len()).collect();
        sorted.sort_by_key(|&k| (self.vertices[handles[k]], k));
        let same = sorted.windows(2).filter(|w| self.vertices[handles[w[0]]] == self.vertices[handles[w[1]]]);
        // The first handle that repeats an earlier one, whatever its vertex.
        if let Some(pair) = same.min_by_key(|w| w[1]) {
            let [a, b] = [handles[pair[0]], handles[pair[1]]];
            let message = if a == b {
                format!("point {a} is given twice as a handle")
            } else {
                format!("points {a} and {b} lie at the same vertex, {} (from 0)", self.of_mesh[a])
            };
            return Err(Error::data(
                message,
                "keep one of the two; points within a triangle lie at the corner they are nearest to",
            ));
        }
        Ok(handles.iter().map(|&h| self.vertices[h]).collect())
    }
}

/// The vertices that no handle reaches, each with the nearest one that is reached, whose weights it takes. Their triangles
/// have no area. `reached` says of each vertex (#V) whether a handle has influence on it.
///
/// # Errors
///
/// [`Error::Data`] that names the components with an area that no handle reaches.
pub fn unreached(surface: &Surface, reached: &[bool]) -> Result<Vec<[u32; 2]>> {
    Error::check_shape("vertices that handles reach (#V)", surface.vertex_count(), reached.len())?;
    let (with, without): (Vec<u32>, Vec<u32>) = (0..surface.vertex_count() as u32).partition(|&v| reached[v as usize]);
    if without.is_empty() {
        return Ok(vec![]);
    }
    let components = surface.components();
    let left_out = |t: &usize| !reached[surface.triangles[*t][0] as usize];
    let has_area = |t: &usize| !is_degenerate(&surface.corners(&surface.positions, *t));
    let mut missing: Vec<usize> = (0..surface.triangle_count())
        .filter(|t| left_out(t) && has_area(t))
        .filter_map(|t| components.of_vertex[surface.triangles[t][0] as usize].map(|c| c as usize))
        .collect();
    missing.sort_unstable();
    missing.dedup();
    if !missing.is_empty() {
        let what = if missing.len() == 1 { "component without a handle" } else { "components without a handle" };
        return Err(Error::data(
            format!("{what}: {}", surface.describe_components(&components, &missing)),
            "put a handle on each, or give `proximity`, so that weights pass between components that lie close",
        ));
    }
    let nearest = Nearest::new(&with.iter().map(|&v| surface.positions[v as usize]).collect::<Vec<_>>())?;
    let with_nearest = |v: u32| [v, with[nearest.find(&surface.positions[v as usize]).0 as usize]];
    Ok(without.into_iter().map(with_nearest).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testkit::meshes;

    #[test]
    fn a_point_within_a_triangle_lies_at_the_corner_it_is_nearest_to() {
        let surface = meshes::icosphere(1);
        let points = [SurfacePoint::Vertex(7), SurfacePoint::Triangle(3, [0.2, 0.3, 0.5])];
        let found = HandlePoints::new(&surface, &points).unwrap();
        assert_eq!(found.all(), [7, surface.triangles[3][2]]);
        assert_eq!(found.choose(&[1]).unwrap(), [surface.triangles[3][2]]);
    }

    #[test]
    fn vertices_without_area_follow_the_nearest_and_components_without_a_handle_are_named() {
        let Surface { mut positions, mut triangles, .. } = meshes::icosphere(1);
        let loose = positions.len();
        positions.push(nalgebra::Point3::new(0.0, 2.0, 0.0));
        triangles.push([loose as u32; 3]);
        let surface = Surface::from_triangles(positions, triangles).unwrap();
        let reached: Vec<bool> = (0..=loose).map(|v| v != loose).collect();
        let [[vertex, by]] = unreached(&surface, &reached).unwrap()[..] else { panic!("one vertex is loose") };
        let distance = |v: u32| (surface.positions[v as usize] - surface.positions[loose]).norm();
        assert!(vertex == loose as u32 && (0..loose as u32).all(|v| distance(by) <= distance(v)));

        let two = meshes::two_components();
        let first: Vec<bool> = (0..84).map(|v| v < 42).collect();
        let error = unreached(&two, &first).unwrap_err().to_string();
        assert_eq!(error, "component without a handle: (42 vertices, from vertex 42)");
    }
}
