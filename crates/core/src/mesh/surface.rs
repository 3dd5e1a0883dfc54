use std::{collections::HashMap, ops::Range};

use nalgebra::{Point3, Vector3};

use super::{
    Components, Mesh, Part, Topology,
    bounds::used_by_faces,
    diagonal,
    strays::Stray,
    weld::{self, Welding},
};
use crate::{Error, Result};

/// The surface that stages compute on: the triangles of a [`Mesh`], with seams welded.
///
/// Vertices and triangles are numbered from 0 in the order of the mesh; both maps back are kept. Every vertex belongs to a triangle:
/// vertices of the mesh that no face uses are [strays](Self::strays), which no stage sees.
#[derive(Clone, Debug)]
pub struct Surface {
    /// V, #V × 3, in the unit of the file.
    pub positions: Vec<Point3<f64>>,
    /// F, #F × 3, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// The polygon of the mesh that each triangle was cut from, #F.
    pub polygon_of: Vec<u32>,
    /// The vertex of the surface for each vertex of the mesh; `None` for a vertex that no face uses.
    pub vertex_of: Vec<Option<u32>>,
    /// The first vertex of the mesh for each vertex of the surface, #V.
    pub representative: Vec<u32>,
    /// The vertices of the mesh that no face uses, and how they follow the surface.
    pub strays: Vec<Stray>,
    /// Names of the mesh's parts: object, group or material, whichever comes first.
    pub part_names: Vec<String>,
    /// For each triangle its entry in `part_names`, #F; empty if no part has a name.
    pub part_of: Vec<u32>,
    /// Other names of parts, as groups and materials of what has an object's name, with their runs of triangles.
    pub other_names: Vec<(String, Vec<Range<u32>>)>,
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
        Self::welded(mesh, &Welding::default())
    }

    /// The surface of `mesh`, with its seams welded as `welding` says.
    ///
    /// # Errors
    ///
    /// The errors of [`Mesh::validate`], and [`Error::Data`] if the tolerance is larger than an edge, so that a triangle would
    /// lose a corner.
    pub fn welded(mesh: &Mesh, welding: &Welding) -> Result<Self> {
        mesh.validate()?;
        let (triangles, polygon_of) = mesh.polygons.fans();
        if triangles.is_empty() {
            return Err(Error::data(
                "empty mesh: no polygon has three corners",
                "give a mesh with at least one triangle",
            ));
        }
        let tolerance = if welding.tolerance > 0.0 { welding.tolerance * mesh.diagonal() } else { 0.0 };
        let first_of = weld::seams(&mesh.positions, &triangles, tolerance, &welding.opened);
        if tolerance > 0.0 {
            check_corners(mesh, &triangles, &first_of)?;
        }
        let (part_names, part_of) = parts(mesh, &polygon_of);
        let other_names = other_names(mesh, &polygon_of);
        Ok(Self {
            part_names,
            part_of,
            other_names,
            ..Self::numbered(&mesh.positions, triangles, polygon_of, &first_of)
        })
    }

    /// The surface of `triangles` over `positions` of a mesh, whose vertices are one with those that `first_of` names.
    fn numbered(of_mesh: &[Point3<f64>], mut triangles: Vec<[u32; 3]>, polygon_of: Vec<u32>, first_of: &[u32]) -> Self {
        let used = used_by_faces(of_mesh.len(), triangles.iter().map(|t| &t[..]));
        // Copies of a vertex are welded along edges of triangles, so that all of them are used.
        let mut number = vec![None; first_of.len()];
        let mut representative = Vec::new();
        for (vertex, &first) in first_of.iter().enumerate() {
            if first as usize == vertex && used[vertex] {
                number[vertex] = Some(representative.len() as u32);
                representative.push(first);
            }
        }
        let vertex_of: Vec<Option<u32>> = first_of.iter().map(|&first| number[first as usize]).collect();
        for corner in triangles.iter_mut().flatten() {
            *corner = vertex_of[*corner as usize].unwrap_or_default();
        }
        let positions: Vec<_> = representative.iter().map(|&v| of_mesh[v as usize]).collect();
        let strays = Stray::all(of_mesh, &vertex_of, &positions, &triangles);
        Self {
            positions,
            triangles,
            polygon_of,
            vertex_of,
            representative,
            strays,
            part_names: vec![],
            part_of: vec![],
            other_names: vec![],
        }
    }

    /// A surface of triangles that are used as they stand: nothing is welded, and vertices without a triangle are left out.
    ///
    /// # Errors
    ///
    /// The errors of [`Mesh::validate`].
    pub fn from_triangles(positions: Vec<Point3<f64>>, triangles: Vec<[u32; 3]>) -> Result<Self> {
        Mesh::from_triangles(positions.clone(), &triangles).validate()?;
        let all: Vec<u32> = (0..positions.len() as u32).collect();
        let polygon_of = (0..triangles.len() as u32).collect();
        Ok(Self::numbered(&positions, triangles, polygon_of, &all))
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

    /// The edges of triangles, each once, smaller vertex first, sorted.
    pub fn edges(&self) -> Vec<[u32; 2]> {
        super::topology::edges(&self.triangles)
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

    /// How many vertices of the mesh lie elsewhere than the first copy they are welded to, by more than `limit`, relative to the
    /// diagonal, when the mesh is at `positions`: seams that open in a pose, whose opening is lost.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] if `positions` does not have as many entries as the mesh has vertices.
    pub fn opened_seams(&self, positions: &[Point3<f64>], limit: f64) -> Result<usize> {
        Error::check_shape("vertices", self.vertex_of.len(), positions.len())?;
        let limit = limit * self.diagonal();
        let is_parted = |(p, v): (&Point3<f64>, &Option<u32>)| {
            v.is_some_and(|v| (p - positions[self.representative[v as usize] as usize]).norm() > limit)
        };
        Ok(positions.iter().zip(&self.vertex_of).filter(|&pair| is_parted(pair)).count())
    }

    /// Pairs of vertices at one place, where boundaries coincide and run in opposite directions: seams that were opened, sorted.
    pub fn unwelded_seams(&self) -> Vec<[u32; 2]> {
        let ends = weld::edges(&self.positions, &self.triangles, 0.0).into_iter().flatten();
        let mut pairs: Vec<[u32; 2]> = ends.filter(|[a, b]| a != b).collect();
        pairs.sort_unstable();
        pairs.dedup();
        pairs
    }

    /// Positions of the mesh from positions of the surface (#V): every copy of a vertex gets the same, and strays follow.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] if `positions` does not have #V entries.
    pub fn to_mesh(&self, positions: &[Point3<f64>]) -> Result<Vec<Point3<f64>>> {
        Error::check_shape("vertices (#V)", self.vertex_count(), positions.len())?;
        let mut of_mesh: Vec<_> =
            self.vertex_of.iter().map(|v| v.map_or_else(Point3::origin, |v| positions[v as usize])).collect();
        for stray in &self.strays {
            of_mesh[stray.vertex as usize] = stray.position(self.corners(positions, stray.triangle as usize));
        }
        Ok(of_mesh)
    }
}

/// Checks that welding leaves every triangle its corners, but those that lie at exactly one place.
fn check_corners(mesh: &Mesh, triangles: &[[u32; 3]], first_of: &[u32]) -> Result<()> {
    let at = |v: u32| mesh.positions[v as usize];
    let is_lost = |[a, b]: &[u32; 2]| first_of[*a as usize] == first_of[*b as usize] && at(*a) != at(*b);
    let lost = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).find(is_lost);
    let Some([a, b]) = lost else { return Ok(()) };
    Err(Error::data(
        format!(
            "the weld tolerance is larger than the edge between vertices {a} and {b} (from 0), which would become one"
        ),
        format!("set a smaller one; that edge is {:.1e} of the diagonal", (at(a) - at(b)).norm() / mesh.diagonal()),
    ))
}

/// The names of a part, the one that it is called by first.
fn names_of(part: &Part) -> impl Iterator<Item = &String> {
    part.object.iter().chain(&part.groups).chain(&part.material)
}

/// The distinct names that parts have besides those they are called by, with their runs of triangles.
fn other_names(mesh: &Mesh, polygon_of: &[u32]) -> Vec<(String, Vec<Range<u32>>)> {
    let mut others: Vec<(String, Vec<Range<u32>>)> = Vec::new();
    let mut numbers: HashMap<&str, usize> = HashMap::new();
    for part in &mesh.parts {
        let first = polygon_of.partition_point(|&p| (p as usize) < part.polygons.start) as u32;
        let end = polygon_of.partition_point(|&p| (p as usize) < part.polygons.end) as u32;
        for name in names_of(part).skip(1) {
            let number = *numbers.entry(name).or_insert(others.len());
            if number == others.len() {
                others.push((name.clone(), Vec::new()));
            }
            let runs = &mut others[number].1;
            match runs.last_mut() {
                Some(last) if last.end == first => last.end = end,
                _ => runs.push(first..end),
            }
        }
    }
    others
}

/// The distinct names of parts, and the one of each triangle.
fn parts(mesh: &Mesh, polygon_of: &[u32]) -> (Vec<String>, Vec<u32>) {
    let mut names: Vec<String> = Vec::new();
    let mut numbers: HashMap<&str, usize> = HashMap::new();
    let mut of_polygon = vec![0; mesh.polygons.len()];
    for part in &mesh.parts {
        let name = names_of(part).next().map_or("", String::as_str);
        let number = *numbers.entry(name).or_insert(names.len());
        if number == names.len() {
            names.push(name.into());
        }
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
    use crate::{
        mesh::MeshPoint,
        testkit::{meshes, random::Random},
    };

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

    /// `mesh` with strays before, between and behind its vertices, and for each of its vertices the new number.
    fn with_strays(mesh: &Mesh, strays: [Point3<f64>; 3]) -> (Mesh, Vec<u32>) {
        let half = mesh.positions.len() / 2;
        let (first, second) = mesh.positions.split_at(half);
        let positions = [&strays[..1], first, &strays[1..2], second, &strays[2..]].concat();
        let number: Vec<u32> = (0..mesh.positions.len()).map(|v| v as u32 + if v < half { 1 } else { 2 }).collect();
        let mut result = Mesh { positions, ..Mesh::default() };
        for corners in mesh.polygons.iter() {
            result.polygons.push(&corners.iter().map(|&v| number[v as usize]).collect::<Vec<_>>());
        }
        // A polygon of two corners is no face.
        result.polygons.push(&[0, half as u32 + 1]);
        (result, number)
    }

    #[test]
    fn vertices_that_no_face_uses_are_not_part_of_the_surface_and_follow_it() {
        let mesh = meshes::seamed_cylinder(8, 3);
        let alone = Surface::new(&mesh).unwrap();
        let far = [Point3::new(1e4, 0.0, 3.0), Point3::new(0.1, 0.2, 0.3), Point3::new(-5e3, 7.0, 0.0)];
        let (mesh_with, number) = with_strays(&mesh, far);
        let with = Surface::new(&mesh_with).unwrap();
        assert_eq!((&with.positions, &with.triangles), (&alone.positions, &alone.triangles));
        assert_eq!((with.diagonal(), mesh_with.diagonal()), (alone.diagonal(), mesh.diagonal()));
        assert_eq!(with.strays.iter().map(|stray| stray.vertex).collect::<Vec<_>>(), [0, 19, 38]);
        assert_eq!(with.point(MeshPoint::Vertex(19)), None);
        for (v, &new) in number.iter().enumerate() {
            assert_eq!(with.vertex_of[new as usize], alone.vertex_of[v]);
        }
        // A rigid motion of the surface takes them along, to rounding at coordinates of 1e4.
        let motion = Random::new(3).rigid_motion(2.0);
        let moved: Vec<_> = with.positions.iter().map(|p| motion * p).collect();
        for (p, q) in mesh_with.positions.iter().zip(with.to_mesh(&moved).unwrap()) {
            assert!((motion * p - q).norm() < 1e-9, "{p} {q}");
        }
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
        assert_eq!(surface.opened_seams(&back, 1e-6).unwrap(), 0);
        let mut opened = back;
        opened[4].z += 0.1;
        assert_eq!(surface.opened_seams(&opened, 1e-6).unwrap(), 1);
    }
}
