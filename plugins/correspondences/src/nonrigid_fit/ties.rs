//! Ties between vertices that nothing else holds together.
//!
//! Gradients of elements do not change when a part moves. A part keeps its place by an element, or by an element of a link, that
//! reaches across to the rest. Triangles without an element, and links between coplanar components, have none. There two vertices
//! are tied to keep their offset at rest, with the energy weight ‖(x_j − x_i) − (r_j − r_i)‖².

use mimesh_core::{linalg::OuterSum, mesh::Surface, mesh::SurfacePoint, operators::Tetrahedron, stage::TransferPair};
use nalgebra::Point3;
use petgraph::unionfind::UnionFind;

use super::link_elements::{LinkElements, spread_pairs};

/// The weight of edges of triangles without an element where other elements hold both ends.
const WEAK: f64 = 1e-3;

/// Ties act like elements of their length. Shorter ones act like this length, in diagonals of the target.
const MIN_LENGTH: f64 = 0.01;

/// Two vertices that keep their offset.
pub struct Tie {
    vertices: [u32; 2],
    /// Relative to w_S.
    weight: f64,
}

impl Tie {
    fn strong(vertices: [u32; 2], rest: &[Point3<f64>], stiffness: f64) -> Self {
        let [a, b] = vertices.map(|v| rest[v as usize]);
        Self { vertices, weight: stiffness / (b - a).norm().max(MIN_LENGTH).powi(2) }
    }

    /// Adds `smoothness` times its energy to xᵀ A x − 2 bᵀ x; `rhs` is b, n × 3 by columns.
    pub fn add(&self, rest: &[Point3<f64>], smoothness: f64, blocks: &mut impl OuterSum, rhs: &mut [f64]) {
        let n = rhs.len() / 3;
        let weight = smoothness * self.weight;
        let [i, j] = self.vertices.map(|v| v as usize);
        blocks.add_outer(&self.vertices, &[[1.0], [-1.0]], weight);
        let offset = rest[i] - rest[j];
        for c in 0..3 {
            rhs[c * n + i] += weight * offset[c];
            rhs[c * n + j] -= weight * offset[c];
        }
    }
}

/// The ties of a target at `rest`: along edges of triangles without an element, and between components that only a link joins
/// whose elements do not reach across.
pub fn ties(
    rest: &[Point3<f64>],
    pair: TransferPair<'_>,
    elements: &[Option<Tetrahedron>],
    links: &[LinkElements],
    most_pairs: Option<usize>,
) -> Vec<Tie> {
    let surface = pair.target;
    let mut held = held_together(rest.len(), pair, elements, links);
    let mut ties: Vec<Tie> = degenerate_edges(surface, elements)
        .map(|edge| {
            let is_new = held.union(edge[0], edge[1]);
            if is_new { Tie::strong(edge, rest, 1.0) } else { Tie { vertices: edge, weight: WEAK } }
        })
        .collect();
    for link in pair.proximity.into_iter().flat_map(|graph| graph.links()) {
        if link.pairs.first().is_some_and(|&[i, j]| !held.equiv(i, j)) {
            for pair in spread_pairs(link, most_pairs) {
                held.union(pair[0], pair[1]);
                ties.push(Tie::strong(pair, rest, link.stiffness));
            }
        }
    }
    ties
}

/// Vertices in one set keep their places to each other; all that have a marker are in one.
fn held_together(
    vertex_count: usize,
    pair: TransferPair<'_>,
    elements: &[Option<Tetrahedron>],
    links: &[LinkElements],
) -> UnionFind<u32> {
    let mut held = UnionFind::new(vertex_count);
    let mut join = |unknowns: &[u32]| {
        // Fourth vertices come after all others.
        let mut vertices = unknowns.iter().copied().filter(|&v| (v as usize) < vertex_count);
        if let Some(first) = vertices.next() {
            vertices.for_each(|v| _ = held.union(first, v));
        }
    };
    elements.iter().flatten().for_each(|element| join(&element.unknowns));
    links.iter().for_each(|(a, b, _)| [a, b].into_iter().for_each(|element| join(&element.unknowns)));
    let marked: Vec<u32> = pair.markers.iter().map(|marker| most_of(&marker.target, pair.target)).collect();
    join(&marked);
    held
}

/// The vertex that has the largest part of a point.
fn most_of(point: &SurfacePoint, surface: &Surface) -> u32 {
    match *point {
        SurfacePoint::Vertex(v) => v,
        SurfacePoint::Triangle(t, barycentric) => {
            let most = (0..3).max_by(|&a, &b| barycentric[a].total_cmp(&barycentric[b])).unwrap_or(0);
            surface.triangles[t as usize][most]
        }
    }
}

/// The edges of triangles without an element.
fn degenerate_edges<'a>(
    surface: &'a Surface,
    elements: &'a [Option<Tetrahedron>],
) -> impl Iterator<Item = [u32; 2]> + 'a {
    let degenerate = surface.triangles.iter().zip(elements).filter(|(_, element)| element.is_none());
    degenerate.flat_map(|(&[a, b, c], _)| [[a, b], [b, c], [c, a]]).filter(|[i, j]| i != j)
}
