//! The minimum spanning tree of components, without measuring all their distances.

use std::{cmp::Reverse, collections::BinaryHeap};

use petgraph::{
    algo::min_spanning_tree,
    data::Element,
    graph::{NodeIndex, UnGraph},
    unionfind::UnionFind,
};

use crate::{parts::Part, sweep::Sweep};

/// The greatest distance of boxes that enter the queue first, in diagonals of the box of all.
const FIRST_REACH: f64 = 1.0 / 256.0;

/// A pair of components, smaller number first, under the shortest distance between their vertices.
///
/// As the weight of an edge it is totally ordered, for no distance is NaN: of equal distances the pair of smaller numbers
/// is the lighter. So there is one minimum spanning tree.
pub type Measured = (f64, [u32; 2]);

/// The minimum spanning tree of `parts`, by the pairs that are `allowed`, lightest edge first.
///
/// It is a forest, of fewer edges, if the allowed pairs do not join all parts.
pub fn tree(parts: &[Part], allowed: impl Fn(u32, u32) -> bool) -> Vec<Measured> {
    let candidates = candidates(parts, allowed);
    let mut graph = UnGraph::<(), Measured>::with_capacity(parts.len(), candidates.len());
    parts.iter().for_each(|_| _ = graph.add_node(()));
    for measured in candidates {
        let [a, b] = measured.1.map(NodeIndex::from);
        graph.add_edge(a, b, measured);
    }
    let edge = |element| match element {
        Element::Edge { weight, .. } => Some(weight),
        Element::Node { .. } => None,
    };
    min_spanning_tree(&graph).filter_map(edge).collect()
}

/// Allowed pairs of parts with their distances, among them every edge of the minimum spanning tree.
///
/// Pairs wait in a queue under a lower bound of their distance. One that comes to the front is measured, and waits again
/// under its distance. It is dropped unmeasured if its ends are joined by then: a path of pairs leads from one to the other
/// that came to the front with their distances. All of these lie below the bound of the dropped pair, since bounds precede
/// distances of the same value, and no pair comes back under less than its bound. So the dropped pair is the heaviest edge
/// of a cycle, which is no edge of a minimum spanning tree. The same holds for all that wait once everything is joined.
///
/// Pairs with greater bounds enter the queue when all with smaller ones have left it, unless they are joined by then.
fn candidates(parts: &[Part], allowed: impl Fn(u32, u32) -> bool) -> Vec<Measured> {
    let sweep = Sweep::new(parts);
    let bound = |[a, b]: [u32; 2]| parts[a as usize].box_distance(&parts[b as usize]);
    let mut queue = BinaryHeap::new();
    let mut candidates = Vec::new();
    let mut joined = UnionFind::<u32>::new(parts.len());
    let mut sets = parts.len();
    // All pairs with bounds up to this one have entered the queue.
    let mut entered = f64::NEG_INFINITY;
    while sets > 1 && entered < f64::INFINITY {
        let next = if entered > 0.0 { 2.0 * entered } else { FIRST_REACH * sweep.diagonal };
        let next = if next < sweep.diagonal { next } else { f64::INFINITY };
        for pair in (0..sweep.count()).flat_map(|place| sweep.near(place, next)) {
            let [a, b] = pair;
            let bound = bound(pair);
            if bound > entered && bound <= next && !joined.equiv(a, b) && allowed(a, b) {
                queue.push(Reverse(waiting(bound, false, pair)));
            }
        }
        entered = next;
        while sets > 1
            && let Some(&Reverse((value, is_distance, [a, b]))) = queue.peek()
            && f64::from_bits(value) <= entered
        {
            queue.pop();
            if joined.equiv(a, b) {
                continue;
            }
            if is_distance {
                joined.union(a, b);
                sets -= 1;
            } else {
                let distance = parts[a as usize].distance(&parts[b as usize]);
                candidates.push((distance, [a, b]));
                queue.push(Reverse(waiting(distance, true, [a, b])));
            }
        }
    }
    candidates
}

/// The place of a pair in the queue, under its distance or a lower bound.
///
/// Neither is negative, so that its bits sort as it does.
fn waiting(value: f64, is_distance: bool, pair: [u32; 2]) -> (u64, bool, [u32; 2]) {
    (value.to_bits(), is_distance, pair)
}
