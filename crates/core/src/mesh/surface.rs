use nalgebra::{Point3, Vector3};

use super::{Components, Mesh, Part, Topology, diagonal, weld};
use crate::{Error, Result};

/// The surface that stages compute on: the triangles of a [`Mesh`], with seams welded.
///
/// Vertices and triangles are numbered from 0 in the order of the mesh; both maps back are kept.
#[derive(Clone, Debug)]
pub struct Surface {
    /// V, #V × 3, in the unit of the file.
    pub positions: Vec<Point3<f64>>,
    /// F, #F × 3, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// The polygon of the mesh that each triangle was cut from, #F.
    pub polygon_of: Vec<u32>,
    /// The vertex of the surface for each vertex of the mesh.
    pub vertex_of: Vec<u32>,
    /// The first vertex of the mesh for each vertex of the surface, #V.
    pub representative: Vec<u32>,
    /// Names of the mesh's parts: object, group or material, whichever comes first.
    pub part_names: Vec<String>,
    /// For each triangle its entry in `part_names`, #F; empty if no part has a name.
    pub part_of: Vec<u32>,
    /// Other names of parts, as groups and materials of what has an object's name, with their triangles.
    pub other_names: Vec<(String, Vec<u32>)>,
}

impl Surface {
    /// The surface of `mesh`: polygons fanned from their first corner, seams welded.
    ///
    /// Vertices are welded where two boundaries coincide exactly and run in opposite directions.
    ///
    /// # Errors
    ///
    /// The errors of [`Mesh::validate`].
    pub fn new(mesh: &Mesh) -> Result<Self> {
        mesh.validate()?;
        let mut triangles = Vec::new();
        let mut polygon_of = Vec::new();
        for (polygon, corners) in mesh.polygons.iter().enumerate() {
            for pair in corners.get(1..).unwrap_or_default().windows(2) {
                triangles.push([corners[0], pair[0], pair[1]]);
                polygon_of.push(polygon as u32);
            }
        }
        if triangles.is_empty() {
            return Err(Error::data(
                "empty mesh: no polygon has three corners",
                "give a mesh with at least one triangle",
            ));
        }
        let first_of = weld::seams(&mesh.positions, &triangles);
        let mut number = vec![0; first_of.len()];
        let mut representative = Vec::new();
        for (vertex, &first) in first_of.iter().enumerate() {
            if first as usize == vertex {
                number[vertex] = representative.len() as u32;
                representative.push(first);
            }
        }
        let vertex_of: Vec<u32> = first_of.iter().map(|&first| number[first as usize]).collect();
        for corner in triangles.iter_mut().flatten() {
            *corner = vertex_of[*corner as usize];
        }
        let positions = representative.iter().map(|&v| mesh.positions[v as usize]).collect();
        let (part_names, part_of) = parts(mesh, &polygon_of);
        let other_names = other_names(mesh, &polygon_of);
        Ok(Self { positions, triangles, polygon_of, vertex_of, representative, part_names, part_of, other_names })
    }

    /// A surface of triangles that are used as they stand.
    ///
    /// # Errors
    ///
    /// The errors of [`Mesh::validate`].
    pub fn from_triangles(positions: Vec<Point3<f64>>, triangles: Vec<[u32; 3]>) -> Result<Self> {
        Mesh::from_triangles(positions.clone(), &triangles).validate()?;
        let all: Vec<u32> = (0..positions.len() as u32).collect();
        let polygon_of = (0..triangles.len() as u32).collect();
        Ok(Self {
            positions,
            triangles,
            polygon_of,
            vertex_of: all.clone(),
            representative: all,
            part_names: vec![],
            part_of: vec![],
            other_names: vec![],
        })
    }

    /// #V.
    pub fn vertex_count(&self) -> usize {
        self.positions.len()
    }

    /// #F.
    pub fn triangle_count(&self) -> usize {
        self.triangles.len()
    }

    /// Length of the diagonal of the bounding box.
    pub fn diagonal(&self) -> f64 {
        diagonal(&self.positions)
    }

    /// The edges and vertices at which triangles meet.
    pub fn topology(&self) -> Topology {
        Topology::new(&self.triangles)
    }

    /// The connected components.
    pub fn components(&self) -> Components {
        Components::new(self.vertex_count(), &self.triangles)
    }

    /// The components numbered `which` in words: names of their parts, number of vertices, a vertex of the mesh; ten at most.
    pub fn describe_components(&self, components: &Components, which: &[usize]) -> String {
        let mut words: Vec<String> = which
            .iter()
            .take(10)
            .map(|&c| {
                let is_in = |v: u32| components.of_vertex[v as usize] == Some(c as u32);
                let first = components.of_vertex.iter().position(|of| *of == Some(c as u32)).unwrap_or(0);
                let triangle = self.triangles.iter().position(|t| is_in(t[0])).unwrap_or(0);
                let name = self
                    .part_of
                    .get(triangle)
                    .map_or_else(String::new, |&p| format!("{} ", self.part_names[p as usize]));
                format!("{name}({} vertices, from vertex {})", components.sizes[c], self.representative[first])
            })
            .collect();
        if which.len() > words.len() {
            words.push(format!("and {} more", which.len() - words.len()));
        }
        words.join(", ")
    }

    /// Turns the triangles of the components numbered `which` the other way round.
    pub fn turn_components(&mut self, which: &[u32]) {
        let components = self.components();
        let is_turned = |t: &&mut [u32; 3]| components.of_vertex[t[0] as usize].is_some_and(|c| which.contains(&c));
        self.triangles.iter_mut().filter(is_turned).for_each(|t| t.swap(1, 2));
    }

    /// The mirror image on the other side of the plane through the origin across `axis` (0 to 2), its triangles outwards as before.
    pub fn mirrored(&self, axis: usize) -> Self {
        let mut image = self.clone();
        image.positions.iter_mut().for_each(|p| p[axis] = -p[axis]);
        image.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        image
    }

    /// The corners of triangle `triangle` when the vertices are at `positions`.
    pub fn corners(&self, positions: &[Point3<f64>], triangle: usize) -> [Point3<f64>; 3] {
        self.triangles[triangle].map(|v| positions[v as usize])
    }

    /// The triangles around each vertex, #V lists in ascending order; a triangle with a repeated corner is listed twice there.
    pub fn triangles_around(&self) -> Vec<Vec<u32>> {
        let mut around = vec![Vec::new(); self.vertex_count()];
        for (t, corners) in self.triangles.iter().enumerate() {
            corners.iter().for_each(|&v| around[v as usize].push(t as u32));
        }
        around
    }

    /// Twice the area of each triangle times its unit normal, #F × 3, when the vertices are at `positions`.
    pub fn area_normals(&self, positions: &[Point3<f64>]) -> Vec<Vector3<f64>> {
        self.triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|v| positions[v as usize]);
                (b - a).cross(&(c - a))
            })
            .collect()
    }

    /// Barycentre of each triangle, #F × 3, when the vertices are at `positions`.
    pub fn barycentres(&self, positions: &[Point3<f64>]) -> Vec<Point3<f64>> {
        self.triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|v| positions[v as usize].coords);
                Point3::from((a + b + c) / 3.0)
            })
            .collect()
    }

    /// Positions of the surface (#V) from positions of the mesh: those of each vertex's first copy.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] if `positions` does not have as many entries as the mesh has vertices.
    pub fn from_mesh(&self, positions: &[Point3<f64>]) -> Result<Vec<Point3<f64>>> {
        Error::check_shape("vertices", self.vertex_of.len(), positions.len())?;
        Ok(self.representative.iter().map(|&v| positions[v as usize]).collect())
    }

    /// How many vertices of the mesh lie elsewhere than the first copy they are welded to, by more than 1e-6 of the diagonal,
    /// when the mesh is at `positions`: seams that open in a pose, whose opening is lost.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] if `positions` does not have as many entries as the mesh has vertices.
    pub fn opened_seams(&self, positions: &[Point3<f64>]) -> Result<usize> {
        Error::check_shape("vertices", self.vertex_of.len(), positions.len())?;
        let limit = 1e-6 * self.diagonal();
        let parted =
            |(p, &v): (&Point3<f64>, &u32)| (p - positions[self.representative[v as usize] as usize]).norm() > limit;
        Ok(positions.iter().zip(&self.vertex_of).filter(|&pair| parted(pair)).count())
    }

    /// Positions of the mesh from positions of the surface (#V): every copy of a vertex gets the same.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] if `positions` does not have #V entries.
    pub fn to_mesh(&self, positions: &[Point3<f64>]) -> Result<Vec<Point3<f64>>> {
        Error::check_shape("vertices (#V)", self.vertex_count(), positions.len())?;
        Ok(self.vertex_of.iter().map(|&v| positions[v as usize]).collect())
    }
}

/// The names of a part, the one that it is called by first.
fn names_of(part: &Part) -> impl Iterator<Item = &String> {
    part.object.iter().chain(&part.groups).chain(&part.material)
}

/// The distinct names that parts have besides those they are called by, with their triangles.
fn other_names(mesh: &Mesh, polygon_of: &[u32]) -> Vec<(String, Vec<u32>)> {
    let mut others: Vec<(String, Vec<u32>)> = Vec::new();
    for part in &mesh.parts {
        let first = polygon_of.partition_point(|&p| (p as usize) < part.polygons.start) as u32;
        let end = polygon_of.partition_point(|&p| (p as usize) < part.polygons.end) as u32;
        for name in names_of(part).skip(1) {
            match others.iter_mut().find(|(other, _)| other == name) {
                Some((_, triangles)) => triangles.extend(first..end),
                None => others.push((name.clone(), (first..end).collect())),
            }
        }
    }
    others
}

/// The distinct names of parts, and the one of each triangle.
fn parts(mesh: &Mesh, polygon_of: &[u32]) -> (Vec<String>, Vec<u32>) {
    let mut names: Vec<String> = Vec::new();
    let mut of_polygon = vec![0; mesh.polygons.len()];
    for part in &mesh.parts {
        let name = names_of(part).next().cloned().unwrap_or_default();
        let number = names.iter().position(|n| *n == name).unwrap_or_else(|| {
            names.push(name);
            names.len() - 1
        });
        of_polygon[part.polygons.clone()].fill(number as u32);
    }
    if names.iter().all(String::is_empty) {
        return (vec![], vec![]);
    }
    let of_triangle = polygon_of.iter().map(|&p| of_polygon[p as usize]).collect();
    (names, of_triangle)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polygons_are_fanned_from_their_first_corner() {
        let p = |x: f64, y: f64| Point3::new(x, y, 0.0);
        let mut mesh =
            Mesh { positions: vec![p(0., 0.), p(1., 0.), p(2., 1.), p(1., 2.), p(0., 1.)], ..Mesh::default() };
        mesh.polygons.push(&[2, 3, 4, 0, 1]);
        let surface = Surface::new(&mesh).unwrap();
        assert_eq!(surface.triangles, [[2, 3, 4], [2, 4, 0], [2, 0, 1]]);
        assert_eq!(surface.polygon_of, [0, 0, 0]);
    }

    #[test]
    fn results_go_back_to_every_copy_of_a_welded_vertex() {
        let p = |x: f64, y: f64| Point3::new(x, y, 0.0);
        let mesh = Mesh::from_triangles(
            vec![p(0., 0.), p(1., 0.), p(0., 1.), p(0., 1.), p(1., 0.), p(1., 1.)],
            &[[0, 1, 2], [3, 4, 5]],
        );
        let surface = Surface::new(&mesh).unwrap();
        assert_eq!(surface.vertex_count(), 4);
        let moved: Vec<_> = surface.positions.iter().map(|p| p + Vector3::z()).collect();
        let back = surface.to_mesh(&moved).unwrap();
        assert_eq!(back, mesh.positions.iter().map(|p| p + Vector3::z()).collect::<Vec<_>>());
        assert_eq!(surface.from_mesh(&back).unwrap(), moved);
        assert_eq!(surface.opened_seams(&back).unwrap(), 0);
        let mut opened = back;
        opened[4].z += 0.1;
        assert_eq!(surface.opened_seams(&opened).unwrap(), 1);
    }
}
