//! The quadratic energy of all components together.

use mimesh_core::{
    Result,
    linalg::{Assembly, Multifrontal},
    mesh::Surface,
    operators::{Gradient, Tetrahedron, gradients},
    stage::ProximityGraph,
};
use nalgebra::{Matrix3, Point3, Vector3};

use super::{
    detail_term::Detail,
    gaps::Gap,
    gradient_term::GradientTerm,
    sideways::Sideways,
    term_weights::TermWeights,
    tetrahedra::{Bridge, bridges},
};

/// How strongly a triangle without area holds its edges, in units of cotangent weight.
const DEGENERATE_WEIGHT: f64 = 1e-4;

/// How strongly the edges of every triangle are held, too weakly to be felt where anything else holds them.
const REGULARIZATION_WEIGHT: f64 = 1e-9;

/// Up to this many unknowns eight poses are solved for at once. What their steps keep then takes no more than 1 GB.
const MAX_UNKNOWNS_OF_EIGHT: usize = 300_000;

/// E1 + E2 + E3 + E4 with directions held: one matrix, factored once.
#[derive(Debug)]
pub struct System {
    factor: Multifrontal,
    rest: Vec<Point3<f64>>,
    diagonal: f64,
    triangles: Vec<[u32; 3]>,
    /// The factor of a gradient in the right-hand side of each corner, by columns (E1, and a little for every triangle).
    rhs_of_gradient: Vec<Matrix3<f64>>,
    /// E1.
    pub gradient_term: GradientTerm,
    /// Neighbouring orphans (E2).
    smooth_pairs: Vec<SmoothPair>,
    /// Orphans with a corresponding neighbour, by which they are held (E2).
    held: Vec<Held>,
    /// Tetrahedra across gaps that are to deform alike, with their weights.
    bridges: Vec<(Bridge, f64)>,
    /// The Laplacian of orphan components (E4), times w4 on the right-hand side.
    detail: Option<Detail>,
    unknowns: usize,
    anchor: u32,
    /// β of E5; empty for none.
    prior: Vec<f64>,
}

/// Two orphans side by side.
#[derive(Debug)]
struct SmoothPair {
    triangles: [u32; 2],
    elements: [Tetrahedron; 2],
    weight: f64,
}

/// An orphan beside a triangle that corresponds.
#[derive(Debug)]
struct Held {
    triangle: u32,
    neighbour: u32,
    element: Tetrahedron,
    weight: f64,
}

/// The differences between deformation gradients of orphans and of their neighbours that E2 is to have.
#[derive(Clone, Copy)]
pub enum Continued<'a> {
    /// None, as in the paper.
    Alike,
    /// Those of a field (#F) in which orphans continue their neighbours.
    As(&'a [Matrix3<f64>]),
}

impl Continued<'_> {
    fn difference(self, [a, b]: [u32; 2]) -> Matrix3<f64> {
        match self {
            Self::Alike => Matrix3::zeros(),
            Self::As(field) => field[a as usize] - field[b as usize],
        }
    }
}

impl System {
    /// Factors the system; `graph` has the links whose gaps are spanned by tetrahedra, and `orphan_component` says which vertices
    /// belong to components without any correspondence.
    pub fn new(
        target: &Surface,
        gaps: &[Gap],
        graph: Option<&ProximityGraph>,
        weights: TermWeights,
        prior: &[f64],
        is_orphan: impl Fn(usize) -> bool,
        orphan_component: impl Fn(u32) -> bool,
    ) -> Result<Self> {
        let n = target.vertex_count();
        let gradients = gradients(&target.positions, &target.triangles);
        let mut unknowns = n;
        let tetrahedra: Vec<Option<Tetrahedron>> = (0..target.triangle_count())
            .map(|t| {
                if !is_orphan(t) || gradients[t].is_none() || weights.smoothness == 0.0 {
                    return None;
                }
                unknowns += 1;
                Some(Tetrahedron::over(target.triangles[t], unknowns as u32 - 1, &target.corners(&target.positions, t)))
            })
            .collect();
        let bridges = bridges(target, graph, &mut unknowns);
        let mut assembly = Assembly::new(unknowns);
        let mut rhs_of_gradient = Vec::with_capacity(gradients.len());
        for (t, gradient) in gradients.iter().enumerate() {
            let corners = &target.triangles[t];
            // The edges of every triangle are held a little, so that what no other term holds follows its neighbours.
            let slight = regularize(
                target,
                corners,
                if gradient.is_some() { REGULARIZATION_WEIGHT } else { DEGENERATE_WEIGHT },
                &mut assembly,
            );
            rhs_of_gradient.push(match gradient {
                Some(Gradient { of_corners: g, area }) if !is_orphan(t) => {
                    let w = weights.gradient * weights.of_triangle(*area);
                    let rows: [[f64; 3]; 3] = std::array::from_fn(|i| g.column(i).into_owned().into());
                    assembly.add_outer(corners, &rows, w);
                    slight + g * w
                }
                _ => slight,
            });
        }
        let area = |t: usize| gradients[t].map_or(0.0, |g| g.area);
        let weighted = |bridge: Bridge| {
            let areas = bridge.triangles.map(|t| area(t as usize));
            let weight = weights.smoothness * bridge.stiffness * weights.of_pair(areas, false);
            (bridge, weight)
        };
        let bridges: Vec<(Bridge, f64)> = bridges.into_iter().map(weighted).collect();
        for (Bridge { elements: [a, b], .. }, weight) in &bridges {
            a.add_smoothness(b, *weight, &mut assembly);
        }
        let (mut held, mut smooth_pairs) = (Vec::new(), Vec::new());
        for [a, b] in target.topology().adjacent {
            let both = tetrahedra[a as usize].is_some() && tetrahedra[b as usize].is_some();
            let weight = weights.smoothness * weights.of_pair([area(a as usize), area(b as usize)], both);
            match (&tetrahedra[a as usize], &tetrahedra[b as usize]) {
                (Some(on_a), Some(on_b)) => {
                    on_a.add_smoothness(on_b, weight, &mut assembly);
                    smooth_pairs.push(SmoothPair { triangles: [a, b], elements: [on_a.clone(), on_b.clone()], weight });
                }
                (Some(element), None) => {
                    held.push(Held { triangle: a, neighbour: b, element: element.clone(), weight })
                }
                (None, Some(element)) => {
                    held.push(Held { triangle: b, neighbour: a, element: element.clone(), weight })
                }
                (None, None) => {}
            }
        }
        held.iter().for_each(|held| assembly.add_outer(&held.element.unknowns, &held.element.gradient, held.weight));
        for gap in gaps {
            assembly.add_outer(&gap.ends, &[[1.0], [-1.0]], gap.weight);
        }
        let detail = Detail::new(target, weights.details, orphan_component, &mut assembly);
        // Coordinates are relative to the anchor. No term minds a translation, so that this holds it exactly.
        let anchor = target.triangles.first().map_or(0, |t| t[0]);
        // E5 minds a translation, and holds it instead.
        let is_held = prior.iter().sum::<f64>() > 0.0;
        if !is_held {
            assembly.add(anchor as usize, anchor as usize, 1.0);
        }
        prior.iter().enumerate().for_each(|(v, &weight)| assembly.add(v, v, weight));
        let known = |t: usize| {
            gradients[t].filter(|_| !is_orphan(t)).map(|g| (g, weights.gradient * weights.of_triangle(g.area)))
        };
        let factor = Multifrontal::factored(&assembly.finish(), "the system of the target's components")?;
        Ok(Self {
            factor,
            rest: target.positions.clone(),
            diagonal: target.diagonal(),
            triangles: target.triangles.clone(),
            rhs_of_gradient,
            gradient_term: GradientTerm::new(target, known),
            smooth_pairs,
            held,
            bridges,
            detail,
            unknowns,
            anchor,
            prior: if is_held { prior.to_vec() } else { vec![] },
        })
    }

    /// The part of the right-hand side that does not change within a pose, for gradients `field` of triangles that correspond and
    /// the differences between orphans and their neighbours that E2 is to have.
    pub fn rhs(&self, field: &[Matrix3<f64>], continued: Continued<'_>) -> Vec<f64> {
        let n = self.unknowns;
        let mut rhs = vec![0.0; 3 * n];
        for ((t, of_gradient), f) in self.triangles.iter().zip(&self.rhs_of_gradient).zip(field) {
            let b = f * of_gradient;
            for (k, &v) in t.iter().enumerate() {
                (0..3).for_each(|c| rhs[c * n + v as usize] += b[(c, k)]);
            }
        }
        for held in &self.held {
            let goal = field[held.neighbour as usize] + continued.difference([held.triangle, held.neighbour]);
            held.element.add_target_rhs(&goal, held.weight, &mut rhs);
        }
        for pair in &self.smooth_pairs {
            let goal = continued.difference(pair.triangles);
            pair.elements[0].add_target_rhs(&goal, pair.weight, &mut rhs);
            pair.elements[1].add_target_rhs(&-goal, pair.weight, &mut rhs);
        }
        rhs
    }

    /// The right-hand side for gaps `vectors`, Laplacian coordinates `details` and, with E5, vertices drawn to `goals`.
    pub fn right_hand_side(
        &self,
        rhs: &[f64],
        gaps: &[Gap],
        vectors: &[Vector3<f64>],
        details: &[Vector3<f64>],
        goals: &[Point3<f64>],
    ) -> Vec<f64> {
        let n = self.unknowns;
        let mut x = rhs.to_vec();
        for (gap, vector) in gaps.iter().zip(vectors) {
            for c in 0..3 {
                x[c * n + gap.ends[0] as usize] += gap.weight * vector[c];
                x[c * n + gap.ends[1] as usize] -= gap.weight * vector[c];
            }
        }
        if let Some(detail) = &self.detail {
            detail.add_rhs(details, &mut x);
        }
        let anchor = self.rest[self.anchor as usize];
        for (v, (weight, goal)) in self.prior.iter().zip(goals).enumerate() {
            (0..3).for_each(|c| x[c * n + v] += weight * (goal[c] - anchor[c]));
        }
        x
    }

    /// How many poses are best solved for together: as many as share a pass over the factor and have room in memory.
    pub fn at_once(&self) -> usize {
        if self.unknowns <= MAX_UNKNOWNS_OF_EIGHT { 8 } else { 2 }
    }

    /// Replaces right-hand sides, one after another, by the unknowns that solve them; none depends on the others.
    pub fn solve_in_place(&self, x: &mut [f64]) {
        self.factor.solve_in_place(x);
    }

    /// The longest way of a vertex in a difference of unknowns.
    pub fn longest(&self, way: &[f64]) -> f64 {
        let n = self.unknowns;
        let length = |v: usize| Vector3::new(way[v], way[n + v], way[2 * n + v]).norm();
        (0..self.rest.len()).map(length).fold(0.0, f64::max)
    }

    /// How the unknowns of one coordinate answer to a unit force at the mean of `points` (vertices with weights that sum to 1).
    ///
    /// Nothing but the anchor resists a force on the whole, so that every answer has a translation of 1; it cancels among forces
    /// that sum to 0.
    pub fn response(&self, points: &[(u32, f64)]) -> Vec<f64> {
        let mut x = vec![0.0; self.unknowns];
        points.iter().for_each(|&(v, weight)| x[v as usize] += weight);
        self.factor.solve_in_place(&mut x);
        x
    }

    /// The vertices of a solution.
    pub fn positions(&self, x: &[f64]) -> Vec<Point3<f64>> {
        let n = self.unknowns;
        let anchor = self.rest[self.anchor as usize];
        (0..self.rest.len()).map(|v| anchor + Vector3::new(x[v], x[n + v], x[2 * n + v])).collect()
    }

    /// E4's Laplacian coordinates for the directions at `now`; empty if there is no orphan component.
    pub fn details(&self, now: &[Point3<f64>]) -> Vec<Vector3<f64>> {
        self.detail.as_ref().map_or(vec![], |detail| detail.goals(now))
    }

    /// E4's Laplacian coordinates at rest, turned by what `rotation` says of each vertex.
    pub fn turned_details(&self, rotation: impl Fn(u32) -> Matrix3<f64>) -> Vec<Vector3<f64>> {
        self.detail.as_ref().map_or(vec![], |detail| detail.turned(&self.rest, rotation))
    }

    /// By how much the matrix is stiffer than E4 sideways of the directions at `now`; empty if there is no orphan component.
    pub fn sideways_of_details(&self, now: &[Point3<f64>]) -> Vec<Sideways> {
        self.detail.as_ref().map_or(vec![], |detail| detail.sideways(now))
    }

    /// Subtracts the product of what [`sideways_of_details`](Self::sideways_of_details) gave and `direction`.
    pub fn subtract_sideways_of_details(&self, sideways: &[Sideways], direction: &[f64], product: &mut [f64]) {
        self.detail.iter().for_each(|detail| detail.subtract_sideways(sideways, direction, product));
    }

    /// The diagonal of the target at rest.
    pub fn diagonal(&self) -> f64 {
        self.diagonal
    }

    /// Whether any component is an orphan that E4 holds.
    pub fn has_details(&self) -> bool {
        self.detail.is_some()
    }

    /// E2 + E4 of a solution x with its `positions`.
    pub fn energy(
        &self,
        x: &[f64],
        positions: &[Point3<f64>],
        field: &[Matrix3<f64>],
        continued: Continued<'_>,
    ) -> f64 {
        let at = |i: u32, c: usize| x[c * self.unknowns + i as usize];
        let mut energy = self.detail.as_ref().map_or(0.0, |detail| detail.energy(positions));
        for (Bridge { elements: [a, b], .. }, weight) in &self.bridges {
            energy += weight * (a.deformation_gradient(at) - b.deformation_gradient(at)).norm_squared();
        }
        for held in &self.held {
            let goal = field[held.neighbour as usize] + continued.difference([held.triangle, held.neighbour]);
            energy += held.weight * (held.element.deformation_gradient(at) - goal).norm_squared();
        }
        for pair in &self.smooth_pairs {
            let [a, b] = &pair.elements;
            let difference = a.deformation_gradient(at) - b.deformation_gradient(at);
            energy += pair.weight * (difference - continued.difference(pair.triangles)).norm_squared();
        }
        energy
    }
}

/// Holds the edges of a triangle; returns what a gradient multiplies into the right-hand side.
fn regularize(target: &Surface, t: &[u32; 3], weight: f64, assembly: &mut Assembly) -> Matrix3<f64> {
    let mut rhs = Matrix3::zeros();
    for (i, j) in [(0, 1), (1, 2), (2, 0)] {
        if t[i] != t[j] {
            assembly.add_outer(&[t[i], t[j]], &[[1.0], [-1.0]], weight);
            let edge = (target.positions[t[i] as usize] - target.positions[t[j] as usize]) * weight;
            let (a, b) = (rhs.column(i) + edge, rhs.column(j) - edge);
            rhs.set_column(i, &a);
            rhs.set_column(j, &b);
        }
    }
    rhs
}
