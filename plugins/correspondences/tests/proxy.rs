//! A large target that is fitted by a proxy comes to lie where it would by itself.

use mimesh_core::{
    Figures,
    mesh::{Surface, SurfacePoint},
    stage::{Correspondence, Link, Marker, ProximityGraph, TransferPair, TriangleMap},
    testkit::meshes,
};
use mimesh_correspondences::nonrigid_fit::NonrigidFit;
use nalgebra::{Point3, Vector3};

/// A sphere drawn out and bent, so that no turn maps it to itself.
fn potato(level: usize) -> Surface {
    let mut surface = meshes::icosphere(level);
    for p in &mut surface.positions {
        *p = Point3::new(2.0 * p.x + 0.5 * p.y * p.y, 1.2 * p.y + 0.3 * p.z * p.z, p.z);
    }
    surface
}

/// The same, thicker at one end and bent.
fn other_potato(level: usize) -> Surface {
    let mut surface = potato(level);
    for p in &mut surface.positions {
        let thick = 1.0 + 0.2 * p.x;
        *p = Point3::new(1.2 * p.x, p.y * thick + 0.15 * p.x * p.x, p.z * thick);
    }
    surface
}

/// Every vertex of an icosahedron is one of each finer sphere, with the same number.
fn markers() -> Vec<Marker> {
    let marker =
        |v: u32| Marker { name: v.to_string(), source: SurfacePoint::Vertex(v), target: SurfacePoint::Vertex(v) };
    (0..12).map(marker).collect()
}

fn direct() -> NonrigidFit {
    NonrigidFit { proxy_above: None, ..NonrigidFit::default() }
}

fn by_proxy(vertices: usize) -> NonrigidFit {
    NonrigidFit { proxy_above: Some(1000), proxy_vertices: vertices, ..NonrigidFit::default() }
}

/// Where the points of a map lie on the source.
fn places(map: &TriangleMap, source: &Surface) -> Vec<Point3<f64>> {
    map.points.iter().map(|p| p.expect("every vertex has a point").position(source, &source.positions)).collect()
}

fn mean_distance(a: &[Point3<f64>], b: &[Point3<f64>]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).norm()).sum::<f64>() / a.len() as f64
}

#[test]
fn a_finer_mesh_of_the_source_comes_to_lie_where_it_is() {
    let (source, target) = (potato(4), potato(5));
    let markers = markers();
    let pair = TransferPair { source: &source, target: &target, markers: &markers, proximity: None };
    let map = by_proxy(1500).correspond(pair).unwrap();
    assert_eq!(map.orphan_count(), 0);
    assert!(map.figures.number("proxy_vertices").is_some_and(|count| (1400.0..=1500.0).contains(&count)));
    let off = mean_distance(&places(&map, &source), &target.positions) / source.diagonal();
    // The coarser surface lies up to e²/8 r = 1e-3 of a radius inside. A proxy slides no more than that.
    assert!(off < 1e-3, "{off} diagonals");
}

#[test]
fn a_proxy_gives_what_the_target_gives_itself() {
    let (source, target) = (potato(4), other_potato(5));
    let markers = markers();
    let pair = TransferPair { source: &source, target: &target, markers: &markers, proximity: None };
    let itself = direct().correspond(pair).unwrap();
    let expected = places(&itself, &source);
    for vertices in [700, 2500] {
        let map = by_proxy(vertices).correspond(pair).unwrap();
        assert_eq!(map.orphan_count(), itself.orphan_count(), "nothing is lost");
        let off = mean_distance(&places(&map, &source), &expected) / source.diagonal();
        // E_S of other triangles is another energy; between markers the fit slides by some of it. An edge of the target is 0.02 long.
        assert!(off < 2e-3, "{vertices}: {off} diagonals");
    }
}

#[test]
fn markers_are_met_exactly() {
    let (source, target) = (potato(4), other_potato(5));
    let mut markers = markers();
    // One lies in a triangle, one on a vertex of the fine mesh alone.
    let inside = |t: u32| SurfacePoint::Triangle(t, [0.2, 0.3, 0.5]);
    markers.push(Marker { name: "inside".into(), source: inside(2000), target: inside(8000) });
    let fine = target.vertex_count() as u32 - 1;
    let nearest = (0..source.vertex_count()).min_by(|&a, &b| {
        let to = potato(5).positions[fine as usize];
        (source.positions[a] - to).norm().total_cmp(&(source.positions[b] - to).norm())
    });
    let at = SurfacePoint::Vertex(nearest.unwrap() as u32);
    markers.push(Marker { name: "fine".into(), source: at, target: SurfacePoint::Vertex(fine) });
    let pair = TransferPair { source: &source, target: &target, markers: &markers, proximity: None };
    let map = by_proxy(700).correspond(pair).unwrap();
    for marker in &markers {
        if let SurfacePoint::Vertex(v) = marker.target {
            assert_eq!(map.points[v as usize], Some(marker.source), "{}", marker.name);
        }
    }
    let corner = target.triangles[8000][0] as usize;
    let off = places(&map, &source)[corner] - inside(2000).position(&source, &source.positions);
    // As far as a corner is from the point in the triangle, of 0.05, and some more by the stretch.
    assert!(off.norm() < 0.1, "{}", off.norm());
}

/// Two potatoes, the second of other height above the first.
fn two(level: usize, shape: fn(usize) -> Surface, gap: f64) -> Surface {
    let below = shape(level);
    let count = below.vertex_count() as u32;
    let above = below.positions.iter().map(|p| p + Vector3::z() * (2.0 + gap));
    let positions = below.positions.iter().copied().chain(above).collect();
    let triangles = below.triangles.iter().copied().chain(below.triangles.iter().map(|t| t.map(|v| v + count)));
    Surface::from_triangles(positions, triangles.collect()).unwrap()
}

#[test]
fn every_component_keeps_its_own_and_links_hold() {
    let (source, target) = (two(3, potato, 0.1), two(4, other_potato, 0.1));
    let markers = markers();
    let components = target.components();
    let half = target.vertex_count() as u32 / 2;
    // Only the first has markers. The second follows by what is linked: all that lies on top of each other.
    let pairs = (0..half).filter(|&v| target.positions[v as usize].z > 0.9).map(|v| [v, v + half]).collect();
    let link = Link { components: [0, 1], distance: 0.1, in_tree: true, stiffness: 1.0, pairs };
    let graph = ProximityGraph::new(components, vec![link], Figures::default()).unwrap();
    let pair = TransferPair { source: &source, target: &target, markers: &markers, proximity: Some(&graph) };
    let map = by_proxy(800).correspond(pair).unwrap();
    assert!(map.figures.number("proxy_vertices").is_some());
    assert_eq!(map.orphan_count(), 0);
    let of_source = source.components();
    let side = |t: u32| of_source.of_vertex[source.triangles[t as usize][0] as usize];
    let wrong = target
        .triangles
        .iter()
        .zip(&map.triangles)
        .filter(|(t, partner)| side(partner.unwrap()) != graph.components.of_vertex[t[0] as usize]);
    assert_eq!(wrong.count(), 0, "no triangle lies on the other component");
}

#[test]
fn small_targets_are_fitted_themselves() {
    let (source, target) = (potato(3), other_potato(4));
    let markers = markers();
    let pair = TransferPair { source: &source, target: &target, markers: &markers, proximity: None };
    let itself = direct().correspond(pair).unwrap();
    let limit = |most| NonrigidFit { proxy_above: Some(most), proxy_vertices: 800, ..NonrigidFit::default() };
    assert_eq!(limit(target.vertex_count()).correspond(pair).unwrap(), itself);
    assert_ne!(limit(target.vertex_count() - 1).correspond(pair).unwrap(), itself);
    // Nor is a proxy worth it that is not much smaller.
    let large = NonrigidFit { proxy_above: Some(100), proxy_vertices: 2500, ..NonrigidFit::default() };
    assert_eq!(large.correspond(pair).unwrap(), itself);
}

#[test]
fn threads_do_not_change_a_bit() {
    let (source, target) = (potato(4), other_potato(5));
    let markers = markers();
    let fit = || {
        let pair = TransferPair { source: &source, target: &target, markers: &markers, proximity: None };
        by_proxy(900).correspond(pair).unwrap()
    };
    let on = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(fit);
    assert!(on(1) == on(3));
}
