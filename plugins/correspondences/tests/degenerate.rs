//! Components without area, or that end in needles, do not stop a fit.

use mimesh_core::{
    Figures,
    mesh::{Surface, SurfacePoint},
    stage::{Correspondence, Link, Marker, ProximityGraph, TransferPair},
    testkit::{meshes, random::Random},
};
use mimesh_correspondences::nonrigid_fit::NonrigidFit;
use nalgebra::{Point3, Vector3};

type Part = (Vec<Point3<f64>>, Vec<[u32; 3]>);

/// Components of one kind or another; their first vertex comes nearest to the others.
fn kinds() -> Vec<(&'static str, Part)> {
    let p = |x: f64, y: f64, z: f64| Point3::new(x, y, z);
    let triangle = |a, b, c| (vec![a, b, c], vec![[0, 1, 2]]);
    let mut kinds = vec![
        ("all corners in one point", triangle(p(0., 0., 0.), p(0., 0., 0.), p(0., 0., 0.))),
        ("collinear", triangle(p(0., 0., 0.), p(0.1, 0.1, 0.), p(0.3, 0.3, 0.))),
        ("two corners in one point", triangle(p(0., 0., 0.), p(0.2, 0., 0.), p(0.2, 0., 0.))),
        ("a repeated corner", (vec![p(0., 0., 0.), p(0.2, 0., 0.)], vec![[0, 1, 1], [0, 0, 1]])),
        (
            "a strip of collinear triangles",
            ((0..6).map(|k| p(0.05 * f64::from(k), 0., 0.)).collect(), (0..4).map(|k| [k, k + 1, k + 2]).collect()),
        ),
        ("a triangle twice", (vec![p(0., 0., 0.), p(0.2, 0., 0.), p(0., 0.2, 0.1)], vec![[0, 1, 2], [0, 1, 2]])),
        (
            "a triangle and its back",
            (vec![p(0., 0., 0.), p(0.2, 0., 0.), p(0., 0.2, 0.1)], vec![[0, 1, 2], [0, 2, 1], [1, 2, 0]]),
        ),
    ];
    for size in [1e-3, 1e-6, 1e-9, 1e-12] {
        kinds.push(("small", triangle(p(0., 0., 0.), p(size, 0., 0.), p(0., size, 0.))));
        let square = vec![p(0., 0., 0.), p(size, 0., 0.), p(size, size, 0.), p(0., size, 0.5 * size)];
        kinds.push(("small, of two triangles", (square, vec![[0, 1, 2], [0, 2, 3]])));
        kinds.push(("a needle", triangle(p(0., 0., 0.), p(0.3, 0., 0.), p(0.15, size, 0.))));
        let pair = vec![p(0., 0., 0.), p(0.3, 0., 0.), p(0.15, size, 0.), p(0.15, -size, 0.)];
        kinds.push(("two needles", (pair, vec![[0, 1, 2], [1, 0, 3]])));
        // A ball on a needle whose tip is nearest.
        let ball = meshes::icosphere(1);
        let mut positions = vec![p(0., 0., 0.)];
        positions.extend(ball.positions.iter().map(|q| Point3::from(0.1 * q.coords) + Vector3::new(0., 0., 0.4)));
        positions.push(positions[1] + Vector3::new(size, 0., 0.));
        let mut triangles: Vec<_> = ball.triangles.iter().map(|t| t.map(|v| v + 1)).collect();
        triangles.push([0, 1, positions.len() as u32 - 1]);
        kinds.push(("a ball on a needle", (positions, triangles)));
    }
    kinds
}

/// An ellipsoid with three different axes and a bump.
fn potato() -> Surface {
    let mut surface = meshes::icosphere(3);
    for p in &mut surface.positions {
        *p = Point3::new(2.0 * p.x + 0.5 * p.y * p.y, 1.2 * p.y + 0.3 * p.z * p.z, p.z);
    }
    surface
}

/// The potato and `parts`, each in front of one of its vertices; the vertices in front of which they are, and the first of each.
fn with_parts(parts: &[Part]) -> (Surface, Vec<[u32; 2]>) {
    let potato = potato();
    let (mut positions, mut triangles) = (potato.positions.clone(), potato.triangles.clone());
    let mut pairs = vec![];
    for (k, (part, faces)) in parts.iter().enumerate() {
        let at = 17 + 23 * k as u32;
        let first = positions.len() as u32;
        let place = positions[at as usize].coords * 1.02;
        positions.extend(part.iter().map(|p| p + place));
        triangles.extend(faces.iter().map(|t| t.map(|v| v + first)));
        pairs.push([at, first]);
    }
    (Surface::from_triangles(positions, triangles).unwrap(), pairs)
}

fn marker(source: u32, target: u32) -> Marker {
    Marker { name: target.to_string(), source: SurfacePoint::Vertex(source), target: SurfacePoint::Vertex(target) }
}

/// Fits the potato with `parts` onto the potato and asserts that the potato itself lies where it is, and that points are finite.
fn assert_fits(name: &str, parts: &[Part], is_linked: bool, is_marked: bool) {
    let source = potato();
    let (target, pairs) = with_parts(parts);
    let count = source.vertex_count() as u32;
    let mut markers: Vec<_> = (0..count).step_by(45).map(|v| marker(v, v)).collect();
    if is_marked {
        markers.extend(pairs.iter().map(|&[at, first]| marker(at, first)));
    }
    let components = target.components();
    let component = |v: u32| components.of_vertex[v as usize].unwrap();
    let link = |&[at, first]: &[u32; 2]| Link {
        components: [component(at), component(first)],
        distance: 0.02,
        in_tree: true,
        stiffness: 1.0,
        pairs: vec![[at, first]],
    };
    let links = pairs.iter().map(link).collect();
    let graph = ProximityGraph::new(components.clone(), links, Figures::default()).unwrap();
    let proximity = is_linked.then_some(&graph);
    let case = format!("{name}, linked: {is_linked}, marked: {is_marked}");
    let pair = TransferPair { source: &source, target: &target, markers: &markers, proximity };
    let map = NonrigidFit::default().correspond(pair).unwrap_or_else(|error| panic!("{case}: {error}"));
    map.check(pair).unwrap_or_else(|error| panic!("{case}: {error}"));
    let off = |v: u32| {
        let place = map.points[v as usize].expect("a point").position(&source, &source.positions);
        (place - source.positions[v as usize]).norm()
    };
    let worst = (0..count).map(off).fold(0.0, f64::max);
    // A fit of a surface to itself. A light part that hangs on a vertex, or a marker on it, may pull that by a bit of an edge (0.15).
    assert!(worst < 0.03, "{case}: the potato itself is off by {worst}");
}

#[test]
fn a_degenerate_component_of_any_kind_follows_its_link_or_its_marker() {
    for (name, part) in kinds() {
        for (is_linked, is_marked) in [(true, false), (false, true), (true, true)] {
            assert_fits(name, std::slice::from_ref(&part), is_linked, is_marked);
        }
    }
}

#[test]
fn many_degenerate_components_at_once_do_too() {
    let mut random = Random::new(5);
    let kinds = kinds();
    for _ in 0..4 {
        let parts: Vec<Part> =
            (0..20).map(|_| kinds[(random.unit() * kinds.len() as f64) as usize].1.clone()).collect();
        assert_fits("many", &parts, true, false);
    }
}

#[test]
fn a_needle_without_a_marker_keeps_its_offset_from_what_it_is_linked_to() {
    // The same, larger and elsewhere: then a fit that left the needle would show.
    let (_, needle) = kinds().into_iter().find(|(name, _)| *name == "collinear").unwrap();
    let source = potato();
    let (target, pairs) = with_parts(&[needle]);
    let [at, first] = pairs[0];
    let markers: Vec<_> = (0..source.vertex_count() as u32).step_by(45).map(|v| marker(v, v)).collect();
    let link = Link { components: [0, 1], distance: 0.02, in_tree: true, stiffness: 1.0, pairs: vec![[at, first]] };
    let graph = ProximityGraph::new(target.components(), vec![link], Figures::default()).unwrap();
    let pair = TransferPair { source: &source, target: &target, markers: &markers, proximity: Some(&graph) };
    let map = NonrigidFit { max_distance: 0.2, ..NonrigidFit::default() }.correspond(pair).unwrap();
    // The closest point of the needle's end, in front of vertex `at`, is near that vertex.
    let place = map.points[first as usize].expect("a point").position(&source, &source.positions);
    assert!((place - source.positions[at as usize]).norm() < 0.05, "{place}");
}

#[test]
fn two_coplanar_components_that_only_a_link_joins_keep_their_distance() {
    let source = meshes::grid(12, 12);
    // The grid without its middle column, so that two flat sheets lie in one plane and no element reaches across.
    let triangles = source.triangles.iter().copied().filter(|t| {
        let middle = t.iter().map(|&v| source.positions[v as usize].x).sum::<f64>() / 3.0;
        !(0.5..0.59).contains(&middle)
    });
    let target = Surface::from_triangles(source.positions.clone(), triangles.collect()).unwrap();
    let left: Vec<_> = (0..target.vertex_count() as u32).filter(|&v| target.positions[v as usize].x < 0.4).collect();
    let markers: Vec<_> = left.into_iter().step_by(7).map(|v| marker(v, v)).collect();
    let pairs = (0..13).map(|row| [13 * row + 6, 13 * row + 7]).collect();
    let link = Link { components: [0, 1], distance: 1.0 / 12.0, in_tree: true, stiffness: 1.0, pairs };
    let graph = ProximityGraph::new(target.components(), vec![link], Figures::default()).unwrap();
    let pair = TransferPair { source: &source, target: &target, markers: &markers, proximity: Some(&graph) };
    let map = NonrigidFit::default().correspond(pair).unwrap();
    for (v, point) in map.points.iter().enumerate() {
        let place = point.expect("a point").position(&source, &source.positions);
        // Both sheets are held by springs at their rest: 1e-6 is what solves of this condition (1e9) leave.
        assert!((place - target.positions[v]).norm() < 1e-6, "vertex {v} at {place}");
    }
}
