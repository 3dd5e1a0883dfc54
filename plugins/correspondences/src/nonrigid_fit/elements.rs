//! The energy of the deformed target, as a quadratic in its vertices and fourth vertices.

use mimesh_core::{
    Result,
    linalg::{Blocks, FixedUnknowns, OuterSum},
    mesh::{Surface, SurfacePoint},
    operators::{Tetrahedron, relative_height, voronoi_mass},
    stage::TransferPair,
};
use nalgebra::{Matrix3, Point3};

use super::{link_elements::link_elements, ties::ties, unit_frame::UnitFrame, weighting::Weighting};

/// Numbers of a usual mesh, for which the papers' weights are meant.
const REFERENCE_TRIANGLES: f64 = 40_000.0;
const REFERENCE_VERTICES: f64 = 20_000.0;

/// How strongly a marker inside a target triangle is held, relative to `smoothness`; markers at vertices are exact.
const MARKER_WEIGHT: f64 = 1e6;

/// Triangles with a smaller relative height get no element: its gradient, squared, would drown all others.
const MIN_RELATIVE_HEIGHT: f64 = 1e-5;

/// Nor do triangles of a smaller height, in diagonals of the target.
const MIN_HEIGHT: f64 = 1e-7;

/// Weights of the terms of the energy that do not change with the steps, as in the settings of `nonrigid_fit`.
#[derive(Clone, Copy, Debug)]
pub struct EnergyWeights {
    /// w_S.
    pub smoothness: f64,
    /// w_I.
    pub identity: f64,
    /// w_R, relative to the two others.
    pub proximity: f64,
    /// How triangles and vertices count.
    pub weighting: Weighting,
    /// Most vertex pairs of a link that count in E_R; all if `None`.
    pub link_pairs: Option<usize>,
}

/// The triangles of the target with their fourth vertices, each a tetrahedron with a constant deformation gradient.
pub struct Elements<'a> {
    surface: &'a Surface,
    elements: Vec<Option<Tetrahedron>>,
    /// Pairs of triangles that share an edge.
    adjacent: Vec<[u32; 2]>,
    unknowns: usize,
    mass: Vec<f64>,
}

impl<'a> Elements<'a> {
    /// The elements of `surface` with its vertices at `rest`; vertices come first, then a fourth vertex a triangle.
    pub fn new(rest: &[Point3<f64>], surface: &'a Surface) -> Self {
        let mut unknowns = rest.len();
        let elements = surface
            .triangles
            .iter()
            .map(|&[a, b, c]| {
                let corners = [a, b, c].map(|v| rest[v as usize]);
                if !has_element(&corners) {
                    return None;
                }
                unknowns += 1;
                Some(Tetrahedron::over([a, b, c], unknowns as u32 - 1, &corners))
            })
            .collect();
        let mass = voronoi_mass(rest, &surface.triangles);
        Self { surface, elements, adjacent: surface.topology().adjacent, unknowns, mass }
    }

    /// The energy without closest points, ready to be minimised.
    pub fn system(&self, weights: EnergyWeights, pair: TransferPair<'_>, unit: &UnitFrame) -> Result<System> {
        let n = self.unknowns;
        let mut blocks = Blocks::new(n);
        let mut rhs = vec![0.0; 3 * n];
        let EnergyWeights { smoothness, identity, proximity, weighting, link_pairs } = weights;
        let rest = Matrix3::identity();
        let areas = self.surface.area_normals(&unit.target);
        let area: f64 = areas.iter().map(|n| n.norm()).sum();
        for (element, n) in self.elements.iter().zip(&areas) {
            if let Some(element) = element {
                let share = match weighting {
                    Weighting::Area => n.norm() / area * REFERENCE_TRIANGLES,
                    Weighting::Uniform => 1.0,
                };
                element.add_target(&rest, identity * share, &mut blocks, &mut rhs);
            }
        }
        for &[a, b] in &self.adjacent {
            if let (Some(a), Some(b)) = (&self.elements[a as usize], &self.elements[b as usize]) {
                a.add_smoothness(b, smoothness, &mut blocks);
            }
        }
        let links =
            pair.proximity.map(|graph| link_elements(&unit.target, self.surface, graph, &self.elements, link_pairs));
        let links = links.unwrap_or_default();
        for (a, b, stiffness) in &links {
            let weight = stiffness * proximity;
            a.add_smoothness(b, weight * smoothness, &mut blocks);
            a.add_target(&rest, weight * identity, &mut blocks, &mut rhs);
            b.add_target(&rest, weight * identity, &mut blocks, &mut rhs);
        }
        for tie in ties(&unit.target, pair, &self.elements, &links, link_pairs) {
            tie.add(&unit.target, smoothness, &mut blocks, &mut rhs);
        }
        let mut fixed = Vec::new();
        let mut values: [Vec<f64>; 3] = Default::default();
        for marker in pair.markers {
            let at = marker.source.position(pair.source, &unit.source);
            match marker.target {
                SurfacePoint::Vertex(vertex) => {
                    fixed.push(vertex);
                    (0..3).for_each(|c| values[c].push(at[c]));
                }
                SurfacePoint::Triangle(triangle, barycentric) => {
                    let corners = self.surface.triangles[triangle as usize];
                    let weight = MARKER_WEIGHT * smoothness.max(identity);
                    blocks.add_outer(&corners, &barycentric.map(|b| [b]), weight);
                    for (&v, b) in corners.iter().zip(barycentric) {
                        (0..3).for_each(|c| rhs[c * n + v as usize] += weight * b * at[c]);
                    }
                }
            }
        }
        let system = FixedUnknowns::for_refactoring(blocks, &fixed, "the fit of the target to the markers")?;
        let total: f64 = self.mass.iter().sum();
        let share = |mass: &f64| match weighting {
            Weighting::Area if total > 0.0 => mass / total * REFERENCE_VERTICES,
            Weighting::Area => 0.0,
            Weighting::Uniform => 1.0,
        };
        let share = self.mass.iter().map(share).collect();
        Ok(System { system, rhs, values: values.concat(), share, weight: 0.0, x: vec![] })
    }

    /// Number of triangles that have no element.
    pub fn skipped(&self) -> usize {
        self.elements.iter().filter(|e| e.is_none()).count()
    }

    /// E_S of the last solution: Σ over adjacent triangles ‖F_a − F_b‖².
    pub fn smoothness_energy(&self, system: &System) -> f64 {
        let at = |unknown: u32, c: usize| system.x[c * self.unknowns + unknown as usize];
        let squares = self.adjacent.iter().filter_map(|&[a, b]| {
            let (a, b) = (self.elements[a as usize].as_ref()?, self.elements[b as usize].as_ref()?);
            Some((a.deformation_gradient(at) - b.deformation_gradient(at)).norm_squared())
        });
        squares.sum()
    }
}

/// Whether a triangle, in the unit frame, is sound.
fn has_element(corners: &[Point3<f64>; 3]) -> bool {
    let [a, b, c] = corners;
    let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
    let height = relative_height(corners);
    height >= MIN_RELATIVE_HEIGHT && height * longest >= MIN_HEIGHT
}

/// The quadratic energy with its markers.
pub struct System {
    system: FixedUnknowns,
    /// b without closest points, n × 3 by columns.
    rhs: Vec<f64>,
    /// Positions of fixed unknowns, by columns.
    values: Vec<f64>,
    /// How much each vertex counts in E_C.
    share: Vec<f64>,
    weight: f64,
    /// All unknowns of the last solution, by columns.
    x: Vec<f64>,
}

impl System {
    /// Changes E_C: its weight and which vertices have a closest point.
    pub fn add_targets(&mut self, weight: f64, points: &[Option<Point3<f64>>]) -> Result<()> {
        self.weight = weight;
        let share = &self.share;
        let strength = |i: usize| if points.get(i).is_some_and(Option::is_some) { weight * share[i] } else { 0.0 };
        self.system.set_diagonal(strength)
    }

    /// The deformed vertices, #V; `points` as in the last [`add_targets`](Self::add_targets), or empty.
    pub fn solve(&mut self, points: &[Option<Point3<f64>>]) -> Vec<Point3<f64>> {
        let n = self.rhs.len() / 3;
        let mut rhs = self.rhs.clone();
        for (i, point) in points.iter().enumerate() {
            if let Some(point) = point {
                (0..3).for_each(|c| rhs[c * n + i] += self.weight * self.share[i] * point[c]);
            }
        }
        self.x = self.system.solve(&rhs, &self.values, 3);
        let x = &self.x;
        (0..self.share.len()).map(|i| Point3::new(x[i], x[n + i], x[2 * n + i])).collect()
    }
}
