//! The tree against brute force, and what settings do.

use std::collections::BTreeSet;

use mimesh_core::{
    mesh::{Mesh, Part, Surface},
    stage::{ComponentRef, Proximity, ProximityGraph},
    testkit::random::Random,
};
use mimesh_proximity::spanning_tree::{Pairs, SpanningTree};
use nalgebra::Point3;
use proptest::prelude::*;

/// `count` small triangles or tetrahedra; on a grid of whole numbers if `ties`, so that many distances are equal.
fn scattered(seed: u64, count: usize, ties: bool) -> Surface {
    let mut random = Random::new(seed);
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for _ in 0..count {
        let start = positions.len() as u32;
        let mut place = random.vector() * 6.0;
        if ties {
            place = place.map(f64::round) * 3.0;
        }
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        positions.extend(corners.map(|c| Point3::from(c) + place));
        triangles.extend([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]].map(|t: [u32; 3]| t.map(|v| v + start)));
    }
    Surface::from_triangles(positions, triangles).unwrap()
}

/// The shortest distance between vertices of each two components.
fn distances(surface: &Surface) -> Vec<Vec<f64>> {
    let components = surface.components();
    let n = components.count();
    let mut distance = vec![vec![f64::INFINITY; n]; n];
    for (i, p) in surface.positions.iter().enumerate() {
        for (j, q) in surface.positions.iter().enumerate() {
            if let (Some(a), Some(b)) = (components.of_vertex[i], components.of_vertex[j]) {
                let d = &mut distance[a as usize][b as usize];
                *d = d.min((p - q).norm());
            }
        }
    }
    distance
}

fn links(graph: &ProximityGraph) -> Vec<[u32; 2]> {
    graph.links().map(|link| link.components).collect()
}

/// The tree of Kruskal 1956 over all pairs that are not forbidden, by distance and then by pair, lightest first.
fn kruskal(distance: &[Vec<f64>], forbidden: &BTreeSet<[u32; 2]>) -> Vec<[u32; 2]> {
    let count = distance.len() as u32;
    let all = (0..count).flat_map(|a| (a + 1..count).map(move |b| [a, b]));
    let mut pairs: Vec<[u32; 2]> = all.filter(|pair| !forbidden.contains(pair)).collect();
    let of = |[a, b]: [u32; 2]| distance[a as usize][b as usize];
    pairs.sort_by(|&p, &q| of(p).total_cmp(&of(q)).then(p.cmp(&q)));
    let mut set: Vec<u32> = (0..count).collect();
    let mut tree = Vec::new();
    for [a, b] in pairs {
        let [from, to] = [set[a as usize], set[b as usize]];
        if from != to {
            set.iter_mut().filter(|s| **s == from).for_each(|s| *s = to);
            tree.push([a, b]);
        }
    }
    tree
}

proptest! {
    /// On the grid of whole numbers most distances are shared by many pairs, and exact.
    #[test]
    fn the_tree_is_kruskals_by_distance_and_pair(
        seed: u64, count in 2usize..40, ties: bool, forbidden in prop::collection::btree_set((0u32..40, 0u32..40), 0..60)
    ) {
        let surface = scattered(seed, count, ties);
        let distance = distances(&surface);
        let count = distance.len() as u32;
        let pairs = forbidden.into_iter().map(|(a, b)| [a.min(b), a.max(b)]);
        let forbidden: BTreeSet<[u32; 2]> = pairs.filter(|[a, b]| a < b && *b < count).collect();
        let forbid = forbidden.iter().map(|pair| pair.map(ComponentRef::Number)).collect();
        let stage = SpanningTree { epsilon_factor: 0.0, forbid, ..SpanningTree::default() };
        let mut expected = kruskal(&distance, &forbidden);
        let Ok(graph) = stage.proximity(&surface) else {
            prop_assert!(expected.len() + 1 < distance.len(), "refused, though {:?} joins all", expected);
            return Ok(());
        };
        let tree: Vec<_> = graph.links().filter(|link| link.in_tree).collect();
        expected.sort_unstable();
        prop_assert_eq!(tree.iter().map(|link| link.components).collect::<Vec<_>>(), expected);
        for link in tree {
            let [a, b] = link.components.map(|c| c as usize);
            prop_assert!((link.distance - distance[a][b]).abs() < 1e-12, "{a} {b}");
        }
    }
}

/// Most pairs lie too far apart to be looked at, and some of the tree's edges bridge distances of all sizes.
#[test]
fn islands_far_from_each_other_are_joined_as_kruskal_joins_them() {
    for seed in 0..20 {
        let mut surface = scattered(seed, 60, false);
        let components = surface.components();
        for (p, c) in surface.positions.iter_mut().zip(&components.of_vertex) {
            let island = c.unwrap() % 4;
            p.x += 4.0 * 10f64.powi(island as i32);
        }
        let graph = SpanningTree { epsilon_factor: 0.0, ..SpanningTree::default() }.proximity(&surface).unwrap();
        let mut expected = kruskal(&distances(&surface), &BTreeSet::new());
        expected.sort_unstable();
        let tree: Vec<_> = graph.links().filter(|link| link.in_tree).map(|link| link.components).collect();
        assert_eq!(tree, expected, "{seed}");
    }
}

#[test]
fn more_links_are_those_as_close_as_the_rule_says() {
    for seed in 0..20 {
        let surface = scattered(seed, 30, false);
        let distance = distances(&surface);
        let graph = SpanningTree::default().proximity(&surface).unwrap();
        // The longest edge of every component is √2.
        let epsilon = 1.5 * 2f64.sqrt();
        let mut reach = [0.0f64; 30];
        for link in graph.links().filter(|link| link.in_tree) {
            link.components.iter().for_each(|&c| reach[c as usize] = reach[c as usize].max(link.distance));
        }
        for a in 0..30u32 {
            for b in a + 1..30 {
                let d = distance[a as usize][b as usize];
                let close = d <= reach[a as usize] + epsilon && d <= reach[b as usize] + epsilon;
                assert_eq!(links(&graph).contains(&[a, b]), close, "{seed}: {a} {b}");
            }
        }
    }
}

#[test]
fn links_are_forbidden_added_and_welded_by_name_or_number() {
    let bare = scattered(3, 4, false);
    let mut mesh = Mesh::from_triangles(bare.positions.clone(), &bare.triangles);
    mesh.parts = ["head", "jaw", "eye", "tooth"]
        .into_iter()
        .enumerate()
        .map(|(k, name)| Part { object: Some(name.into()), polygons: 4 * k..4 * (k + 1), ..Part::default() })
        .collect();
    let surface = Surface::new(&mesh).unwrap();
    let name = |name: &str| ComponentRef::Name(name.into());
    let near = SpanningTree { epsilon_factor: 0.0, ..SpanningTree::default() };
    let plain = near.proximity(&surface).unwrap();
    let [a, b] = links(&plain)[0];

    let forbidding = SpanningTree { forbid: vec![[ComponentRef::Number(b), ComponentRef::Number(a)]], ..near.clone() };
    let graph = forbidding.proximity(&surface).unwrap();
    assert!(!links(&graph).contains(&[a, b]) && graph.links().filter(|link| link.in_tree).count() == 3);

    let absent =
        [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]].into_iter().find(|p| !links(&plain).contains(p)).unwrap();
    let names = ["head", "jaw", "eye", "tooth"];
    let asked = [name(names[absent[0] as usize]), name(names[absent[1] as usize])];
    let graph = SpanningTree { weld: vec![asked.clone()], ..near.clone() }.proximity(&surface).unwrap();
    let welded = graph.links().find(|link| link.components == absent).expect("the welded link");
    assert!(welded.stiffness > 1.0 && !welded.in_tree);
    assert!(links(&SpanningTree { add: vec![asked], ..near.clone() }.proximity(&surface).unwrap()).contains(&absent));

    let error =
        SpanningTree { add: vec![[name("head"), name("haed")]], ..near.clone() }.proximity(&surface).unwrap_err();
    assert_eq!(
        error.to_string(),
        "the target has no component `haed`: expected 0 to 3, a name, or `all`; the mesh has parts head, jaw, eye, tooth"
    );
    let all = [[0, 1], [0, 2], [0, 3]].map(|[a, b]| [ComponentRef::Number(a), ComponentRef::Number(b)]);
    let error = SpanningTree { forbid: all.to_vec(), ..near }.proximity(&surface).unwrap_err();
    assert_eq!(error.to_string(), "forbidden links leave components without any tie to the rest");
}

#[test]
fn all_pairs_within_the_distance_are_those_of_brute_force() {
    for seed in 0..5 {
        let surface = scattered(seed, 12, false);
        let components = surface.components();
        let graph =
            SpanningTree { pairs: Pairs::All, max_pairs: 1, ..SpanningTree::default() }.proximity(&surface).unwrap();
        let mut pairs_seen = 0;
        for link in graph.links() {
            // The longest edge of every component is √2.
            let limit = link.distance + 1.5 * 2f64.sqrt();
            let of = |c: u32| {
                let of_vertex = &components.of_vertex;
                (0..surface.vertex_count() as u32).filter(move |&v| of_vertex[v as usize] == Some(c))
            };
            let [a, b] = link.components;
            let near =
                |&[v, w]: &[u32; 2]| (surface.positions[v as usize] - surface.positions[w as usize]).norm() <= limit;
            let expected: BTreeSet<[u32; 2]> = of(a).flat_map(|v| of(b).map(move |w| [v, w])).filter(near).collect();
            assert_eq!(link.pairs.iter().copied().collect::<BTreeSet<_>>(), expected, "{seed}: {a} {b}");
            pairs_seen += expected.len();
        }
        assert!(pairs_seen > 2 * graph.links().count(), "more than the closest pairs");
    }
}

#[test]
fn pairs_are_capped_and_spread_over_the_gap() {
    let bar = mimesh_core::testkit::meshes::bar([20, 2, 2], [4.0, 0.2, 0.2]);
    let n = bar.vertex_count() as u32;
    let mut positions = bar.positions.clone();
    positions.extend(bar.positions.iter().map(|p| p + nalgebra::Vector3::new(0.0, 0.3, 0.0)));
    let mut triangles = bar.triangles.clone();
    triangles.extend(bar.triangles.iter().map(|t| t.map(|v| v + n)));
    let surface = Surface::from_triangles(positions, triangles).unwrap();
    let graph = SpanningTree { max_pairs: 10, ..SpanningTree::default() }.proximity(&surface).unwrap();
    let pairs = &graph.links().next().unwrap().pairs;
    assert_eq!(pairs.len(), 10);
    let xs: Vec<f64> = pairs.iter().map(|p| surface.positions[p[0] as usize].x).collect();
    let (low, high) = xs.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(*x), h.max(*x)));
    assert!(high - low > 3.9, "from one end to the other: {xs:?}");
    assert_eq!(graph.figures.number("links_with_pairs_left_out"), Some(1.0));
}
