//! Surfaces whose edges collapse.

use std::{cmp::Reverse, collections::BinaryHeap};

use nalgebra::{Matrix3, Point3, Vector3};

use crate::operators::relative_height;

/// What the squared length of an edge costs, relative to a squared distance from the surface: edges stay about equally long.
const EVENNESS: f64 = 1e-2;

/// How strongly a vertex that the planes around it leave free is drawn to the middle of its edge, relative to them.
const TO_MIDDLE: f64 = 1e-6;

/// The smallest product of the unit normals of a triangle before and after.
const MIN_FACING: f64 = 0.2;

/// Larger surfaces are simplified in rounds first: the queue of their edges would not fit into the caches.
const LARGE: usize = 100_000;

/// Rounds end at so many times the vertices asked for.
const AFTER_ROUNDS: f64 = 1.5;

/// The part of the edges that a round looks at, those that cost least.
const ROUND: f64 = 0.5;

/// Edges with more triangles at their ends stay: each collapse looks at all of them, and each of them has such an edge.
const MAX_AROUND: usize = 2000;

/// Triangles do not become flatter than this relative height.
const MIN_RELATIVE_HEIGHT: f64 = 0.05;

/// The sides of a triangle, smaller vertex first.
fn sides(&[a, b, c]: &[u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [b, c], [c, a]].map(|[a, b]| [a.min(b), a.max(b)])
}

/// The sum of squared distances to planes, each with a weight: pᵀ A p + 2 bᵀ p + c.
#[derive(Clone, Copy, Debug, Default)]
struct Quadric {
    a: Matrix3<f64>,
    b: Vector3<f64>,
    c: f64,
    /// The sum of the weights.
    weight: f64,
}

impl Quadric {
    /// That of the plane through `point` across the unit vector `normal`.
    fn plane(point: &Point3<f64>, normal: &Vector3<f64>, weight: f64) -> Self {
        let offset = -normal.dot(&point.coords);
        let (a, b, c) = (normal * normal.transpose() * weight, normal * (offset * weight), offset * offset * weight);
        Self { a, b, c, weight }
    }

    fn add(&mut self, other: &Self) {
        self.a += other.a;
        self.b += other.b;
        self.c += other.c;
        self.weight += other.weight;
    }

    fn at(&self, p: &Point3<f64>) -> f64 {
        (p.coords.dot(&(self.a * p.coords + 2.0 * self.b)) + self.c).max(0.0)
    }

    /// Where it is least, near `middle` in directions that make no difference.
    fn least(&self, middle: &Point3<f64>) -> Point3<f64> {
        let pull = TO_MIDDLE * self.weight;
        let inverse = (self.a + Matrix3::identity() * pull).try_inverse();
        inverse.map_or(*middle, |inverse| Point3::from(inverse * (middle.coords * pull - self.b)))
    }
}

/// An edge that may become a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Candidate {
    cost: f64,
    /// The ends, the smaller first, which stands for both afterwards.
    pub edge: [u32; 2],
    /// How often each end had changed when the cost was taken.
    changes: [u32; 2],
    place: Point3<f64>,
    /// Whether that is where the second end is.
    pub is_second: bool,
}

impl Eq for Candidate {}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.cost.total_cmp(&other.cost).then(self.edge.cmp(&other.edge)).then(self.changes.cmp(&other.changes))
    }
}

/// A mesh whose edges collapse.
pub(super) struct Collapsing {
    pub positions: Vec<Point3<f64>>,
    /// `None` once collapsed.
    pub triangles: Vec<Option<[u32; 3]>>,
    /// The vertex that is to stay in its place, and that this one has become.
    pub stands_for: Vec<Option<u32>>,
    ends: Ends,
    around: Vec<Vec<u32>>,
    quadrics: Vec<Quadric>,
    changes: Vec<u32>,
    is_boundary: Vec<bool>,
    /// Vertices that stay as they are.
    is_locked: Vec<bool>,
}

/// What edges become.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ends {
    /// The best point.
    Move,
    /// One of their ends.
    Stay,
}

impl Collapsing {
    /// A mesh in which the vertices `kept` stay in their places.
    pub fn new(positions: Vec<Point3<f64>>, triangles: Vec<[u32; 3]>, kept: &[u32], ends: Ends) -> Self {
        let n = positions.len();
        let mut mesh = Self {
            ends,
            around: vec![vec![]; n],
            quadrics: vec![Quadric::default(); n],
            changes: vec![0; n],
            is_boundary: vec![false; n],
            is_locked: vec![false; n],
            stands_for: vec![None; n],
            triangles: vec![],
            positions,
        };
        kept.iter().for_each(|&v| mesh.stands_for[v as usize] = Some(v));
        let mut on_side: Vec<([u32; 2], u32)> = Vec::with_capacity(3 * triangles.len());
        for (t, corners) in (0u32..).zip(&triangles) {
            let own = mesh.plane(corners);
            let repeats = corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0];
            for &v in corners {
                mesh.around[v as usize].push(t);
                mesh.quadrics[v as usize].add(&own);
                mesh.is_locked[v as usize] |= repeats;
            }
            on_side.extend(sides(corners).map(|side| (side, t)));
        }
        on_side.sort_unstable();
        for at_side in on_side.chunk_by(|a, b| a.0 == b.0) {
            let (side, t) = at_side[0];
            match at_side.len() {
                1 => {
                    let across = mesh.across(side, &triangles[t as usize]);
                    for v in side.map(|v| v as usize) {
                        mesh.is_boundary[v] = true;
                        mesh.quadrics[v].add(&across);
                    }
                }
                2 => {}
                _ => side.iter().for_each(|&v| mesh.is_locked[v as usize] = true),
            }
        }
        mesh.triangles = triangles.into_iter().map(Some).collect();
        mesh
    }

    /// Collapses edges, the cheapest first, until about `vertices` of the `left` vertices are left; `watch` is told of each before it goes.
    pub fn run(&mut self, mut left: usize, vertices: usize, mut watch: impl FnMut(&Candidate)) {
        if left > LARGE {
            left = self.collapse_in_rounds(left, (AFTER_ROUNDS * vertices as f64) as usize, &mut watch);
        }
        let mut edges: Vec<[u32; 2]> = self.triangles.iter().flatten().flat_map(sides).collect();
        edges.sort_unstable();
        edges.dedup();
        let mut queue: BinaryHeap<_> = edges.iter().filter_map(|&edge| self.candidate(edge).map(Reverse)).collect();
        drop(edges);
        while left > vertices
            && let Some(Reverse(candidate)) = queue.pop()
        {
            if !self.is_current(&candidate) || !self.allows(&candidate) {
                continue;
            }
            watch(&candidate);
            let kept = self.collapse(&candidate);
            left -= 1;
            for other in self.neighbours(kept) {
                queue.extend(self.candidate([kept.min(other), kept.max(other)]).map(Reverse));
            }
        }
    }

    fn corners(&self, triangle: &[u32; 3]) -> [Point3<f64>; 3] {
        triangle.map(|v| self.positions[v as usize])
    }

    /// The plane of a triangle, weighted by its area.
    fn plane(&self, triangle: &[u32; 3]) -> Quadric {
        let corners = self.corners(triangle);
        let normal = area_normal(&corners);
        normal
            .try_normalize(0.0)
            .map_or_else(Quadric::default, |unit| Quadric::plane(&corners[0], &unit, normal.norm() / 2.0))
    }

    /// The plane through a side of a triangle across it, weighted by the squared length.
    fn across(&self, side: [u32; 2], triangle: &[u32; 3]) -> Quadric {
        let [from, to] = side.map(|v| self.positions[v as usize]);
        let normal = (to - from).cross(&area_normal(&self.corners(triangle)));
        let weight = (to - from).norm_squared();
        normal.try_normalize(0.0).map_or_else(Quadric::default, |unit| Quadric::plane(&from, &unit, weight))
    }

    /// What it costs that `edge` becomes a point; `None` if it is to stay.
    fn candidate(&self, edge: [u32; 2]) -> Option<Candidate> {
        let [a, b] = edge.map(|v| v as usize);
        if a == b || self.is_locked[a] || self.is_locked[b] {
            return None;
        }
        let mut sum = self.quadrics[a];
        sum.add(&self.quadrics[b]);
        let middle = match (self.is_boundary[a], self.is_boundary[b]) {
            (true, false) => self.positions[a],
            (false, true) => self.positions[b],
            _ => nalgebra::center(&self.positions[a], &self.positions[b]),
        };
        let [first, second] = [self.positions[a], self.positions[b]];
        let stays = [a, b].map(|v| self.stands_for[v].is_some());
        let ends_stay = self.ends == Ends::Stay;
        let is_second = match (self.is_boundary[a], self.is_boundary[b]) {
            _ if stays == [true; 2] => return None,
            // A boundary does not leave its place for a vertex that is kept.
            (true, false) if stays[1] => return None,
            (false, true) if stays[0] => return None,
            (true, false) => false,
            (false, true) => true,
            _ => stays[1] || !stays[0] && ends_stay && sum.at(&second) < sum.at(&first),
        };
        let is_end = ends_stay || stays != [false; 2];
        let place = match (is_end, is_second) {
            (false, _) => sum.least(&middle),
            (true, false) => first,
            (true, true) => second,
        };
        let length = (second - first).norm_squared();
        let cost = sum.at(&place) + EVENNESS * sum.weight * length;
        let changes = [self.changes[a], self.changes[b]];
        (cost.is_finite() && (place - middle).norm_squared() <= length).then_some(Candidate {
            cost,
            edge,
            changes,
            place,
            is_second: is_end && is_second,
        })
    }

    /// Collapses edges until about `vertices` of the `left` vertices are left, and returns how many are.
    ///
    /// Each round takes costs once. It goes through the edges of the cheaper half by their costs, and leaves out those at which another has
    /// collapsed before.
    fn collapse_in_rounds(&mut self, mut left: usize, vertices: usize, watch: &mut impl FnMut(&Candidate)) -> usize {
        while left > vertices {
            let directed = |&[a, b, c]: &[u32; 3]| [[a, b], [b, c], [c, a]];
            // Once each, in whose direction it ascends; those of boundaries that descend wait for the end.
            let edges = self.triangles.iter().flatten().flat_map(directed).filter(|[from, to]| from < to);
            let mut candidates: Vec<Candidate> = edges.filter_map(|edge| self.candidate(edge)).collect();
            let count = (ROUND * candidates.len() as f64) as usize;
            if count == 0 {
                break;
            }
            candidates.select_nth_unstable(count);
            candidates.truncate(count);
            candidates.sort_unstable();
            let before = left;
            for candidate in &candidates {
                if left > vertices && self.is_current(candidate) && self.allows(candidate) {
                    watch(candidate);
                    self.collapse(candidate);
                    left -= 1;
                }
            }
            // What is left is hard to collapse.
            if before - left < before / 50 {
                break;
            }
        }
        left
    }

    fn is_current(&self, candidate: &Candidate) -> bool {
        candidate.edge.map(|v| self.changes[v as usize]) == candidate.changes
    }

    /// The vertices beside `v`, ascending.
    fn neighbours(&self, v: u32) -> Vec<u32> {
        let corners = self.around[v as usize].iter().filter_map(|&t| self.triangles[t as usize]).flatten();
        let mut neighbours: Vec<u32> = corners.filter(|&other| other != v).collect();
        neighbours.sort_unstable();
        neighbours.dedup();
        neighbours
    }

    /// Whether the collapse keeps topology and triangles sound.
    fn allows(&self, candidate: &Candidate) -> bool {
        let [a, b] = candidate.edge;
        if self.around[a as usize].len() + self.around[b as usize].len() > MAX_AROUND {
            return false;
        }
        let at = |v: u32| self.around[v as usize].iter().filter_map(|&t| self.triangles[t as usize]);
        let shared = at(a).filter(|t| t.contains(&b)).count();
        let expected = if self.is_boundary[a as usize] && self.is_boundary[b as usize] { 1 } else { 2 };
        let beside = self.neighbours(b);
        let common = self.neighbours(a).iter().filter(|v| beside.binary_search(v).is_ok()).count();
        // The link condition [Dey et al. 1999]: else an edge or a tube would be pinched.
        if shared != expected || common != shared {
            return false;
        }
        let moved = |from: u32, other: u32| {
            at(from).filter(move |t| !t.contains(&other)).map(move |t| (t, t.map(|v| if v == from { a } else { v })))
        };
        let sorted = |mut t: [u32; 3]| {
            t.sort_unstable();
            t
        };
        let mut all: Vec<_> = moved(a, b).chain(moved(b, a)).map(|(_, t)| sorted(t)).collect();
        let count = all.len();
        all.sort_unstable();
        all.dedup();
        // Two triangles of the same corners are what is left of a tetrahedron.
        all.len() == count
            && count > 0
            && moved(a, b).chain(moved(b, a)).all(|(before, after)| {
                let before = self.corners(&before);
                let after = after.map(|v| if v == a { candidate.place } else { self.positions[v as usize] });
                is_sound(&before, &after)
            })
    }

    /// Makes the edge a point, and returns the vertex that stands for it.
    fn collapse(&mut self, candidate: &Candidate) -> u32 {
        let [a, b] = candidate.edge;
        for t in std::mem::take(&mut self.around[b as usize]) {
            let Some(corners) = self.triangles[t as usize] else { continue };
            if corners.contains(&a) {
                self.triangles[t as usize] = None;
            } else {
                self.triangles[t as usize] = Some(corners.map(|v| if v == b { a } else { v }));
                self.around[a as usize].push(t);
            }
        }
        let mut around = std::mem::take(&mut self.around[a as usize]);
        around.retain(|&t| self.triangles[t as usize].is_some());
        self.around[a as usize] = around;
        let gone = self.quadrics[b as usize];
        self.quadrics[a as usize].add(&gone);
        self.is_boundary[a as usize] |= self.is_boundary[b as usize];
        self.stands_for[a as usize] = self.stands_for[a as usize].or(self.stands_for[b as usize]);
        self.positions[a as usize] = candidate.place;
        self.changes[a as usize] += 1;
        self.changes[b as usize] += 1;
        a
    }
}

/// Whether a triangle faces about the same way as before and is no needle, or at least no worse one.
fn is_sound(before: &[Point3<f64>; 3], after: &[Point3<f64>; 3]) -> bool {
    let [old, new] = [before, after].map(area_normal);
    let faces = old.dot(&new) >= MIN_FACING * old.norm() * new.norm() && new.norm() > 0.0;
    let height = relative_height(after);
    faces && (height >= MIN_RELATIVE_HEIGHT || height >= relative_height(before))
}

fn area_normal([a, b, c]: &[Point3<f64>; 3]) -> Vector3<f64> {
    (b - a).cross(&(c - a))
}
