//! What correspondences promise beyond their contract.

use mimesh_core::{
    mesh::{Surface, SurfacePoint},
    stage::{Correspondence, Marker, TransferPair},
    testkit::{meshes, random::Random},
};
use mimesh_correspondences::{
    from_file::FromFile,
    identity::Identity,
    nearest::Nearest,
    nonrigid_fit::{NonrigidFit, Weighting},
};
use nalgebra::{Point3, Rotation3, Vector3};

/// An ellipsoid with three different axes and a bump, so that no turn maps it to itself.
fn potato(level: usize) -> Surface {
    let mut surface = meshes::icosphere(level);
    for p in &mut surface.positions {
        *p = Point3::new(2.0 * p.x + 0.5 * p.y * p.y, 1.2 * p.y + 0.3 * p.z * p.z, p.z);
    }
    surface
}

/// Markers between the vertices of `target` nearest to eight directions and the same places on `source`.
fn markers(source: &Surface, target: &Surface) -> Vec<Marker> {
    let nearest = |surface: &Surface, d: &Vector3<f64>| {
        let along = |v: &u32| surface.positions[*v as usize].coords.dot(d);
        (0..surface.vertex_count() as u32).max_by(|a, b| along(a).total_cmp(&along(b))).unwrap()
    };
    let mut random = Random::new(7);
    let mut result: Vec<Marker> = Vec::new();
    while result.len() < 14 {
        let direction = random.vector();
        let (s, t) =
            (SurfacePoint::Vertex(nearest(source, &direction)), SurfacePoint::Vertex(nearest(target, &direction)));
        if result.iter().all(|m| m.source != s && m.target != t) {
            result.push(Marker { name: result.len().to_string(), source: s, target: t });
        }
    }
    result
}

fn error_of(stage: &dyn Correspondence, source: &Surface, target: &Surface, markers: &[Marker]) -> String {
    let error = stage.correspond(TransferPair { source, target, markers, proximity: None }).unwrap_err();
    format!("{error}\nhint: {}", error.hint().unwrap_or("none"))
}

#[test]
fn a_fit_finds_the_same_place_on_another_mesh_of_another_size_and_place() {
    let (source, mut target) = (potato(4), potato(3));
    let markers = markers(&source, &target);
    let rest = target.positions.clone();
    let turn = Rotation3::from_euler_angles(0.1, -0.2, 0.15);
    target.positions.iter_mut().for_each(|p| *p = turn * *p * 30.0 + Vector3::new(5.0, 600.0, -3.0));
    let pair = TransferPair { source: &source, target: &target, markers: &markers, proximity: None };
    let map = NonrigidFit::default().correspond(pair).unwrap();
    assert_eq!(map.orphan_count(), 0);
    let distance = |(p, point): (&Point3<f64>, &Option<SurfacePoint>)| {
        (point.expect("every vertex has a point").position(&source, &source.positions) - p).norm()
    };
    let distances: Vec<f64> = rest.iter().zip(&map.points).map(distance).collect();
    let mean = distances.iter().sum::<f64>() / distances.len() as f64 / source.diagonal();
    // Markers lie up to half an edge of the coarser mesh apart (3 % of the diagonal); between them the fit is to slide
    // less than that.
    assert!(mean < 0.02, "mean distance to the true partner: {mean} diagonals");
}

#[test]
fn markers_pull_the_surface_around_them_to_where_they_point() {
    let (source, target) = (potato(3), potato(3));
    let mut markers = markers(&source, &target);
    // One vertex and one place on a triangle are to go to other places than their own.
    let far = |from: u32| {
        let p = source.positions[from as usize];
        (0..source.vertex_count() as u32).find(|&v| (0.25..0.35).contains(&(source.positions[v as usize] - p).norm()))
    };
    let SurfacePoint::Vertex(vertex) = markers[0].target else { unreachable!("all are vertices") };
    let goal = far(vertex).expect("a vertex at a distance of 0.3");
    markers[0].source = SurfacePoint::Vertex(goal);
    markers.truncate(8);
    let triangle = (0..target.triangle_count())
        .find(|&t| {
            markers.iter().all(|m| {
                (m.target.position(&target, &target.positions) - target.corners(&target.positions, t)[0]).norm() > 0.8
            })
        })
        .expect("a triangle away from markers");
    let aim = far(target.triangles[triangle][0]).expect("a vertex at a distance of 0.3");
    markers.push(Marker {
        name: "inside".into(),
        source: SurfacePoint::Vertex(aim),
        target: SurfacePoint::Triangle(triangle as u32, [0.2, 0.3, 0.5]),
    });
    let pair = TransferPair { source: &source, target: &target, markers: &markers, proximity: None };
    let map = NonrigidFit { max_distance: 1.0, ..NonrigidFit::default() }.correspond(pair).unwrap();
    let off = |v: u32, goal: u32| {
        let point = map.points[v as usize].expect("a point").position(&source, &source.positions);
        (point - source.positions[goal as usize]).norm()
    };
    // Neighbours are an edge (0.15) away from what was moved; left where they were they would be some 0.3 away.
    let around = |v: u32| target.triangles.iter().filter(move |t| t.contains(&v)).flatten().copied();
    let mean = |v: u32| around(v).map(|w| off(w, goal)).sum::<f64>() / around(v).count() as f64;
    assert!(mean(vertex) < 0.2, "around the marker: {}", mean(vertex));
    let corners = target.triangles[triangle].map(|v| map.points[v as usize].expect("a point"));
    let places = corners.map(|point| point.position(&source, &source.positions).coords);
    let inside = places[0] * 0.2 + places[1] * 0.3 + places[2] * 0.5 - source.positions[aim as usize].coords;
    // The marker is held before vertices are projected onto the source; between them lies a curved surface.
    assert!(inside.norm() < 0.05, "around the marker in a triangle: {}", inside.norm());
}

#[test]
fn without_steps_a_fit_of_a_surface_to_itself_leaves_no_orphans() {
    let surface = potato(3);
    let markers = markers(&surface, &surface);
    let stage = NonrigidFit { steps: 0, ..NonrigidFit::default() };
    let map = stage
        .correspond(TransferPair { source: &surface, target: &surface, markers: &markers, proximity: None })
        .unwrap();
    assert_eq!(map.orphan_count(), 0);
}

#[test]
fn a_sliver_in_the_target_does_not_stop_the_fit() {
    let source = potato(3);
    for height in [1e-4, 1e-6, 1e-8, 1e-10, 1e-12] {
        let mut target = source.clone();
        let [a, b, _] = target.triangles[50];
        let (p, q) = (target.positions[a as usize], target.positions[b as usize]);
        target.positions.push(nalgebra::center(&p, &q) + Vector3::new(0.0, 0.0, height));
        target.triangles.push([a, b, target.positions.len() as u32 - 1]);
        let markers = markers(&source, &source);
        let map = NonrigidFit::default().correspond(TransferPair {
            source: &source,
            target: &target,
            markers: &markers,
            proximity: None,
        });
        let percent = map.unwrap().figures.number("rms_distance_percent").unwrap();
        // A fit onto itself but for the sliver, which stands out by its height.
        assert!(percent < 0.01, "{height}: {percent}");
    }
}

#[test]
fn triangles_far_from_the_source_are_orphans_unless_they_have_a_marker() {
    let source = potato(3);
    let mut target = potato(3);
    // Draw a cap of the target far out, which the source has nothing like.
    let is_cap: Vec<bool> = target.positions.iter().map(|p| p.z > 0.6).collect();
    target.positions.iter_mut().filter(|p| p.z > 0.6).for_each(|p| p.z += 4.0);
    let on_cap = |m: &Marker| matches!(m.target, SurfacePoint::Vertex(v) if is_cap[v as usize]);
    let markers: Vec<_> = markers(&source, &potato(3)).into_iter().filter(|m| !on_cap(m)).collect();
    let stage = NonrigidFit { steps: 1, max_distance: 0.001, ..NonrigidFit::default() };
    let map = stage
        .correspond(TransferPair { source: &source, target: &target, markers: &markers, proximity: None })
        .unwrap();
    assert!(map.orphan_count() > 0, "some triangles are too far away");
    for marker in &markers {
        let SurfacePoint::Vertex(v) = marker.target else { unreachable!("all are vertices") };
        for (t, _) in target.triangles.iter().enumerate().filter(|(_, t)| t.contains(&v)) {
            assert!(map.triangles[t].is_some(), "triangle {t} has a marker");
        }
    }
}

#[test]
fn plain_sums_are_means_over_the_area_times_their_numbers_where_all_triangles_are_alike() {
    // An icosahedron has 20 triangles and 12 vertices of one area; the usual mesh of the means has 40,000 and 20,000.
    let (source, target) = (potato(3), meshes::icosphere(0));
    let marker = |v: u32| {
        let along = |u: &u32| source.positions[*u as usize].coords.dot(&target.positions[v as usize].coords);
        let at = (0..source.vertex_count() as u32).max_by(|a, b| along(a).total_cmp(&along(b))).unwrap();
        Marker { name: v.to_string(), source: SurfacePoint::Vertex(at), target: SurfacePoint::Vertex(v) }
    };
    let markers = [0, 3, 6, 9].map(marker);
    let pair = TransferPair { source: &source, target: &target, markers: &markers, proximity: None };
    let means = NonrigidFit { identity: 0.01, closest: [1.0, 50.0], max_distance: 1.0, ..NonrigidFit::default() };
    let sums = NonrigidFit {
        weighting: Weighting::Uniform,
        identity: 0.01 * 40_000.0 / 20.0,
        closest: [20_000.0 / 12.0, 50.0 * 20_000.0 / 12.0],
        ..means.clone()
    };
    let places = |fit: &NonrigidFit| {
        let map = fit.correspond(pair).unwrap();
        map.points.iter().map(|point| point.unwrap().position(&source, &source.positions)).collect::<Vec<_>>()
    };
    for (a, b) in places(&means).iter().zip(places(&sums)) {
        // The same system but for rounding of its weights, of a condition of about 1e5.
        assert!((a - b).norm() < 1e-9, "{a} {b}");
    }
    let other = NonrigidFit { weighting: Weighting::Uniform, ..means.clone() };
    assert_ne!(places(&means), places(&other), "the setting does something");
}

#[test]
fn markers_that_do_not_do_are_refused_with_a_way_out() {
    let sphere = potato(2);
    let fit = NonrigidFit::default();
    let marker = |name: &str, s, t| Marker {
        name: name.into(),
        source: SurfacePoint::Vertex(s),
        target: SurfacePoint::Vertex(t),
    };
    let two = [marker("1", 0, 0), marker("2", 5, 5)];
    assert_eq!(
        error_of(&fit, &sphere, &sphere, &two),
        "2 markers: expected at least 3\nhint: give pairs of corresponding points with `markers: FILE`; about 20, spread over \
         the whole shape, do well"
    );
    let twice = [marker("nose", 0, 0), marker("ear", 5, 5), marker("chin", 7, 5)];
    assert_eq!(
        error_of(&fit, &sphere, &sphere, &twice),
        "markers ear and chin lie on the same point of the target\nhint: remove one of the two; a point can have one partner only"
    );
    let beyond = [marker("nose", 0, 0), marker("ear", 5, 5), marker("chin", 7, 9999)];
    assert!(error_of(&fit, &sphere, &sphere, &beyond).starts_with(
        "marker chin: the target has no vertex 9999: expected 0 to 161\nhint: were source and target swapped"
    ));
    let line = meshes::grid(4, 4);
    let on_a_line = [marker("1", 0, 0), marker("2", 1, 1), marker("3", 2, 2)];
    assert!(error_of(&fit, &line, &line, &on_a_line).starts_with("the 3 markers lie on one line on the source"));
    let two_parts = meshes::two_components();
    let one_marked = [marker("1", 0, 0), marker("2", 1, 1), marker("3", 2, 2)];
    let message = error_of(&fit, &two_parts, &two_parts, &one_marked);
    assert!(message.starts_with("1 of the target's 2 components have no marker: ("), "{message}");
    assert!(message.contains("multi_component"), "{message}");
}

#[test]
fn surfaces_that_are_inside_out_are_warned_about() {
    let source = potato(3);
    let mut target = potato(3);
    let markers = markers(&source, &target);
    target.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    let map = NonrigidFit::default()
        .correspond(TransferPair { source: &source, target: &target, markers: &markers, proximity: None })
        .unwrap();
    assert!(map.figures.warnings.iter().any(|w| w.contains("inside out")), "{:?}", map.figures);
}

#[test]
fn identity_refuses_another_topology_and_says_where_it_differs() {
    let (a, mut b) = (potato(2), potato(2));
    assert!(error_of(&Identity {}, &a, &potato(1), &[]).starts_with("source and target have 320 and 80 triangles"));
    b.triangles[9][0] = b.triangles[200][0];
    assert!(error_of(&Identity {}, &a, &b, &[]).contains("triangle 9 (from 0) differs"));
}

#[test]
fn identity_tells_which_corners_are_one_where_their_order_differs() {
    let source = potato(2);
    let mut target = potato(2);
    target.triangles.iter_mut().for_each(|t| t.reverse());
    let pair = TransferPair { source: &source, target: &target, markers: &[], proximity: None };
    let map = Identity {}.correspond(pair).unwrap();
    let same: Vec<_> = (0..source.vertex_count() as u32).map(|v| Some(SurfacePoint::Vertex(v))).collect();
    assert_eq!(map.points, same);
    assert!(map.triangles.iter().enumerate().all(|(t, partner)| *partner == Some(t as u32)));
}

#[test]
fn nearest_leaves_what_is_far_away_as_orphans() {
    let source = potato(3);
    let mut target = potato(2);
    target.positions.iter_mut().filter(|p| p.x > 1.5).for_each(|p| p.x += 3.0);
    let map = Nearest::default()
        .correspond(TransferPair { source: &source, target: &target, markers: &[], proximity: None })
        .unwrap();
    assert!(map.orphan_count() > 0 && map.orphan_count() < target.triangle_count());
}

#[test]
fn a_file_that_is_no_correspondence_is_refused_with_its_name() {
    let sphere = potato(1);
    let missing = FromFile { path: "missing.json".into() };
    assert!(error_of(&missing, &sphere, &sphere, &[]).starts_with("missing.json: cannot read"));
}

#[test]
fn inner_sides_of_parts_correspond_to_the_surface_they_lie_under() {
    let source = meshes::bar([12, 2, 4], [3.0, 0.4, 0.5]);
    let plate = meshes::bar([12, 1, 4], [3.0, 0.06, 0.5]);
    let n = plate.vertex_count() as u32;
    let lifted = |y: f64| plate.positions.iter().map(move |p| p + Vector3::new(0.0, y, 0.0));
    let positions: Vec<_> = lifted(0.17).chain(lifted(-0.17)).collect();
    let triangles = plate.triangles.iter().copied().chain(plate.triangles.iter().map(|t| t.map(|v| v + n))).collect();
    let target = Surface::from_triangles(positions, triangles).unwrap();
    let corner = |surface: &Surface, d: Vector3<f64>| {
        let along = |v: &u32| surface.positions[*v as usize].coords.dot(&d);
        SurfacePoint::Vertex((0..surface.vertex_count() as u32).max_by(|a, b| along(a).total_cmp(&along(b))).unwrap())
    };
    let directions = (0..8).map(|k| Vector3::from_fn(|i, _| if k >> i & 1 == 1 { 1.0 } else { -1.0 }));
    let markers: Vec<_> = directions
        .map(|d| Marker { name: format!("{d:?}"), source: corner(&source, d), target: corner(&target, d) })
        .collect();
    let pair = TransferPair { source: &source, target: &target, markers: &markers, proximity: None };
    let map = NonrigidFit::default().correspond(pair).unwrap();
    for (v, point) in map.points.iter().enumerate().filter(|(v, _)| target.positions[*v].x.abs() < 1.2) {
        let y = point.expect("every vertex has a point").position(&source, &source.positions).y;
        assert!(y * target.positions[v].y > 0.0, "vertex {v} at {} is on the other side, at {y}", target.positions[v]);
    }
    let without = NonrigidFit { inner_depth: f64::MAX, ..NonrigidFit::default() }.correspond(pair).unwrap();
    assert!(without.points != map.points, "the setting does something");
}
