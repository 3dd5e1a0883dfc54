//! Small components that have come to lie on two sides of the source move to one.
//!
//! A plate between the legs is as near to one thigh as to the other. Its vertices take their closest points one by one, some on
//! either thigh, and the plate then follows half of each. An edge between two such vertices is torn: short on the target, long
//! along the source (`tears`).
//!
//! A component of at most 400 vertices with at least 30 % of them at torn edges is moved as a whole to one patch of the source, which
//! is a ball along its surface about one of up to four points that the component already has. All its vertices take their closest
//! points in the patch. Of all patches and the present points those are taken with the lowest cost
//!
//! Σ over edges of their tears + Σ over vertices (d / 0.02 + (1 − |n · m|) / 2),
//!
//! with d the distance to the source in diagonals of the target and n, m the normals of both. An orphan would be worse than either
//! side: such a component is told nothing of where it belongs.

use mimesh_core::{
    Figures, Result,
    mesh::{Surface, SurfacePoint, diagonal},
    operators::vertex_normals,
    spatial::DistanceSearch,
    stage::TransferPair,
};
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

use super::{tears::Tears, unit_frame::UnitFrame};
use crate::facing::Facing;

/// For each target vertex the source point it lies at, if there is one.
pub type Points = Vec<Option<SurfacePoint>>;

/// Larger components have parts of their own, which may lie in several places.
const MAX_VERTICES: usize = 400;

/// A component of which a smaller share of the vertices is torn is left alone.
const MIN_TORN: f64 = 0.3;

/// Patches that are tried for a component.
const MAX_PATCHES: usize = 4;

/// The radius of a patch, in diagonals of the component and in edges of the source.
const RADIUS: [f64; 2] = [1.5, 3.0];

/// The distance to the source that costs as much as a torn edge, in diagonals of the target.
const DISTANCE: f64 = 0.02;

/// The cost of a vertex at right angles to the source.
const TURNED: f64 = 0.5;

/// Costs of two patches closer than this, in parts of the lower one, are nearly equal.
const TIE: f64 = 0.1;

/// What is known when the last search is done.
pub struct Settled<'a> {
    pub pair: TransferPair<'a>,
    pub unit: &'a UnitFrame,
    pub facing: &'a Facing,
    /// The deformed target in the unit frame.
    pub fit: &'a [Point3<f64>],
    pub max_distance: f64,
}

/// A component of the target.
struct Component {
    number: usize,
    vertices: Vec<u32>,
    triangles: Vec<u32>,
    edges: Vec<[u32; 2]>,
}

/// A place for a component: a point for each of its vertices, in their order.
struct Placement {
    points: Points,
    cost: f64,
    /// Where its patch has its centre.
    centre: SurfacePoint,
}

/// A component that moves.
pub struct Move {
    component: Component,
    points: Points,
    /// Whether another patch costs nearly as much.
    tie: bool,
}

impl Settled<'_> {
    /// The components that move to one patch of the source, given the points that vertices have (#V of the target).
    ///
    /// # Errors
    ///
    /// The errors of [`Tears::new`].
    pub fn moves(&self, points: &[Option<SurfacePoint>]) -> Result<Vec<Move>> {
        let components = small_components(self.pair.target);
        if components.is_empty() {
            return Ok(vec![]);
        }
        let search = Search {
            points,
            tears: Tears::new(self.pair.source, &self.unit.source)?,
            normals: vertex_normals(self.fit, &self.pair.target.triangles),
            marked: self.marked(),
            settled: self,
        };
        let place = |memory: &mut DistanceSearch, component| search.place(component, memory);
        Ok(components.into_par_iter().map_init(|| search.tears.search(), place).flatten().collect())
    }

    /// For each vertex of the target whether it has a marker.
    fn marked(&self) -> Vec<bool> {
        let mut marked = vec![false; self.pair.target.vertex_count()];
        for marker in self.pair.markers {
            marker.target.corners(self.pair.target).iter().for_each(|&(v, _)| marked[v as usize] = true);
        }
        marked
    }
}

struct Search<'a> {
    settled: &'a Settled<'a>,
    /// The points that vertices have.
    points: &'a [Option<SurfacePoint>],
    tears: Tears<'a>,
    /// Of the vertices of the deformed target.
    normals: Vec<Vector3<f64>>,
    marked: Vec<bool>,
}

impl Search<'_> {
    /// The patch to which `component` moves, if it does.
    fn place(&self, component: Component, memory: &mut DistanceSearch) -> Option<Move> {
        let present: Points = component.vertices.iter().map(|&v| self.points[v as usize]).collect();
        let tears = self.edge_tears(&component, &present, memory);
        if self.torn_share(&component, &tears) < MIN_TORN {
            return None;
        }
        let present_cost = self.cost(&component, &present, &tears);
        let mut placements: Vec<Placement> = self
            .centres(&present)
            .into_iter()
            .filter_map(|centre| self.placement(&component, &present, centre, memory))
            .collect();
        placements.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        let best = placements.first().filter(|best| best.cost < present_cost)?;
        let rivals = placements[1..].iter().take_while(|other| other.cost <= best.cost * (1.0 + TIE));
        self.tears.ball(&best.centre, self.radius(&component, &best.centre), memory);
        let is_inside = |v: u32| memory.distance(v).is_finite();
        let tie = rivals.into_iter().any(|other| {
            let corners = other.centre.corners(self.settled.pair.source);
            corners.into_iter().all(|(v, _)| !is_inside(v))
        });
        let points = best.points.clone();
        Some(Move { component, points, tie })
    }

    /// How badly each edge is torn.
    fn edge_tears(&self, component: &Component, points: &Points, memory: &mut DistanceSearch) -> Vec<f64> {
        let rest = &self.settled.unit.target;
        let tear = |&[a, b]: &[u32; 2]| {
            let [p, q] = [a, b].map(|v| points[component.place_of(v)]);
            let length = (rest[b as usize] - rest[a as usize]).norm();
            p.zip(q).map_or(0.0, |(p, q)| self.tears.of_edge(length, &p, &q, memory))
        };
        component.edges.iter().map(tear).collect()
    }

    /// The share of vertices without markers that are at torn edges.
    fn torn_share(&self, component: &Component, tears: &[f64]) -> f64 {
        let mut torn = vec![false; component.vertices.len()];
        for (edge, _) in component.edges.iter().zip(tears).filter(|(_, tear)| **tear >= 1.0) {
            edge.iter().filter(|&&v| !self.marked[v as usize]).for_each(|&v| torn[component.place_of(v)] = true);
        }
        torn.iter().filter(|torn| **torn).count() as f64 / torn.len() as f64
    }

    fn cost(&self, component: &Component, points: &Points, tears: &[f64]) -> f64 {
        let vertex = |(&v, point): (&u32, &Option<SurfacePoint>)| match point {
            _ if self.marked[v as usize] => 0.0,
            Some(point) => self.vertex_cost(v, point),
            None => self.settled.max_distance / DISTANCE + TURNED,
        };
        tears.iter().sum::<f64>() + component.vertices.iter().zip(points).map(vertex).sum::<f64>()
    }

    fn vertex_cost(&self, v: u32, point: &SurfacePoint) -> f64 {
        let Settled { pair, unit, facing, fit, .. } = self.settled;
        let distance = (point.position(pair.source, &unit.source) - fit[v as usize]).norm();
        let parallel = match point {
            SurfacePoint::Triangle(t, _) => facing.parallel(*t, &self.normals[v as usize]),
            SurfacePoint::Vertex(_) => 1.0,
        };
        distance / DISTANCE + TURNED * (1.0 - parallel)
    }

    /// Points that a component already has, each the farthest from those before.
    fn centres(&self, points: &Points) -> Vec<SurfacePoint> {
        let Settled { pair, unit, .. } = self.settled;
        let points: Vec<SurfacePoint> = points.iter().copied().flatten().collect();
        let places: Vec<Point3<f64>> = points.iter().map(|p| p.position(pair.source, &unit.source)).collect();
        let mut distance = vec![f64::INFINITY; places.len()];
        let mut chosen = vec![];
        let mut next = 0;
        while chosen.len() < MAX_PATCHES.min(points.len()) && distance[next] > 0.0 {
            chosen.push(points[next]);
            distance.iter_mut().zip(&places).for_each(|(d, p)| *d = d.min((p - places[next]).norm()));
            next = (0..places.len()).rev().max_by(|&a, &b| distance[a].total_cmp(&distance[b])).unwrap_or(0);
        }
        chosen
    }

    fn radius(&self, component: &Component, centre: &SurfacePoint) -> f64 {
        let rest = &self.settled.unit.target;
        let corners: Vec<Point3<f64>> = component.vertices.iter().map(|&v| rest[v as usize]).collect();
        let size = diagonal(&corners);
        (RADIUS[0] * size).max(RADIUS[1] * self.tears.longest_edge(centre))
    }

    /// The whole component in the patch about `centre`; `None` if a vertex is too far from it.
    fn placement(
        &self,
        component: &Component,
        present: &Points,
        centre: SurfacePoint,
        memory: &mut DistanceSearch,
    ) -> Option<Placement> {
        let Settled { pair, facing, fit, max_distance, .. } = self.settled;
        self.tears.ball(&centre, self.radius(component, &centre), memory);
        let is_in_patch = |t: u32| pair.source.triangles[t as usize].iter().any(|&v| memory.distance(v).is_finite());
        let closest = |(&v, present): (&u32, &Option<SurfacePoint>)| {
            if self.marked[v as usize] {
                return Some(*present);
            }
            let found = facing.find_among(&fit[v as usize], *max_distance, is_in_patch)?;
            Some(Some(SurfacePoint::Triangle(found.triangle, found.barycentric)))
        };
        let points: Points = component.vertices.iter().zip(present).map(closest).collect::<Option<_>>()?;
        let tears = self.edge_tears(component, &points, memory);
        let cost = self.cost(component, &points, &tears);
        Some(Placement { cost, points, centre })
    }
}

impl Move {
    /// Moves the component: sets the points of its vertices and the partners of its triangles.
    ///
    /// A triangle has the partner nearest to its barycentre among those under its corners, one that faces the same way if there is one.
    pub fn apply(&self, settled: &Settled<'_>, points: &mut Points, partners: &mut [Option<u32>]) {
        for (&v, point) in self.component.vertices.iter().zip(&self.points) {
            points[v as usize] = *point;
        }
        for &t in &self.component.triangles {
            let Settled { pair, unit, facing, fit, .. } = settled;
            let corners = pair.target.triangles[t as usize];
            let [a, b, c] = corners.map(|v| fit[v as usize]);
            let barycentre = Point3::from((a.coords + b.coords + c.coords) / 3.0);
            let normal = (b - a).cross(&(c - a));
            let below = || corners.iter().filter_map(|&v| points[v as usize]);
            let under: Vec<u32> = below().filter_map(|point| triangle_of(&point)).collect();
            // None of them is farther than the point on it.
            let distance = |point: SurfacePoint| (point.position(pair.source, &unit.source) - barycentre).norm();
            let limit = below().map(distance).fold(0.0, f64::max) * (1.0 + 1e-9);
            let nearest = |accept: &dyn Fn(u32) -> bool| {
                let found = facing.find_among(&barycentre, limit, |t| under.contains(&t) && accept(t));
                found.map(|found| found.triangle)
            };
            let partner = nearest(&|t| facing.faces(t, &normal)).or_else(|| nearest(&|_| true));
            partners[t as usize] = partner.or(partners[t as usize]);
        }
    }
}

/// Reports `moves`, with a warning for each component that might as well lie elsewhere.
pub fn report(moves: &[Move], target: &Surface, figures: &mut Figures) {
    if moves.is_empty() {
        return;
    }
    figures.set("components_moved_to_one_side", moves.len());
    let components = target.components();
    for Move { component, .. } in moves.iter().filter(|moved| moved.tie) {
        figures.warn(format!(
            "component {} {} could lie on either side of the source; give it a marker",
            component.number,
            target.describe_components(&components, &[component.number])
        ));
    }
}

fn triangle_of(point: &SurfacePoint) -> Option<u32> {
    match point {
        SurfacePoint::Triangle(t, _) => Some(*t),
        SurfacePoint::Vertex(_) => None,
    }
}

impl Component {
    /// The place of vertex `v` among its vertices.
    fn place_of(&self, v: u32) -> usize {
        self.vertices.partition_point(|&other| other < v)
    }
}

/// The components of `target` that may move; none if it is only one.
fn small_components(target: &Surface) -> Vec<Component> {
    let components = target.components();
    if components.count() < 2 {
        return vec![];
    }
    let new = |number| Component { number, vertices: vec![], triangles: vec![], edges: vec![] };
    let mut result: Vec<Component> = (0..components.count()).map(new).collect();
    for (v, component) in components.of_vertex.iter().enumerate() {
        if let Some(component) = component {
            result[*component as usize].vertices.push(v as u32);
        }
    }
    for (t, [a, b, c]) in target.triangles.iter().copied().enumerate() {
        let Some(component) = components.of_vertex[a as usize] else { continue };
        let component = &mut result[component as usize];
        if component.vertices.len() <= MAX_VERTICES {
            component.triangles.push(t as u32);
            let sides = [[a, b], [b, c], [c, a]].into_iter().filter(|[u, v]| u != v);
            component.edges.extend(sides.map(|[u, v]| [u.min(v), u.max(v)]));
        }
    }
    result.retain(|component| component.vertices.len() <= MAX_VERTICES);
    for component in &mut result {
        component.edges.sort_unstable();
        component.edges.dedup();
    }
    result
}
