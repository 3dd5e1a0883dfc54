//! A tree of bounding boxes over triangles, built at rest and refitted to each pose.

use nalgebra::Point3;
use rayon::prelude::*;

/// A box by its smallest and largest corner.
#[derive(Clone, Copy)]
struct Bounds([f64; 3], [f64; 3]);

impl Bounds {
    const EMPTY: Self = Self([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);

    fn of(corners: &[Point3<f64>; 3]) -> Self {
        let [a, b, c] = corners;
        let low = |k: usize| a[k].min(b[k]).min(c[k]);
        let high = |k: usize| a[k].max(b[k]).max(c[k]);
        Self([low(0), low(1), low(2)], [high(0), high(1), high(2)])
    }

    fn joined(&self, other: &Self) -> Self {
        let low = |k: usize| self.0[k].min(other.0[k]);
        let high = |k: usize| self.1[k].max(other.1[k]);
        Self([low(0), low(1), low(2)], [high(0), high(1), high(2)])
    }

    fn meets(&self, other: &Self) -> bool {
        (0..3).all(|k| self.0[k] <= other.1[k] && other.0[k] <= self.1[k])
    }
}

/// Triangles in a leaf.
const MAX_LEAF: usize = 4;

struct Node {
    /// Its triangles, by their indices in `order`.
    range: std::ops::Range<u32>,
    /// The index of its second child, 0 for a leaf; the first child follows the node itself.
    second: u32,
}

/// A binary tree over triangles, split at medians of their barycentres at rest.
pub struct TriangleTree {
    /// The nodes, each before its children.
    nodes: Vec<Node>,
    leaves: Vec<u32>,
    /// Triangles in the order of the leaves.
    order: Vec<u32>,
}

impl TriangleTree {
    /// The tree of `triangles` over `positions`.
    pub fn new(positions: &[Point3<f64>], triangles: &[[u32; 3]]) -> Self {
        let barycentre =
            |t: &[u32; 3]| t.iter().map(|&v| positions[v as usize].coords / 3.0).sum::<nalgebra::Vector3<f64>>();
        let barycentres: Vec<[f64; 3]> = triangles.iter().map(|t| barycentre(t).into()).collect();
        let order = (0..triangles.len() as u32).collect();
        let mut tree = Self { nodes: vec![], leaves: vec![], order };
        if !triangles.is_empty() {
            tree.split(0..triangles.len(), &barycentres);
        }
        tree
    }

    fn split(&mut self, range: std::ops::Range<usize>, barycentres: &[[f64; 3]]) {
        let node = self.nodes.len();
        self.nodes.push(Node { range: range.start as u32..range.end as u32, second: 0 });
        if range.len() <= MAX_LEAF {
            self.leaves.push(node as u32);
            return;
        }
        let part = &mut self.order[range.clone()];
        let extent = |k: usize| {
            let along = part.iter().map(|&t| barycentres[t as usize][k]);
            let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
            high - low
        };
        let extents = [extent(0), extent(1), extent(2)];
        let axis = (0..3).fold(0, |best, k| if extents[k] > extents[best] { k } else { best });
        let half = part.len() / 2;
        part.select_nth_unstable_by(half, |a, b| {
            barycentres[*a as usize][axis].total_cmp(&barycentres[*b as usize][axis]).then(a.cmp(b))
        });
        self.split(range.start..range.start + half, barycentres);
        self.nodes[node].second = self.nodes.len() as u32;
        self.split(range.start + half..range.end, barycentres);
    }

    /// Pairs of triangles whose boxes at `positions` meet and that `is_wanted` accepts, smaller number first, sorted.
    pub fn pairs(
        &self,
        positions: &[Point3<f64>],
        triangles: &[[u32; 3]],
        is_wanted: impl Fn(u32, u32) -> bool + Sync,
    ) -> Vec<[u32; 2]> {
        let corners = |t: u32| triangles[t as usize].map(|v| positions[v as usize]);
        // A triangle with a corner that is not finite has an empty box.
        let bounds = |&t: &u32| {
            let corners = corners(t);
            let finite = corners.iter().all(crate::vertex_field::is_finite);
            if finite { Bounds::of(&corners) } else { Bounds::EMPTY }
        };
        let boxes: Vec<Bounds> = self.order.par_iter().with_min_len(4096).map(bounds).collect();
        let mut of_node = vec![Bounds::EMPTY; self.nodes.len()];
        for (k, node) in self.nodes.iter().enumerate().rev() {
            of_node[k] = if node.second == 0 {
                let range = node.range.start as usize..node.range.end as usize;
                boxes[range].iter().fold(Bounds::EMPTY, |sum, b| sum.joined(b))
            } else {
                of_node[k + 1].joined(&of_node[node.second as usize])
            };
        }
        let of_leaf = |&leaf: &u32| {
            let mut found = Vec::new();
            let mut open = vec![0u32];
            let own = &self.nodes[leaf as usize].range;
            while let Some(k) = open.pop() {
                let node = &self.nodes[k as usize];
                // Each pair is found by the leaf that comes first.
                if node.range.end <= own.start || !of_node[k as usize].meets(&of_node[leaf as usize]) {
                    continue;
                }
                if node.second > 0 {
                    open.extend([node.second, k + 1]);
                    continue;
                }
                for i in own.clone() {
                    for j in node.range.start.max(i + 1)..node.range.end {
                        if boxes[i as usize].meets(&boxes[j as usize]) {
                            let (a, b) = (self.order[i as usize], self.order[j as usize]);
                            let (a, b) = (a.min(b), a.max(b));
                            if is_wanted(a, b) {
                                found.push([a, b]);
                            }
                        }
                    }
                }
            }
            found
        };
        let mut pairs: Vec<[u32; 2]> = self.leaves.par_iter().with_min_len(64).flat_map_iter(of_leaf).collect();
        pairs.sort_unstable();
        pairs
    }
}

#[cfg(test)]
mod tests {
    use mimesh_core::testkit::{meshes, random::Random};

    use super::*;

    #[test]
    fn pairs_are_those_of_comparing_all_with_all_also_after_a_motion() {
        let surface = meshes::icosphere(2);
        let tree = TriangleTree::new(&surface.positions, &surface.triangles);
        let mut random = Random::new(3);
        let posed: Vec<_> = surface.positions.iter().map(|p| p + random.vector() * 0.3).collect();
        for positions in [&surface.positions, &posed] {
            let boxes: Vec<_> =
                (0..surface.triangle_count()).map(|t| Bounds::of(&surface.corners(positions, t))).collect();
            let count = boxes.len() as u32;
            let all = (0..count).flat_map(|a| (a + 1..count).map(move |b| [a, b]));
            let expected: Vec<_> = all.filter(|[a, b]| boxes[*a as usize].meets(&boxes[*b as usize])).collect();
            assert_eq!(tree.pairs(positions, &surface.triangles, |_, _| true), expected);
        }
    }
}
