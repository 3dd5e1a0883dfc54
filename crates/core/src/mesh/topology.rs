use petgraph::unionfind::UnionFind;
use serde::{Deserialize, Serialize};

/// The edges and vertices at which triangles of a surface meet.
#[derive(Clone, Debug)]
pub struct Topology {
    /// Pairs of triangles that share an edge, each pair once, smaller triangle first, sorted.
    ///
    /// At an edge of more than two triangles (non-manifold) every pair is listed. At one of very many each is paired with the next few,
    /// so that there are not many more pairs than triangles.
    pub adjacent: Vec<[u32; 2]>,
    /// Edges of one triangle, as the triangle runs through them.
    pub boundary: Vec<[u32; 2]>,
    /// Edges of more than two triangles, smaller vertex first, sorted.
    pub non_manifold: Vec<[u32; 2]>,
    /// Number of edges.
    pub edge_count: usize,
}

/// At an edge, a triangle is paired with so many that come after it. Meshes that were modelled have fewer triangles at an edge.
const MAX_PARTNERS: usize = 4;

impl Topology {
    /// The topology of `triangles`; those with a repeated corner have no edges.
    pub fn new(triangles: &[[u32; 3]]) -> Self {
        let mut halves: Vec<([u32; 2], u32)> = Vec::with_capacity(triangles.len() * 3);
        for (t, &[a, b, c]) in triangles.iter().enumerate() {
            if a != b && b != c && c != a {
                halves.extend([[a, b], [b, c], [c, a]].map(|[u, v]| ([u.min(v), u.max(v)], t as u32)));
            }
        }
        let halves = sorted_by_place(&halves, |(ends, _)| ends[0]);
        let mut result = Self { adjacent: vec![], boundary: vec![], non_manifold: vec![], edge_count: 0 };
        for edge in halves.chunk_by(|a, b| a.0 == b.0) {
            result.edge_count += 1;
            match edge {
                [(ends, triangle)] => result.boundary.push(as_run(triangles[*triangle as usize], *ends)),
                [_, _] => {}
                _ => result.non_manifold.push(edge[0].0),
            }
            for (i, a) in edge.iter().enumerate() {
                result.adjacent.extend(edge[i + 1..].iter().take(MAX_PARTNERS).map(|b| [a.1, b.1]));
            }
        }
        result.adjacent = sorted_by_place(&result.adjacent, |pair| pair[0]);
        result.adjacent.dedup();
        result
    }
}

/// The edges of `triangles`, each once, smaller vertex first, sorted; those between a vertex and itself are none.
pub(super) fn edges(triangles: &[[u32; 3]]) -> Vec<[u32; 2]> {
    let mut edges: Vec<[u32; 2]> = Vec::with_capacity(3 * triangles.len());
    for &[a, b, c] in triangles {
        edges.extend([[a, b], [b, c], [c, a]].into_iter().filter(|[u, v]| u != v).map(|[u, v]| [u.min(v), u.max(v)]));
    }
    let mut edges = sorted_by_place(&edges, |edge| edge[0]);
    edges.dedup();
    edges
}

/// `items` sorted, where `place` is what they are sorted by first. Few have one place, so that counting them takes a fraction of the time of
/// comparing all.
fn sorted_by_place<T: Copy + Ord>(items: &[T], place: impl Fn(&T) -> u32) -> Vec<T> {
    let count = items.iter().map(&place).max().map_or(0, |last| last as usize + 1);
    let mut ends = vec![0usize; count + 1];
    items.iter().for_each(|item| ends[place(item) as usize + 1] += 1);
    (0..count).for_each(|p| ends[p + 1] += ends[p]);
    // Now starts; filling moves each to its end.
    let Some(&first) = items.first() else { return vec![] };
    let mut sorted = vec![first; items.len()];
    for item in items {
        let next = &mut ends[place(item) as usize];
        sorted[*next] = *item;
        *next += 1;
    }
    let mut start = 0;
    for &end in &ends[..count] {
        sorted[start..end].sort_unstable();
        start = end;
    }
    sorted
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
    fn counting_sorts_as_comparing_does() {
        let mut random = crate::testkit::random::Random::new(5);
        let mut number = |most: f64| ((random.vector().x + 1.0) * 0.5 * most) as u32;
        for (count, places) in [(0, 1.0), (1, 5.0), (500, 4.0), (500, 900.0)] {
            let items: Vec<[u32; 2]> = (0..count).map(|_| [number(places), number(9.0)]).collect();
            let mut expected = items.clone();
            expected.sort_unstable();
            assert_eq!(sorted_by_place(&items, |item| item[0]), expected);
        }
    }

    #[test]
    fn edges_are_listed_once_and_in_order() {
        assert_eq!(edges(&[[3, 1, 2], [2, 1, 0], [4, 4, 0]]), [[0, 1], [0, 2], [0, 4], [1, 2], [1, 3], [2, 3]]);
    }

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
    fn many_triangles_at_an_edge_have_few_pairs_each_and_stay_together() {
        let triangles: Vec<[u32; 3]> = (2..20_002).map(|v| [0, 1, v]).collect();
        let topology = Topology::new(&triangles);
        assert!(topology.adjacent.len() <= MAX_PARTNERS * triangles.len());
        assert!((0..19_999).all(|t| topology.adjacent.binary_search(&[t, t + 1]).is_ok()));
    }

    #[test]
    fn components_are_numbered_by_first_vertex_and_skip_loose_vertices() {
        let components = Components::new(8, &[[4, 5, 6], [1, 2, 3]]);
        assert_eq!(components.of_vertex, [None, Some(0), Some(0), Some(0), Some(1), Some(1), Some(1), None]);
        assert_eq!(components.sizes, [3, 3]);
    }
}
