//! The contract of proximity.

use petgraph::algo::connected_components;

use super::{meshes, random::Random, support::one_thread};
use crate::{mesh::Surface, stage::Proximity};

/// The contract of [`Proximity`].
pub fn proximity(name: &str, stage: &dyn Proximity) {
    let target = scattered_bars();
    let run = || stage.proximity(&target).unwrap_or_else(|error| panic!("{name}: {error}"));
    let graph = run();
    graph.check(&target).unwrap_or_else(|error| panic!("{name}: {error}"));
    assert!(graph == one_thread(run), "{name}: another graph on one thread");
    assert_eq!(graph.components, target.components(), "{name}: components are those of the surface");
    assert_eq!(connected_components(graph.graph()), 1, "{name}: some components are not joined to the rest");
    for link in graph.links() {
        assert!(!link.pairs.is_empty() && link.components[0] < link.components[1], "{name}: {link:?}");
        for pair in &link.pairs {
            let of = pair.map(|v| graph.components.of_vertex[v as usize]);
            assert_eq!(of, link.components.map(Some), "{name}: pair {pair:?} joins other components");
        }
    }
}

/// Bars of one size at places without order, some of which overlap.
fn scattered_bars() -> Surface {
    let bar = meshes::bar([3, 1, 1], [1.0, 0.3, 0.3]);
    let mut random = Random::new(5);
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for _ in 0..12 {
        let start = positions.len() as u32;
        let motion = random.rigid_motion(2.0);
        positions.extend(bar.positions.iter().map(|p| motion * p));
        triangles.extend(bar.triangles.iter().map(|t| t.map(|v| v + start)));
    }
    Surface::from_triangles(positions, triangles).expect("finite positions and existing corners")
}
