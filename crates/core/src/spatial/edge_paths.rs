use std::{cmp::Reverse, collections::BinaryHeap};

use nalgebra::Point3;

use crate::mesh::Topology;

/// Distances along a surface, as lengths of shortest paths through its vertices.
///
/// Paths run along edges and straight across pairs of triangles that share an edge (from one apex to the other, unfolded): on
/// regular meshes they are at most some 4 % too long, where edges alone are 15 % too long. Unlike methods that solve for
/// distances they need nothing of the mesh: triangles may be thin, without area or three at an edge.
#[derive(Clone, Debug)]
pub struct EdgePaths {
    /// Where the neighbours of each vertex start; one entry more than there are vertices.
    starts: Vec<u32>,
    neighbours: Vec<(u32, f64)>,
}

/// A vertex in the queue, nearest first, ties by number.
#[derive(PartialEq)]
pub(super) struct Waiting(pub(super) f64, pub(super) u32);

impl Eq for Waiting {}

impl PartialOrd for Waiting {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Waiting {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0).then(self.1.cmp(&other.1))
    }
}

impl EdgePaths {
    /// Paths over `triangles`, and straight over the gaps between the pairs of vertices in `bridges`.
    pub fn new(positions: &[Point3<f64>], triangles: &[[u32; 3]], bridges: &[[u32; 2]]) -> Self {
        let length = |a: u32, b: u32| (positions[b as usize] - positions[a as usize]).norm();
        let sides = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        let mut edges: Vec<(u32, u32, f64)> =
            sides.chain(bridges.iter().copied()).map(|[a, b]| (a.min(b), a.max(b), length(a, b))).collect();
        for [s, t] in Topology::new(triangles).adjacent {
            let (s, t) = (triangles[s as usize], triangles[t as usize]);
            let apex = |of: [u32; 3], other: [u32; 3]| of.into_iter().find(|v| !other.contains(v));
            if let (Some(p), Some(q)) = (apex(s, t), apex(t, s)) {
                let shared: Vec<u32> = s.into_iter().filter(|&v| v != p).collect();
                let across = across(positions, [shared[0], shared[1]], p, q);
                edges.extend(across.map(|length| (p.min(q), p.max(q), length)));
            }
        }
        edges.retain(|edge| edge.0 != edge.1);
        edges.sort_unstable_by(|a, b| (a.0, a.1).cmp(&(b.0, b.1)).then(a.2.total_cmp(&b.2)));
        // The shortest of several ways between two vertices comes first.
        edges.dedup_by_key(|edge| (edge.0, edge.1));
        let mut starts = vec![0; positions.len() + 1];
        for &(a, b, _) in &edges {
            starts[a as usize + 1] += 1;
            starts[b as usize + 1] += 1;
        }
        (0..positions.len()).for_each(|v| starts[v + 1] += starts[v]);
        let mut next = starts.clone();
        let mut neighbours = vec![(0, 0.0); 2 * edges.len()];
        for (a, b, length) in edges {
            for (from, to) in [(a, b), (b, a)] {
                neighbours[next[from as usize] as usize] = (to, length);
                next[from as usize] += 1;
            }
        }
        Self { starts, neighbours }
    }

    /// The distance of each vertex (#V) to the nearest of `sources`; infinite where no path leads.
    pub fn distances(&self, sources: &[u32]) -> Vec<f64> {
        let mut distances = vec![f64::INFINITY; self.starts.len() - 1];
        sources.iter().for_each(|&source| self.shorten(&mut distances, source));
        distances
    }

    /// Lowers `distances` (#V) where `source` is nearer; takes time in proportion to how many are.
    pub fn shorten(&self, distances: &mut [f64], source: u32) {
        distances[source as usize] = 0.0;
        let mut queue = BinaryHeap::from([Reverse(Waiting(0.0, source))]);
        while let Some(Reverse(Waiting(distance, v))) = queue.pop() {
            if distance > distances[v as usize] {
                continue;
            }
            for &(neighbour, length) in self.neighbours(v) {
                if distance + length < distances[neighbour as usize] {
                    distances[neighbour as usize] = distance + length;
                    queue.push(Reverse(Waiting(distance + length, neighbour)));
                }
            }
        }
    }

    /// The vertices one step from `v`, with the lengths of the steps.
    pub fn neighbours(&self, v: u32) -> &[(u32, f64)] {
        &self.neighbours[self.starts[v as usize] as usize..self.starts[v as usize + 1] as usize]
    }
}

/// The straight way from p to q across the edge that their triangles share, unfolded into a plane, if it crosses that edge.
fn across(positions: &[Point3<f64>], [a, b]: [u32; 2], p: u32, q: u32) -> Option<f64> {
    let at = |v: u32| positions[v as usize];
    let edge = at(b) - at(a);
    let unit = edge.try_normalize(0.0)?;
    // Along the edge, and away from it.
    let flat = |v: u32| {
        let way = at(v) - at(a);
        (way.dot(&unit), way.cross(&unit).norm())
    };
    let ((px, py), (qx, qy)) = (flat(p), flat(q));
    if py + qy <= 0.0 {
        return None;
    }
    let crossing = px + (qx - px) * py / (py + qy);
    (0.0..=edge.norm()).contains(&crossing).then(|| (qx - px).hypot(py + qy))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testkit::meshes;

    #[test]
    fn distances_on_a_square_are_those_of_the_plane_within_some_percent() {
        let grid = meshes::grid(30, 30);
        let paths = EdgePaths::new(&grid.positions, &grid.triangles, &[]);
        let distances = paths.distances(&[0]);
        for (d, p) in distances.iter().zip(&grid.positions) {
            let straight = p.coords.norm();
            // Never shorter; directions between those of edges and diagonals are the worst.
            assert!(*d >= straight - 1e-12 && *d <= 1.06 * straight + 1e-12, "{d} for {straight}");
        }
    }

    #[test]
    fn a_path_over_two_triangles_is_straight() {
        let p = |x: f64, y: f64, z: f64| Point3::new(x, y, z);
        // Folded by a right angle along the edge from 0 to 1.
        let positions = [p(0., 0., 0.), p(1., 0., 0.), p(0.5, 1., 0.), p(0.5, 0., 1.)];
        let paths = EdgePaths::new(&positions, &[[0, 1, 2], [1, 0, 3]], &[]);
        assert!((paths.distances(&[2])[3] - 2.0).abs() < 1e-15, "1 on each side of the fold");
    }

    #[test]
    fn bridges_lead_to_other_components_and_nothing_else_does() {
        let two = meshes::two_components();
        let alone = EdgePaths::new(&two.positions, &two.triangles, &[]).distances(&[0]);
        assert!(alone[..42].iter().all(|d| d.is_finite()) && alone[42..].iter().all(|d| d.is_infinite()));
        let bridged = EdgePaths::new(&two.positions, &two.triangles, &[[0, 42]]).distances(&[0]);
        // The second sphere is the first moved by 3.
        assert!((bridged[42] - 3.0).abs() < 1e-12 && (bridged[50] - 3.0 - alone[8]).abs() < 1e-12);
    }
}
