//! Where two parts of the source lie close to each other, the map does not jump from one to the other.

use mimesh_core::{
    Figures,
    mesh::{Surface, SurfacePoint},
    stage::{Correspondence, Link, Marker, ProximityGraph, TransferPair, TriangleMap},
    testkit::meshes,
};
use mimesh_correspondences::{nearest::Nearest, nonrigid_fit::NonrigidFit};
use nalgebra::{Point3, Vector3};

/// Two sheets `gap` apart that face each other, as lips do, joined at x = 0.
fn lips(gap: f64) -> Surface {
    let mut sheet = meshes::grid(24, 12);
    for p in &mut sheet.positions {
        let along = 2.0 * p.x - 1.0;
        *p = Point3::new(along.abs(), p.y, if along < 0.0 { 0.0 } else { gap });
    }
    // The lower sheet faces up and the upper one down.
    sheet
}

#[test]
fn a_vertex_that_lies_on_the_source_stays_there_even_if_its_triangles_are_turned_over() {
    let source = lips(0.002);
    let mut target = source.clone();
    let turned = (0..target.vertex_count() as u32)
        .find(|&v| (target.positions[v as usize] - Point3::new(0.75, 0.5, 0.0)).norm() < 1e-9)
        .unwrap();
    target.triangles.iter_mut().filter(|t| t.contains(&turned)).for_each(|t| t.swap(1, 2));
    let map = |target: &Surface| {
        let pair = TransferPair { source: &source, target, markers: &[], proximity: None };
        Nearest::default().correspond(pair).unwrap()
    };
    let off = |map: &TriangleMap, target: &Surface| {
        let distance = |(p, point): (&Point3<f64>, &Option<SurfacePoint>)| {
            (point.unwrap().position(&source, &source.positions) - p).norm()
        };
        target.positions.iter().zip(&map.points).map(distance).fold(0.0, f64::max)
    };
    // Positions from barycentric coordinates round.
    assert!(off(&map(&target), &target) < 1e-12, "{}", off(&map(&target), &target));

    // A vertex beside the source is another matter: there its side is known by the way it faces.
    target.positions[turned as usize].z += 1e-4;
    let found = map(&target).points[turned as usize].unwrap().position(&source, &source.positions);
    assert!((found.z - 0.002).abs() < 1e-12, "{found}");
}

/// A bar bent to two legs of width 0.4, `gap` apart at x = 0, that meet above y = 0.
fn legs(gap: f64) -> Surface {
    let mut bar = meshes::bar([60, 4, 4], [6.0, 0.4, 0.4]);
    let radius = 0.2 + gap / 2.0;
    let quarter = radius * std::f64::consts::FRAC_PI_2;
    for p in &mut bar.positions {
        let (along, out) = (p.x, radius + p.y);
        let angle = along.clamp(-quarter, quarter) / radius;
        let down = (along.abs() - quarter).max(0.0);
        *p = Point3::new(out * angle.sin(), out * angle.cos() - down, p.z);
    }
    bar
}

/// The legs with a plate between them, its middle at `x`; and its first vertex.
fn legs_with_plate(gap: f64, x: f64) -> (Surface, u32) {
    let legs = legs(gap);
    let plate = meshes::bar([1, 4, 4], [0.2 * gap, 0.3, 0.3]);
    let first = legs.vertex_count() as u32;
    let lifted = plate.positions.iter().map(|p| p + Vector3::new(x, -1.2, 0.0));
    let positions = legs.positions.iter().copied().chain(lifted).collect();
    let triangles = legs.triangles.iter().copied().chain(plate.triangles.iter().map(|t| t.map(|v| v + first)));
    (Surface::from_triangles(positions, triangles.collect()).unwrap(), first)
}

/// The plate linked to the nearest vertices of both legs.
fn links(target: &Surface, first: u32) -> ProximityGraph {
    let distance = |v: u32, w: u32| (target.positions[v as usize] - target.positions[w as usize]).norm();
    let nearest = |v: u32| (0..first).min_by(|&a, &b| distance(v, a).total_cmp(&distance(v, b))).unwrap();
    let pairs = (first..target.vertex_count() as u32).map(|v| [nearest(v), v]).collect();
    let link = Link { components: [0, 1], distance: 0.03, in_tree: true, stiffness: 1.0, pairs };
    ProximityGraph::new(target.components(), vec![link], Figures::default()).unwrap()
}

fn vertex_markers(pairs: impl IntoIterator<Item = [u32; 2]>) -> Vec<Marker> {
    let marker = |[s, t]: [u32; 2]| Marker {
        name: t.to_string(),
        source: SurfacePoint::Vertex(s),
        target: SurfacePoint::Vertex(t),
    };
    pairs.into_iter().map(marker).collect()
}

/// The map of the legs with a plate onto the legs, where on the source the plate's vertices lie, and the partners of its triangles.
fn map_of_plate(gap: f64, x: f64, more: &[[u32; 2]]) -> (TriangleMap, Vec<Point3<f64>>, Vec<Point3<f64>>) {
    let source = legs(gap);
    let (target, first) = legs_with_plate(gap, x);
    let graph = links(&target, first);
    let on_legs = (0..source.vertex_count() as u32).step_by(29).map(|v| [v, v]);
    let markers = vertex_markers(on_legs.chain(more.iter().copied()));
    let pair = TransferPair { source: &source, target: &target, markers: &markers, proximity: Some(&graph) };
    let map = NonrigidFit::default().correspond(pair).unwrap();
    let place = |point: &Option<SurfacePoint>| point.expect("a point").position(&source, &source.positions);
    let places = map.points[first as usize..].iter().map(place).collect();
    let partners = partners(&source, &map, &target, first);
    (map, places, partners)
}

/// Barycentres of the partners of the plate's triangles.
fn partners(source: &Surface, map: &TriangleMap, target: &Surface, first: u32) -> Vec<Point3<f64>> {
    let barycentres = source.barycentres(&source.positions);
    let plate = target.triangles.iter().zip(&map.triangles).filter(|(t, _)| t[0] >= first);
    plate.map(|(_, partner)| barycentres[partner.expect("a partner") as usize]).collect()
}

fn warnings_about_sides(map: &TriangleMap) -> usize {
    map.figures.warnings.iter().filter(|warning| warning.contains("either side")).count()
}

#[test]
fn a_plate_between_two_legs_follows_one_of_them_and_a_near_tie_is_said() {
    let (_, first) = legs_with_plate(0.1, 0.0);
    for x in [-0.02, -0.01, 0.0, 0.01, 0.02] {
        let (map, places, partners) = map_of_plate(0.1, x, &[]);
        let left = places.iter().filter(|p| p.x < 0.0).count();
        assert!(left == 0 || left == places.len(), "at {x}: {left} of {} on the left", places.len());
        assert!(partners.iter().all(|p| (p.x < 0.0) == (left > 0)), "at {x}: partners are on the same side");
        // Nearer to one leg by two fifths of the gap.
        assert!(x.abs() < 0.02 || (left > 0) == (x < 0.0), "at {x}: it follows the farther leg");
        if x == 0.0 {
            assert_eq!(warnings_about_sides(&map), 1, "{:?}", map.figures);
            let warning = map.figures.warnings.iter().find(|w| w.contains("either side")).unwrap();
            assert!(warning.starts_with(&format!("component 1 (50 vertices, from vertex {first})")), "{warning}");
        }
    }
}

#[test]
fn a_marker_on_the_plate_decides() {
    let source = legs(0.1);
    let (target, first) = legs_with_plate(0.1, 0.0);
    // A vertex in the middle of a large face of the plate, and the vertices across from it on either leg.
    let at = target.positions[first as usize];
    let across = |sign: f64| {
        let distance = |v: &u32| (source.positions[*v as usize] - Point3::new(0.05 * sign, at.y, at.z)).norm();
        (0..source.vertex_count() as u32).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap()
    };
    for sign in [-1.0, 1.0] {
        let (map, places, _) = map_of_plate(0.1, 0.0, &[[across(sign), first]]);
        assert!(places.iter().all(|p| p.x * sign > 0.0), "{sign}: {places:?}");
        assert_eq!(warnings_about_sides(&map), 0, "{sign}: {:?}", map.figures);
    }
}

#[test]
fn a_plate_on_one_leg_stays_as_it_is() {
    // Beside the legs, not between them.
    let (map, places, _) = map_of_plate(0.1, 0.46, &[]);
    assert!(places.iter().all(|p| p.x > 0.0));
    assert_eq!(map.figures.number("components_moved_to_one_side"), None);
}
