//! The points that may become handles.

use mimesh_core::{
    Error, Result,
    mesh::{Surface, SurfacePoint},
};

/// Points of a surface, each at a vertex.
#[derive(Clone, Debug)]
pub struct Points {
    vertices: Vec<u32>,
    /// The vertices as the mesh counts them.
    of_mesh: Vec<u32>,
}

impl Points {
    /// Takes each point to its vertex: the corner with the greatest barycentric coordinate, the first of equal ones.
    ///
    /// # Errors
    ///
    /// [`Error::Data`] for a point that is not on the surface.
    pub fn new(surface: &Surface, points: &[SurfacePoint]) -> Result<Self> {
        let mut used = vec![false; surface.vertex_count()];
        surface.triangles.iter().flatten().for_each(|&v| used[v as usize] = true);
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
            if used[greatest.0 as usize] {
                return Ok(greatest.0);
            }
            Err(Error::data(
                format!("point {k}: vertex {index} belongs to no polygon"),
                "move the point to a vertex of the surface",
            ))
        };
        let vertices = points.iter().enumerate().map(vertex).collect::<Result<Vec<_>>>()?;
        let of_mesh = vertices.iter().map(|&v| surface.first_copy[v as usize]).collect();
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
