use std::{cmp::Reverse, collections::BinaryHeap};

use nalgebra::Point3;
use petgraph::unionfind::UnionFind;

use super::{EdgePaths, edge_paths::Waiting};
use crate::mesh::{Surface, SurfacePoint};

/// Distances between points of a surface along [`EdgePaths`], up to a limit.
///
/// Two points of one triangle are their straight distance apart. A path between other points enters and leaves by corners of their
/// triangles. So it is up to the longest edge of the two triangles too long, beside the error of the paths themselves.
///
/// Bridges lead from one component to another. Where no path leads at all, the distance is straight.
pub struct SurfaceDistance<'a> {
    surface: &'a Surface,
    positions: &'a [Point3<f64>],
    paths: EdgePaths,
    /// Vertices with a path between them have the same number.
    joined: Vec<u32>,
}

/// Memory of searches, so that each takes time in proportion to the vertices it visits; one a thread.
pub struct DistanceSearch {
    /// #V; infinite but for `visited`.
    distances: Vec<f64>,
    visited: Vec<u32>,
    queue: BinaryHeap<Reverse<Waiting>>,
}

impl<'a> SurfaceDistance<'a> {
    /// Distances on `surface` with its vertices at `positions` (#V), in their unit; `bridges` are pairs of vertices.
    pub fn new(surface: &'a Surface, positions: &'a [Point3<f64>], bridges: &[[u32; 2]]) -> Self {
        let mut sets = UnionFind::<u32>::new(positions.len());
        for &[a, b, c] in &surface.triangles {
            sets.union(a, b);
            sets.union(b, c);
        }
        bridges.iter().for_each(|&[a, b]| _ = sets.union(a, b));
        let paths = EdgePaths::new(positions, &surface.triangles, bridges);
        Self { surface, positions, paths, joined: sets.into_labeling() }
    }

    /// Memory for searches on this surface.
    pub fn search(&self) -> DistanceSearch {
        let distances = vec![f64::INFINITY; self.positions.len()];
        DistanceSearch { distances, visited: vec![], queue: BinaryHeap::new() }
    }

    /// An upper bound of the distance between two points that needs no search: over a corner of both triangles; infinite if they share
    /// none.
    pub fn bound(&self, from: &SurfacePoint, to: &SurfacePoint) -> f64 {
        let [start, goal] = [from, to].map(|point| point.position(self.surface, self.positions));
        let over = |v: u32| (self.positions[v as usize] - start).norm() + (goal - self.positions[v as usize]).norm();
        let shared = self.corners(from).iter().filter(|v| self.corners(to).contains(v));
        shared.map(|&v| over(v)).fold(f64::INFINITY, f64::min)
    }

    /// The longest edge of the triangle of a point; 0 for a vertex.
    pub fn longest_edge(&self, point: &SurfacePoint) -> f64 {
        let SurfacePoint::Triangle(t, _) = point else { return 0.0 };
        let [a, b, c] = self.surface.corners(self.positions, *t as usize);
        (b - a).norm().max((c - b).norm()).max((a - c).norm())
    }

    /// The distance between two points; infinite if it is above `limit`.
    pub fn between(&self, from: &SurfacePoint, to: &SurfacePoint, limit: f64, search: &mut DistanceSearch) -> f64 {
        let [start, goal] = [from, to].map(|point| point.position(self.surface, self.positions));
        let straight = (goal - start).norm();
        let up_to_limit = |distance: f64| if distance <= limit { distance } else { f64::INFINITY };
        let (from, to) = (self.corners(from), self.corners(to));
        let is_one_triangle = from.iter().all(|v| to.contains(v)) || to.iter().all(|v| from.contains(v));
        if is_one_triangle || straight > limit || self.joined[from[0] as usize] != self.joined[to[0] as usize] {
            return up_to_limit(straight);
        }
        // Dijkstra's search, directed at the goal: no path is shorter than the straight way.
        let ahead = |v: u32| (goal - self.positions[v as usize]).norm();
        search.clear();
        for &v in from {
            search.reach(v, (self.positions[v as usize] - start).norm(), ahead(v));
        }
        let mut shortest = f64::INFINITY;
        while let Some(Reverse(Waiting(estimate, v))) = search.queue.pop() {
            if estimate >= shortest || estimate > limit {
                break;
            }
            let distance = search.distances[v as usize];
            if estimate > distance + ahead(v) {
                continue;
            }
            if to.contains(&v) {
                shortest = shortest.min(distance + ahead(v));
            }
            for &(neighbour, length) in self.paths.neighbours(v) {
                search.reach(neighbour, distance + length, ahead(neighbour));
            }
        }
        up_to_limit(shortest)
    }

    /// Finds the vertices nearer to `centre` than `radius`, for [`DistanceSearch::distance`].
    pub fn ball(&self, centre: &SurfacePoint, radius: f64, search: &mut DistanceSearch) {
        let start = centre.position(self.surface, self.positions);
        search.clear();
        for &v in self.corners(centre) {
            search.reach(v, (self.positions[v as usize] - start).norm(), 0.0);
        }
        while let Some(Reverse(Waiting(distance, v))) = search.queue.pop() {
            if distance > search.distances[v as usize] {
                continue;
            }
            for &(neighbour, length) in self.paths.neighbours(v) {
                if distance + length < radius {
                    search.reach(neighbour, distance + length, 0.0);
                }
            }
        }
    }

    fn corners<'b>(&'b self, point: &'b SurfacePoint) -> &'b [u32] {
        match point {
            SurfacePoint::Vertex(v) => std::slice::from_ref(v),
            SurfacePoint::Triangle(t, _) => &self.surface.triangles[*t as usize],
        }
    }
}

impl DistanceSearch {
    /// The distance of vertex `v` to the centre of the last [`ball`](SurfaceDistance::ball); infinite outside it.
    pub fn distance(&self, v: u32) -> f64 {
        self.distances[v as usize]
    }

    fn clear(&mut self) {
        self.visited.drain(..).for_each(|v| self.distances[v as usize] = f64::INFINITY);
        self.queue.clear();
    }

    /// Puts `v` in the queue if it is nearer than known; `ahead` is a lower bound of what remains.
    fn reach(&mut self, v: u32, distance: f64, ahead: f64) {
        let known = &mut self.distances[v as usize];
        if distance < *known {
            if known.is_infinite() {
                self.visited.push(v);
            }
            *known = distance;
            self.queue.push(Reverse(Waiting(distance + ahead, v)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testkit::{meshes, random::Random};

    /// The distance by paths from all corners, without a limit.
    fn exhaustive(surface: &Surface, a: &SurfacePoint, b: &SurfacePoint) -> f64 {
        let paths = EdgePaths::new(&surface.positions, &surface.triangles, &[]);
        let [p, q] = [a, b].map(|point| point.position(surface, &surface.positions));
        let mut shortest = f64::INFINITY;
        for (v, _) in a.corners(surface) {
            let distances = paths.distances(&[v]);
            for (w, _) in b.corners(surface) {
                let ends = (surface.positions[v as usize] - p).norm() + (surface.positions[w as usize] - q).norm();
                shortest = shortest.min(ends + distances[w as usize]);
            }
        }
        shortest
    }

    #[test]
    fn directed_searches_find_the_shortest_paths_up_to_their_limit() {
        let surface = meshes::icosphere(3);
        let distance = SurfaceDistance::new(&surface, &surface.positions, &[]);
        let mut search = distance.search();
        let mut random = Random::new(3);
        let mut point = || {
            let triangle = (random.unit() * surface.triangle_count() as f64) as u32;
            SurfacePoint::Triangle(triangle, [0.5, 0.3, 0.2])
        };
        for _ in 0..50 {
            let (a, b) = (point(), point());
            if a == b {
                continue;
            }
            let expected = exhaustive(&surface, &a, &b);
            let found = distance.between(&a, &b, f64::INFINITY, &mut search);
            // Sums of a dozen lengths in another order.
            assert!((found - expected).abs() < 1e-12, "{found}, expected {expected}");
            assert!(distance.bound(&a, &b) > found - 1e-12);
            assert_eq!(distance.between(&a, &b, 1.0001 * expected, &mut search), found);
            assert_eq!(distance.between(&a, &b, 0.9999 * expected, &mut search), f64::INFINITY);
        }
    }

    #[test]
    fn balls_hold_the_vertices_within_their_radius() {
        let surface = meshes::grid(12, 12);
        let distance = SurfaceDistance::new(&surface, &surface.positions, &[]);
        let mut search = distance.search();
        distance.ball(&SurfacePoint::Vertex(40), 0.3, &mut search);
        let all = EdgePaths::new(&surface.positions, &surface.triangles, &[]).distances(&[40]);
        for (v, expected) in all.iter().enumerate() {
            let expected = if *expected < 0.3 { *expected } else { f64::INFINITY };
            assert_eq!(search.distance(v as u32), expected);
        }
    }

    #[test]
    fn bridges_join_components_and_without_them_distances_are_straight() {
        let two = meshes::two_components();
        let (a, b) = (SurfacePoint::Vertex(8), SurfacePoint::Vertex(50));
        let apart = SurfaceDistance::new(&two, &two.positions, &[]);
        // The second sphere is the first moved by 3.
        assert_eq!(apart.between(&a, &b, 4.0, &mut apart.search()), 3.0);
        let bridged = SurfaceDistance::new(&two, &two.positions, &[[0, 42]]);
        let around = EdgePaths::new(&two.positions, &two.triangles, &[]).distances(&[0])[8];
        let found = bridged.between(&a, &b, 10.0, &mut bridged.search());
        assert!((found - (2.0 * around + 3.0)).abs() < 1e-12, "{found}");
    }
}
