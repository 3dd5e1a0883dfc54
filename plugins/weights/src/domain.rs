//! The domain of weights: the parts of a surface that influence passes through, with their Laplacian and mass.

use mimesh_core::{
    Error, Figures, Result,
    linalg::Assembly,
    mesh::{Components, Surface},
    operators::{cotangent_laplacian, is_degenerate, relative_height, voronoi_mass},
    spatial::Nearest,
    stage::ProximityGraph,
};
use nalgebra::Point3;
use nalgebra_sparse::CscMatrix;
use petgraph::unionfind::UnionFind;

/// A triangle counts with at least this height over its longest edge, relative to that edge: cotangents stay below the inverse,
/// beyond which the bilaplacian has no digits left. Sound triangles are far above.
const MIN_HEIGHT: f64 = 1e-3;

/// A vertex has at least this part of the mean mass of its group. One whose triangles are points would have none, and its row of
/// M⁻¹ no value.
const MIN_MASS: f64 = 1e-6;

/// The weight of an edge over a triangle that is a point or has a corner twice: about that between equilateral triangles.
const DEGENERATE_EDGE_WEIGHT: f64 = 0.5;

/// The most that the stiffness of a link multiplies its bridges by: enough to hold both ends together to 1 %.
const MAX_STIFFNESS: f64 = 100.0;

/// A surface divided into groups of vertices between which no influence passes.
#[derive(Debug)]
pub struct Domain {
    /// The surface.
    pub surface: Surface,
    /// The groups.
    pub groups: Vec<Group>,
    /// Group of each vertex and its number in there, #V; `None` for vertices without a triangle.
    pub place: Vec<Option<(u32, u32)>>,
    /// Pairs of vertices that are bridged.
    pub bridges: Vec<[u32; 2]>,
    ties: usize,
    components: Components,
}

/// Vertices among which influence passes: a component, or several that are bridged.
#[derive(Debug)]
pub struct Group {
    /// Its vertices in ascending order.
    pub vertices: Vec<u32>,
    /// L of these vertices, its lower triangle; without unit.
    pub laplacian: CscMatrix<f64>,
    /// The diagonal of M over `mean_mass`, at least [`MIN_MASS`].
    pub mass: Vec<f64>,
    /// The mean of M, an area; 1 if there is none.
    pub mean_mass: f64,
    has_area: bool,
}

impl Domain {
    /// Divides `surface`; components that `proximity` links are joined by an edge of weight `bridge` × the stiffness of the link
    /// at each pair, in units of the median cotangent weight of the surface.
    pub fn new(surface: &Surface, proximity: Option<&ProximityGraph>, bridge: f64) -> Result<Self> {
        proximity.map_or(Ok(()), |graph| graph.check(surface))?;
        let n = surface.vertex_count();
        let Shapes { laplacian, mass, ties, has_area } = shapes(surface);
        let mut edges: Vec<(usize, usize, f64)> =
            ties.iter().map(|&[a, b]| (a as usize, b as usize, DEGENERATE_EDGE_WEIGHT)).collect();
        let mut bridges = Vec::new();
        if bridge > 0.0 {
            let unit = bridge * median_weight(&laplacian);
            for link in proximity.into_iter().flat_map(ProximityGraph::links) {
                let weight = unit * link.stiffness.clamp(0.0, MAX_STIFFNESS);
                edges.extend(link.pairs.iter().map(|&[a, b]| (a as usize, b as usize, weight)));
                bridges.extend(&link.pairs);
            }
        }
        let mut sets = UnionFind::<usize>::new(n);
        let mut used = vec![false; n];
        for &[a, b, c] in &surface.triangles {
            sets.union(a as usize, b as usize);
            sets.union(b as usize, c as usize);
            [a, b, c].into_iter().for_each(|v| used[v as usize] = true);
        }
        edges.retain(|&(a, b, _)| used[a] && used[b]);
        edges.iter().for_each(|&(a, b, _)| _ = sets.union(a, b));

        let mut number = vec![None; n];
        let mut vertices: Vec<Vec<u32>> = Vec::new();
        let mut place = vec![None; n];
        for v in (0..n).filter(|&v| used[v]) {
            let group = *number[sets.find_mut(v)].get_or_insert_with(|| {
                vertices.push(vec![]);
                vertices.len() - 1
            });
            place[v] = Some((group as u32, vertices[group].len() as u32));
            vertices[group].push(v as u32);
        }
        let mut assemblies: Vec<_> = vertices.iter().map(|v| Assembly::new(v.len())).collect();
        let at = |v: usize| place[v].map_or((0, 0), |(group, local): (u32, u32)| (group as usize, local as usize));
        for (i, j, &value) in laplacian.triplet_iter().filter(|(i, _, _)| used[*i]) {
            assemblies[at(i).0].add(at(i).1, at(j).1, value);
        }
        for &(a, b, weight) in &edges {
            assemblies[at(a).0].add_outer(&[at(a).1 as u32, at(b).1 as u32], &[[1.0], [-1.0]], weight);
        }
        let groups = vertices.into_iter().zip(assemblies).map(|(vertices, assembly)| {
            let sum: f64 = vertices.iter().map(|&v| mass[v as usize]).sum();
            let mean_mass = if sum > 0.0 { sum / vertices.len() as f64 } else { 1.0 };
            let relative = vertices.iter().map(|&v| (mass[v as usize] / mean_mass).max(MIN_MASS)).collect();
            let has_area = vertices.iter().any(|&v| has_area[v as usize]);
            Group { laplacian: assembly.finish(), mass: relative, mean_mass, has_area, vertices }
        });
        let groups = groups.collect();
        Ok(Self {
            groups,
            place,
            bridges,
            ties: ties.len(),
            components: surface.components(),
            surface: surface.clone(),
        })
    }

    /// The handles of each group, as numbers among `vertices`, which lists the vertex of each handle. They are sorted by vertex, so
    /// that results do not depend on the order they were given in.
    ///
    /// # Errors
    ///
    /// [`Error::Data`] that names components with an area that no handle reaches.
    pub fn by_group(&self, vertices: &[u32]) -> Result<Vec<Vec<usize>>> {
        let mut handles = vec![Vec::new(); self.groups.len()];
        for (handle, &v) in vertices.iter().enumerate() {
            if let Some((group, _)) = self.place[v as usize] {
                handles[group as usize].push(handle);
            }
        }
        handles.iter_mut().for_each(|own| own.sort_by_key(|&handle| vertices[handle]));
        let left_out = |c: &usize| {
            let first = self.components.of_vertex.iter().position(|of| *of == Some(*c as u32));
            let group = first.and_then(|v| self.place[v]).map_or(0, |(group, _)| group as usize);
            handles[group].is_empty() && self.groups[group].has_area
        };
        let missing: Vec<usize> = (0..self.components.count()).filter(left_out).collect();
        if missing.is_empty() {
            return Ok(handles);
        }
        let what = if missing.len() == 1 { "component without a handle" } else { "components without a handle" };
        Err(Error::data(
            format!("{what}: {}", self.surface.describe_components(&self.components, &missing)),
            "put a handle on each, or give `proximity`, so that weights pass between components that lie close",
        ))
    }

    /// The report on the domain.
    pub fn figures(&self) -> Figures {
        let mut figures = Figures::default();
        figures.set("separate_groups_of_vertices", self.groups.len());
        figures.set("bridges", self.bridges.len());
        figures.set("ties_over_triangles_without_area", self.ties);
        figures
    }

    /// Vertices that no handle reaches, since they have no triangle or only such without area, each with the nearest vertex of a
    /// group that has handles.
    pub fn unreached(&self, handles: &[Vec<usize>]) -> Result<Vec<[u32; 2]>> {
        let is_reached =
            |v: &u32| self.place[*v as usize].is_some_and(|(group, _)| !handles[group as usize].is_empty());
        let (reached, left): (Vec<u32>, Vec<u32>) = (0..self.place.len() as u32).partition(is_reached);
        if left.is_empty() {
            return Ok(vec![]);
        }
        let places: Vec<_> = reached.iter().map(|&v| self.surface.positions[v as usize]).collect();
        let nearest = Nearest::new(&places)?;
        let with_nearest = |v: u32| [v, reached[nearest.find(&self.surface.positions[v as usize]).0 as usize]];
        Ok(left.into_iter().map(with_nearest).collect())
    }
}

/// Sums over the triangles of a surface at its vertices.
struct Shapes {
    laplacian: CscMatrix<f64>,
    mass: Vec<f64>,
    /// Edges of triangles that have no shape whose ends no other triangle connects.
    ties: Vec<[u32; 2]>,
    /// Whether a vertex lies on a triangle with area.
    has_area: Vec<bool>,
}

fn shapes(surface: &Surface) -> Shapes {
    let n = surface.vertex_count();
    let (mut sets, mut has_area) = (UnionFind::<u32>::new(n), vec![false; n]);
    // Each triangle by itself, so that one can count as higher than it is.
    let (mut corners, mut of_corner, mut shapeless) = (Vec::new(), Vec::new(), Vec::new());
    for (t, triangle) in surface.triangles.iter().enumerate() {
        let points = surface.corners(&surface.positions, t);
        let [a, b, c] = *triangle;
        match lifted(points).filter(|_| a != b && b != c && c != a) {
            Some(points) => {
                corners.extend(points);
                of_corner.extend([a, b, c]);
                sets.union(a, b);
                sets.union(b, c);
            }
            None => shapeless.push([a, b, c]),
        }
        if !is_degenerate(&points) {
            triangle.iter().for_each(|&v| has_area[v as usize] = true);
        }
    }
    let alone: Vec<[u32; 3]> = (0..corners.len() as u32 / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    let mut assembly = Assembly::new(n);
    for (i, j, &value) in cotangent_laplacian(&corners, &alone).triplet_iter() {
        assembly.add(of_corner[i] as usize, of_corner[j] as usize, value);
    }
    let mut mass = vec![0.0; n];
    voronoi_mass(&corners, &alone).iter().zip(&of_corner).for_each(|(m, &v)| mass[v as usize] += m);
    let edges = shapeless.into_iter().flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]]);
    let mut ties: Vec<_> = edges.map(|[a, b]| [a.min(b), a.max(b)]).filter(|&[a, b]| !sets.equiv(a, b)).collect();
    ties.sort_unstable();
    ties.dedup();
    Shapes { laplacian: assembly.finish(), mass, ties, has_area }
}

/// A triangle with at least [`MIN_HEIGHT`]; `None` for a point.
fn lifted(points: [Point3<f64>; 3]) -> Option<[Point3<f64>; 3]> {
    if relative_height(&points) >= MIN_HEIGHT {
        return Some(points);
    }
    let edge = |k: usize| points[(k + 2) % 3] - points[(k + 1) % 3];
    let apex = (0..3).max_by(|&a, &b| edge(a).norm_squared().total_cmp(&edge(b).norm_squared()))?;
    let length = edge(apex).norm();
    let along = edge(apex).try_normalize(0.0)?.dot(&(points[apex] - points[(apex + 1) % 3]));
    let mut flat = [Point3::origin(); 3];
    flat[(apex + 2) % 3].x = length;
    flat[apex] = Point3::new(along.clamp(0.0, length), MIN_HEIGHT * length, 0.0);
    Some(flat)
}

/// The median of the positive cotangent weights of edges; 1 if there are none.
fn median_weight(laplacian: &CscMatrix<f64>) -> f64 {
    let edges = laplacian.triplet_iter().filter(|&(i, j, &value)| i != j && value < 0.0);
    let mut weights: Vec<f64> = edges.map(|(_, _, &value)| -value).collect();
    weights.sort_unstable_by(f64::total_cmp);
    weights.get(weights.len() / 2).copied().unwrap_or(1.0)
}
