//! The deformation gradient that each target triangle should take.

use std::collections::HashSet;

use mimesh_core::{
    Result,
    linalg::{Assembly, FixedUnknowns},
    mesh::{Surface, SurfacePoint},
    operators::{DeformationGradients, relative_height},
    stage::{TransferPair, TriangleMap},
};
use nalgebra::{Matrix3, Point3};
use petgraph::unionfind::UnionFind;

/// A triangle of source points serves if its shape (area over squared edges) is at least this part of the target
/// triangle's: below, points have been swept together and the quotient of small edges is noise.
const MIN_SHAPE: f64 = 0.2;

/// A partner with a smaller relative height gives no gradient: the quotient of its height before and after is noise.
const MIN_RELATIVE_HEIGHT: f64 = 1e-4;

/// Gives each target triangle a deformation gradient for each pose of the source.
///
/// - Where the map knows the source points under all three corners, it is that of the triangle they span. Summed along a
///   path it gives back what the source does from point to point, so that limbs keep their length across joints, where
///   gradients taken triangle by triangle drift.
/// - Else it is the partner's, as in Sumner and Popović 2004.
/// - Orphans continue their neighbours: they minimise Σ ‖F_t − F_u‖² over neighbours t, u with the others held (E2 of Zhou
///   et al. 2010, eq. 7, on the gradients themselves), a harmonic extension that is factored once.
#[derive(Debug)]
pub struct Field {
    source: Surface,
    of_partners: DeformationGradients,
    of_points: DeformationGradients,
    /// The source point of each target vertex; vertices without one stand in for nothing.
    points: Vec<SurfacePoint>,
    origins: Vec<Origin>,
    extension: Option<Extension>,
    /// R that turns the axes of the source to those of the target.
    rotation: Matrix3<f64>,
}

/// Where the gradient of a target triangle comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Origin {
    Points,
    Partner(u32),
    Orphan,
}

impl Field {
    /// Prepares for poses of the source; `use_points` says whether source points are used at all, and `bridges` are pairs of
    /// triangles that count as neighbours when orphans continue theirs.
    pub fn new(
        pair: TransferPair<'_>,
        map: &TriangleMap,
        rotation: Matrix3<f64>,
        use_points: bool,
        bridges: &[[u32; 2]],
    ) -> Result<Self> {
        let (source, target) = (pair.source, pair.target);
        let of_partners = DeformationGradients::new(&source.positions, &source.triangles);
        let known = |v: u32| map.points.get(v as usize).copied().flatten();
        let points: Vec<_> =
            (0..target.vertex_count() as u32).map(|v| known(v).unwrap_or(SurfacePoint::Vertex(0))).collect();
        let at_points: Vec<_> = points.iter().map(|p| p.position(source, &source.positions)).collect();
        let of_points = DeformationGradients::new(&at_points, &target.triangles);

        let source_normals = source.area_normals(&source.positions);
        let point_normals = target.area_normals(&at_points);
        let is_too_flat =
            |p: u32| relative_height(&source.corners(&source.positions, p as usize)) < MIN_RELATIVE_HEIGHT;
        let origin = |t: usize| {
            let Some(partner) = map.triangles[t].filter(|&p| !is_too_flat(p)) else {
                return Origin::Orphan;
            };
            let all_known = target.triangles[t].iter().all(|&v| known(v).is_some());
            let same_way = point_normals[t].dot(&source_normals[partner as usize]) > 0.0;
            let at_rest = shape(&target.corners(&target.positions, t));
            let sound = shape(&target.corners(&at_points, t)) > MIN_SHAPE * at_rest && of_points.is_defined(t);
            if use_points && all_known && same_way && sound { Origin::Points } else { Origin::Partner(partner) }
        };
        let origins: Vec<_> = (0..target.triangle_count()).map(origin).collect();
        let extension = Extension::new(target, &origins, bridges)?;
        Ok(Self { source: source.clone(), of_partners, of_points, points, origins, extension, rotation })
    }

    /// Number of target triangles whose gradient comes from source points, from a partner, and from neighbours.
    pub fn counts(&self) -> [usize; 3] {
        let orphans = self.origins.iter().filter(|o| **o == Origin::Orphan).count();
        let points = self.origins.iter().filter(|o| **o == Origin::Points).count();
        [points, self.origins.len() - points - orphans, orphans]
    }

    /// Whether target triangle `triangle` is an orphan.
    pub fn is_orphan(&self, triangle: usize) -> bool {
        self.origins[triangle] == Origin::Orphan
    }

    /// The source surface.
    pub fn source(&self) -> &Surface {
        &self.source
    }

    /// #V of the source.
    pub fn source_vertices(&self) -> usize {
        self.source.vertex_count()
    }

    /// R F Rᵀ for each target triangle when the source is at `posed`.
    pub fn at(&self, posed: &[Point3<f64>]) -> Vec<Matrix3<f64>> {
        let at_points: Vec<_> = self.points.iter().map(|p| p.position(&self.source, posed)).collect();
        let turned = |f: Matrix3<f64>| self.rotation * f * self.rotation.transpose();
        let of_triangle = |(t, origin): (usize, &Origin)| match *origin {
            Origin::Points => turned(self.of_points.of_triangle(t, &at_points)),
            Origin::Partner(partner) => turned(self.of_partners.of_triangle(partner as usize, posed)),
            Origin::Orphan => Matrix3::identity(),
        };
        let mut field: Vec<_> = self.origins.iter().enumerate().map(of_triangle).collect();
        if let Some(extension) = &self.extension {
            extension.fill(&mut field);
        }
        field
    }
}

/// Area over the sum of squared edges: 0 for a triangle without area, largest for an equilateral one.
fn shape([a, b, c]: &[Point3<f64>; 3]) -> f64 {
    let edges = (b - a).norm_squared() + (c - b).norm_squared() + (a - c).norm_squared();
    if edges > 0.0 { (b - a).cross(&(c - a)).norm() / edges } else { 0.0 }
}

/// The harmonic extension to orphans over the dual graph.
#[derive(Debug)]
struct Extension {
    system: FixedUnknowns,
    /// Triangles next to orphans, then the orphans, in the order of the system's unknowns.
    triangles: Vec<u32>,
    /// How many of `triangles`, at the front, are held.
    held: usize,
}

impl Extension {
    fn new(target: &Surface, origins: &[Origin], bridges: &[[u32; 2]]) -> Result<Option<Self>> {
        let is_orphan = |t: u32| origins[t as usize] == Origin::Orphan;
        let orphans = (0..origins.len() as u32).filter(|&t| is_orphan(t));
        let mut edges = target.topology().adjacent;
        edges.extend(bridges);
        edges.extend(by_vertices(target, &edges));
        edges.retain(|&[a, b]| is_orphan(a) || is_orphan(b));
        let mut triangles: Vec<u32> = edges.iter().flatten().copied().chain(orphans).collect();
        triangles.sort_unstable_by_key(|&t| (is_orphan(t), t));
        triangles.dedup();
        let held = triangles.partition_point(|&t| !is_orphan(t));
        if held == triangles.len() {
            return Ok(None);
        }
        let mut number = vec![0; origins.len()];
        triangles.iter().enumerate().for_each(|(k, &t)| number[t as usize] = k as u32);
        let mut assembly = Assembly::new(triangles.len());
        for &[a, b] in &edges {
            assembly.add_outer(&[number[a as usize], number[b as usize]], &[[1.0], [-1.0]], 1.0);
        }
        // Orphans that no partner reaches have the identity: one of each such region is drawn to it.
        let mut regions = UnionFind::<u32>::new(triangles.len());
        for &[a, b] in &edges {
            regions.union(number[a as usize], number[b as usize]);
        }
        let mut reached: HashSet<u32> = (0..held as u32).map(|k| regions.find_mut(k)).collect();
        (held..triangles.len())
            .filter(|&k| reached.insert(regions.find_mut(k as u32)))
            .for_each(|k| assembly.add(k, k, 1.0));
        let fixed: Vec<u32> = (0..held as u32).collect();
        let system = FixedUnknowns::new(&assembly.finish(), &fixed, "the continuation of the deformation to orphans")?;
        Ok(Some(Self { system, triangles, held }))
    }

    fn fill(&self, field: &mut [Matrix3<f64>]) {
        let n = self.triangles.len();
        // The nine entries of F − I, because what no partner reaches is drawn to 0.
        let mut values = Vec::with_capacity(9 * self.held);
        for (k, identity) in Matrix3::<f64>::identity().iter().enumerate() {
            values.extend(self.triangles[..self.held].iter().map(|&t| field[t as usize][k] - identity));
        }
        let x = self.system.solve(&vec![0.0; 9 * n], &values, 9);
        for (place, &t) in self.triangles.iter().enumerate().skip(self.held) {
            field[t as usize] = Matrix3::from_fn(|i, j| x[(3 * j + i) * n + place]) + Matrix3::identity();
        }
    }
}

/// For each triangle without a neighbour over an edge, as one with a repeated corner, the triangle with which it shares most
/// vertices.
fn by_vertices(target: &Surface, edges: &[[u32; 2]]) -> Vec<[u32; 2]> {
    let mut alone = vec![true; target.triangle_count()];
    edges.iter().flatten().for_each(|&t| alone[t as usize] = false);
    if !alone.contains(&true) {
        return vec![];
    }
    let around = target.triangles_around();
    let closest = |t: usize| {
        let others = target.triangles[t].iter().flat_map(|&v| &around[v as usize]).filter(|&&u| u as usize != t);
        let shared = |u: u32| target.triangles[t].iter().filter(|v| target.triangles[u as usize].contains(v)).count();
        others.copied().max_by_key(|&u| (shared(u), !alone[u as usize], std::cmp::Reverse(u)))
    };
    (0..alone.len()).filter(|&t| alone[t]).filter_map(|t| Some([t as u32, closest(t)?])).collect()
}
