use petgraph::unionfind::UnionFind;
use serde::{Deserialize, Serialize};

/// The edges and vertices at which triangles of a surface meet.
#[derive(Clone, Debug)]
pub struct Topology {
    /// Pairs of triangles that share an edge, each pair once, smaller triangle first, sorted.
    ///
    /// At an edge of more than two triangles (non-manifold) every pair is listed.
    pub adjacent: Vec<[u32; 2]>,
    /// Edges of one triangle, as the triangle runs through them.
    pub boundary: Vec<[u32; 2]>,
    /// Edges of more than two triangles, smaller vertex first, sorted.
    pub non_manifold: Vec<[u32; 2]>,
    /// Number of edges.
    pub edge_count: usize,
}

impl Topology {
    /// The topology of `triangles`; those with a repeated corner have no edges.
    pub fn new(triangles: &[[u32; 3]]) -> Self {
        let mut halves: Vec<([u32; 2], u32)> = Vec::with_capacity(triangles.len() * 3);
        for (t, &[a, b, c]) in triangles.iter().enumerate() {
            if a != b && b != c && c != a {
                halves.extend([[a, b], [b, c], [c, a]].map(|[u, v]| ([u.min(v), u.max(v)], t as u32)));
            }
        }
        halves.sort_unstable();
        let mut result = Self { adjacent: vec![], boundary: vec![], non_manifold: vec![], edge_count: 0 };
        for edge in halves.chunk_by(|a, b| a.0 == b.0) {
            result.edge_count += 1;
            match edge {
                [(ends, triangle)] => result.boundary.push(as_run(triangles[*triangle as usize], *ends)),
                [_, _] => {}
                _ => result.non_manifold.push(edge[0].0),
            }
            for (i, a) in edge.iter().enumerate() {
                result.adjacent.extend(edge[i + 1..].iter().map(|b| [a.1, b.1]));
            }
        }
        result.adjacent.sort_unstable();
        result.adjacent.dedup();
        result
    }
}

/// The edge `ends` in the direction in which `triangle` runs through it.
fn as_run([a, b, c]: [u32; 3], ends: [u32; 2]) -> [u32; 2] {
    [[a, b], [b, c], [c, a]].into_iter().find(|[u, v]| [*u.min(v), *u.max(v)] == ends).unwrap_or(ends)
}

/// The connected components of a surface: vertices joined by triangles.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Components {
    /// For each vertex its component, numbered by first vertex; `None` for vertices without a triangle.
    pub of_vertex: Vec<Option<u32>>,
    /// Number of vertices of each component.
    pub sizes: Vec<usize>,
}

impl Components {
    /// The components of `triangles` over `vertex_count` vertices.
    pub fn new(vertex_count: usize, triangles: &[[u32; 3]]) -> Self {
        let mut sets = UnionFind::<u32>::new(vertex_count);
        let mut used = vec![false; vertex_count];
        for &[a, b, c] in triangles {
            sets.union(a, b);
            sets.union(b, c);
            [a, b, c].into_iter().for_each(|v| used[v as usize] = true);
        }
        let mut numbers = vec![u32::MAX; vertex_count];
        let mut sizes = Vec::new();
        let of_vertex = (0..vertex_count as u32)
            .map(|v| {
                used[v as usize].then(|| {
                    let number = &mut numbers[sets.find_mut(v) as usize];
                    if *number == u32::MAX {
                        *number = sizes.len() as u32;
                        sizes.push(0);
                    }
                    sizes[*number as usize] += 1;
                    *number
                })
            })
            .collect();
        Self { of_vertex, sizes }
    }

    /// Number of components.
    pub fn count(&self) -> usize {
        self.sizes.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_triangles_share_one_edge_and_have_four_boundary_edges() {
        let topology = Topology::new(&[[0, 1, 2], [2, 1, 3]]);
        assert_eq!(topology.adjacent, [[0, 1]]);
        assert_eq!(topology.boundary.len(), 4);
        assert_eq!(topology.edge_count, 5);
        assert!(topology.boundary.contains(&[2, 0]), "the boundary runs as the triangle does");
    }

    #[test]
    fn three_triangles_at_an_edge_are_all_adjacent_and_the_edge_is_non_manifold() {
        let topology = Topology::new(&[[0, 1, 2], [1, 0, 3], [0, 1, 4]]);
        assert_eq!(topology.adjacent, [[0, 1], [0, 2], [1, 2]]);
        assert_eq!(topology.non_manifold, [[0, 1]]);
    }

    #[test]
    fn components_are_numbered_by_first_vertex_and_skip_loose_vertices() {
        let components = Components::new(8, &[[4, 5, 6], [1, 2, 3]]);
        assert_eq!(components.of_vertex, [None, Some(0), Some(0), Some(0), Some(1), Some(1), Some(1), None]);
        assert_eq!(components.sizes, [3, 3]);
    }
}
