//! What `multi_component` promises beyond the contract of a transfer.

use mimesh_core::{
    mesh::Surface,
    stage::{BindInput, ComponentRef, Link, ProximityGraph, Transfer, TransferPair, Transferred, TriangleMap},
    testkit::{meshes, random::Random},
};
use mimesh_transfers::{
    gradient::GradientTransfer,
    multi_component::{FootContact, Gaps, MultiComponent, Orphans},
};
use nalgebra::{Point3, Rotation3, Vector3};

/// `count` bars in a row along x, with gaps of 0.2.
fn row(count: usize) -> Surface {
    let bar = meshes::bar([4, 2, 2], [1.0, 0.5, 0.5]);
    let n = bar.vertex_count() as u32;
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for k in 0..count {
        let shift = Vector3::new(1.2 * k as f64 - 0.6 * (count - 1) as f64, 0.0, 0.0);
        positions.extend(bar.positions.iter().map(|p| p + shift));
        triangles.extend(bar.triangles.iter().map(|t| t.map(|v| v + k as u32 * n)));
    }
    Surface::from_triangles(positions, triangles).unwrap()
}

/// Links each bar with the next by the vertices of the ends that face each other.
fn linked(surface: &Surface) -> ProximityGraph {
    let components = surface.components();
    let of = |c: u32| -> Vec<u32> {
        (0..surface.vertex_count() as u32).filter(|&v| components.of_vertex[v as usize] == Some(c)).collect()
    };
    let near = |a: u32, b: u32| (surface.positions[a as usize] - surface.positions[b as usize]).norm() < 0.2001;
    let link = |c: u32| {
        let (left, right) = (of(c), of(c + 1));
        let all = left.iter().flat_map(|&a| right.iter().map(move |&b| [a, b]));
        let pairs: Vec<_> = all.filter(|&[a, b]| near(a, b)).collect();
        assert!(pairs.len() >= 4, "the ends face each other");
        Link { components: [c, c + 1], distance: 0.2, in_tree: true, stiffness: 1.0, pairs }
    };
    let count = components.count() as u32;
    ProximityGraph::new(surface.components(), (0..count - 1).map(link).collect(), Default::default()).unwrap()
}

fn identity_map(surface: &Surface) -> TriangleMap {
    TriangleMap {
        source_triangle_count: surface.triangle_count(),
        triangles: (0..surface.triangle_count() as u32).map(Some).collect(),
        ..TriangleMap::default()
    }
}

/// The map without the triangles of one component.
fn without(surface: &Surface, component: u32) -> TriangleMap {
    let components = surface.components();
    let mut map = identity_map(surface);
    for (partner, t) in map.triangles.iter_mut().zip(&surface.triangles) {
        *partner = partner.filter(|_| components.of_vertex[t[0] as usize] != Some(component));
    }
    map
}

fn run(stage: &MultiComponent, surface: &Surface, map: &TriangleMap, posed: &[Point3<f64>]) -> Transferred {
    let graph = linked(surface);
    let pair = TransferPair { source: surface, target: surface, markers: &[], proximity: Some(&graph) };
    stage.bind(BindInput::new(pair, map)).unwrap().transfer(posed).unwrap()
}

fn bent(positions: &[Point3<f64>], angle: f64) -> Vec<Point3<f64>> {
    positions.iter().map(|p| Rotation3::from_axis_angle(&Vector3::z_axis(), angle * p.x) * p).collect()
}

fn largest_distance(a: &[Point3<f64>], b: &[Point3<f64>]) -> f64 {
    a.iter().zip(b).map(|(p, q)| (p - q).norm()).fold(0.0, f64::max)
}

/// Lengths of the edges of one component over those at rest: smallest and largest.
fn stretch(surface: &Surface, component: u32, posed: &[Point3<f64>]) -> (f64, f64) {
    let components = surface.components();
    let of = surface.triangles.iter().filter(|t| components.of_vertex[t[0] as usize] == Some(component));
    let ratios = of.flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).map(|[i, j]| {
        let length = |x: &[Point3<f64>]| (x[i as usize] - x[j as usize]).norm();
        length(posed) / length(&surface.positions)
    });
    ratios.fold((f64::INFINITY, 0.0), |(low, high), r| (f64::min(low, r), f64::max(high, r)))
}

#[test]
fn components_that_correspond_follow_the_source_exactly_when_they_are_the_source() {
    let surface = row(4);
    let pose = bent(&surface.positions, 0.3);
    let result = run(&MultiComponent::default(), &surface, &identity_map(&surface), &pose);
    assert!(largest_distance(&result.positions, &pose) < 1e-9 * surface.diagonal());
    assert_eq!(result.figures.number("steps"), Some(1.0), "all gaps are known: one linear problem");
}

#[test]
fn gaps_that_open_on_the_source_open_on_the_target_unless_lengths_are_kept() {
    let surface = row(2);
    let components = surface.components();
    let pose: Vec<_> = surface
        .positions
        .iter()
        .zip(&components.of_vertex)
        .map(|(p, c)| p + Vector3::new(if *c == Some(1) { 0.5 } else { 0.0 }, 0.0, 0.0))
        .collect();
    let error = |gaps| {
        let stage = MultiComponent { gaps, ..MultiComponent::default() };
        largest_distance(&run(&stage, &surface, &identity_map(&surface), &pose).positions, &pose)
    };
    assert!(error(Gaps::Follow) < 1e-9);
    // Half of the 0.5 on either side, the mean of all being held.
    assert!((error(Gaps::Turn) - 0.25).abs() < 1e-6, "{}", error(Gaps::Turn));
    assert!((error(Gaps::Length) - 0.25).abs() < 1e-6, "{}", error(Gaps::Length));
}

#[test]
fn an_orphan_component_keeps_its_size_and_its_place_in_the_row() {
    let surface = row(3);
    let map = without(&surface, 1);
    let turn = Random::new(4).rotation();
    let turned: Vec<_> = surface.positions.iter().map(|p| turn * p).collect();
    let pose = bent(&surface.positions, 0.3);
    let middle = |x: &[Point3<f64>]| {
        let of = surface.components().of_vertex;
        let inside = x.iter().zip(&of).filter(|(_, c)| **c == Some(1)).map(|(p, _)| p.coords);
        inside.sum::<Vector3<f64>>() / of.iter().filter(|c| **c == Some(1)).count() as f64
    };
    for (orphans, low, high) in [(Orphans::Rigid, 1.0 - 1e-9, 1.0 + 1e-9), (Orphans::Soft, 0.8, 1.25)] {
        let stage = MultiComponent { orphans, ..MultiComponent::default() };
        let result = run(&stage, &surface, &map, &turned);
        // All terms vanish at the turned row; steps end once one lowers the energy by less than 1e-4 of it.
        let distance = largest_distance(&result.positions, &turned);
        assert!(distance < 1e-3, "{orphans:?}: {distance}");

        let result = run(&stage, &surface, &map, &pose);
        let (least, most) = stretch(&surface, 1, &result.positions);
        assert!(least > low && most < high, "{orphans:?} neither shrinks nor grows: {least} to {most}");
        let drift = (middle(&result.positions) - middle(&pose)).norm();
        assert!(drift < 0.1, "{orphans:?} stays between its neighbours: {drift} off, a bar being 1 long");
        assert!(result.figures.warnings.is_empty());
    }
}

#[test]
fn orphan_components_are_counted_and_named() {
    let mut surface = row(3);
    surface.part_names = vec!["head".into(), "hat".into(), "body".into()];
    let components = surface.components();
    surface.part_of = surface.triangles.iter().map(|t| components.of_vertex[t[0] as usize].unwrap_or(0)).collect();
    let graph = linked(&surface);
    let pair = TransferPair { source: &surface, target: &surface, markers: &[], proximity: Some(&graph) };
    let figures = MultiComponent::default().bind(BindInput::new(pair, &without(&surface, 1))).unwrap().figures();
    assert_eq!(figures.number("orphan_components"), Some(1.0));
    let triangles = surface.triangle_count() as f64 / 3.0;
    assert_eq!(figures.number("orphan_triangles"), Some(triangles));
    assert!(figures.warnings[0].starts_with("1 of 3 components correspond to nothing"), "{:?}", figures.warnings);
    assert!(figures.warnings[0].contains("hat ("), "{:?}", figures.warnings);
}

#[test]
fn the_energy_never_rises_over_fifty_random_runs() {
    for seed in 0..50 {
        let mut random = Random::new(seed);
        let mut surface = row(3);
        surface.positions.iter_mut().for_each(|p| *p += random.vector() * 0.02);
        let graph_of = row(3);
        let graph = linked(&graph_of);
        let pose: Vec<_> =
            bent(&surface.positions, random.between(-0.6, 0.6)).iter().map(|p| p + random.vector() * 0.05).collect();
        let map = without(&surface, random.index(3) as u32);
        let gaps = [Gaps::Follow, Gaps::Turn, Gaps::Length][random.index(3)];
        let energy = |max_steps| {
            let stage = MultiComponent { gaps, max_steps, tolerance: 0.0, ..MultiComponent::default() };
            let pair = TransferPair { source: &surface, target: &surface, markers: &[], proximity: Some(&graph) };
            stage.bind(BindInput::new(pair, &map)).unwrap().transfer(&pose).unwrap().figures.number("energy").unwrap()
        };
        let energies: Vec<_> = (1..8).map(energy).collect();
        for pair in energies.windows(2) {
            // Rounding of a sum of a few hundred terms.
            assert!(pair[1] <= pair[0] * (1.0 + 1e-9) + 1e-15, "{seed}: {energies:?}");
        }
    }
}

#[test]
fn rigid_components_keep_every_length() {
    let surface = row(3);
    let pose = bent(&surface.positions, 0.5);
    let stage = MultiComponent { rigid: vec![ComponentRef::Number(1)], ..MultiComponent::default() };
    let result = run(&stage, &surface, &identity_map(&surface), &pose);
    let (low, high) = stretch(&surface, 1, &result.positions);
    assert!((low - 1.0).abs() < 1e-9 && (high - 1.0).abs() < 1e-9, "{low} to {high}");
    let (low, high) = stretch(&surface, 0, &result.positions);
    assert!(low < 0.99 || high > 1.01, "the others bend: {low} to {high}");
}

#[test]
fn a_connected_target_moves_as_least_squares_gradient_does() {
    let surface = meshes::bar([9, 3, 2], [3.0, 0.9, 0.7]);
    let mut target = surface.clone();
    target.positions.iter_mut().for_each(|p| *p = Point3::new(1.2 * p.x, 0.9 * p.y, p.z));
    let pose = bent(&surface.positions, 0.4);
    let map = identity_map(&surface);
    let pair = TransferPair { source: &surface, target: &target, markers: &[], proximity: None };
    let several = MultiComponent::default().bind(BindInput::new(pair, &map)).unwrap().transfer(&pose).unwrap();
    let squares = GradientTransfer { reweightings: 0, ..GradientTransfer::default() };
    let one = squares.bind(BindInput::new(pair, &map)).unwrap().transfer(&pose).unwrap();
    // Edges are held by 1e-9 beside cotangents of about 1.
    assert!(largest_distance(&several.positions, &one.positions) < 1e-7);
}

#[test]
fn without_a_graph_several_components_are_refused_with_a_way_out() {
    let surface = row(2);
    let pair = TransferPair { source: &surface, target: &surface, markers: &[], proximity: None };
    let error = MultiComponent::default().bind(BindInput::new(pair, &identity_map(&surface))).unwrap_err();
    assert_eq!(error.to_string(), "the target has 2 components and nothing says how they lie to each other");
    assert!(error.hint().is_some_and(|hint| hint.contains("spanning_tree")));
}

/// A row that bends more with every frame and walks along x.
fn walk(surface: &Surface, frames: usize) -> Vec<Vec<Point3<f64>>> {
    let step = |k: usize| -> Vec<_> {
        let walked = Vector3::new(0.3 * k as f64, 0.0, 0.1);
        bent(&surface.positions, 0.05 * k as f64).iter().map(|p| p + walked).collect()
    };
    (0..frames).map(step).collect()
}

fn frames(
    stage: &MultiComponent,
    surface: &Surface,
    map: &TriangleMap,
    poses: &[Vec<Point3<f64>>],
) -> Vec<Transferred> {
    let graph = linked(surface);
    let pair = TransferPair { source: surface, target: surface, markers: &[], proximity: Some(&graph) };
    let bound = stage.bind(BindInput::new(pair, map)).unwrap();
    let mut motion = bound.motion().expect("frames of one motion");
    poses.iter().enumerate().map(|(k, pose)| motion.frame(k, pose).unwrap()).collect()
}

#[test]
fn frames_that_start_from_the_one_before_end_lower_after_as_many_steps() {
    let surface = row(3);
    let map = without(&surface, 1);
    let poses = walk(&surface, 20);
    let energy = |all: &[Transferred]| -> f64 { all.iter().filter_map(|t| t.figures.number("energy")).sum() };
    for max_steps in [3, 10] {
        let stage = MultiComponent { sequence: true, tolerance: 0.0, max_steps, ..MultiComponent::default() };
        let warm = frames(&stage, &surface, &map, &poses);
        let cold: Vec<_> = poses.iter().map(|pose| run(&stage, &surface, &map, pose)).collect();
        assert!(energy(&warm) < energy(&cold), "{} and {}", energy(&warm), energy(&cold));
    }
    let alone = MultiComponent::default();
    let graph = linked(&surface);
    let pair = TransferPair { source: &surface, target: &surface, markers: &[], proximity: Some(&graph) };
    assert!(
        alone.bind(BindInput::new(pair, &map)).unwrap().motion().is_none(),
        "poses stand alone unless asked otherwise"
    );
}

#[test]
fn foot_contacts_stand_still_in_their_frames_and_the_target_walks_on_after_them() {
    let surface = row(3);
    let end = |x: f64| -> Vec<u32> {
        (0..surface.vertex_count() as u32).filter(|&v| (surface.positions[v as usize].x - x).abs() < 1e-9).collect()
    };
    let (left, right) = (end(-1.7), end(1.7));
    assert!(left.len() >= 4 && right.len() >= 4);
    let mean = |vertices: &[u32], positions: &[Point3<f64>]| {
        vertices.iter().map(|&v| positions[v as usize].coords).sum::<Vector3<f64>>() / vertices.len() as f64
    };
    let contact =
        |vertices: &[u32], frames| FootContact { vertices: vertices.to_vec(), frames, ..FootContact::default() };
    let poses = walk(&surface, 8);
    let stage = MultiComponent {
        foot_contacts: vec![contact(&left, [1, 4]), contact(&right, [3, 5])],
        ..MultiComponent::default()
    };
    let results = frames(&stage, &surface, &identity_map(&surface), &poses);
    assert!(largest_distance(&results[0].positions, &poses[0]) < 1e-9, "no contact holds yet");
    let at = |vertices: &[u32], k: usize| mean(vertices, &results[k].positions);
    // A contact that holds alone is met exactly but for rounding, two together up to the ridge of 1e-9.
    (2..=4).for_each(|k| assert!((at(&left, k) - at(&left, 1)).norm() < 1e-6, "left at {k}"));
    (4..=5).for_each(|k| assert!((at(&right, k) - at(&right, 3)).norm() < 1e-6, "right at {k}"));
    assert!((at(&left, 5) - at(&left, 4)).norm() > 1e-3, "the left one is free again");
    let all: Vec<u32> = (0..surface.vertex_count() as u32).collect();
    let way = at(&all, 7) - at(&all, 6);
    let of_source = mean(&all, &poses[7]) - mean(&all, &poses[6]);
    assert!((way - of_source).norm() < 0.02, "free of contacts it walks as the source does: {way:?}, {of_source:?}");
}

#[test]
fn foot_contacts_that_hold_nothing_are_refused_in_the_users_words() {
    let surface = row(2);
    let graph = linked(&surface);
    let pair = TransferPair { source: &surface, target: &surface, markers: &[], proximity: Some(&graph) };
    let refused = |contact: FootContact| {
        let stage = MultiComponent { foot_contacts: vec![contact], ..MultiComponent::default() };
        stage.check(pair).unwrap_err().to_string()
    };
    assert!(refused(FootContact::default()).contains("expected `vertices` or `markers` that stand still"));
    let far = FootContact { vertices: vec![100_000], ..FootContact::default() };
    assert!(refused(far).contains("found 100000"));
    let backwards = FootContact { vertices: vec![0], frames: [4, 2], ..FootContact::default() };
    assert!(refused(backwards).contains("found [4, 2]"));
    let unknown = FootContact { markers: vec!["hoof".into()], ..FootContact::default() };
    assert!(refused(unknown).contains("found hoof"));
}
