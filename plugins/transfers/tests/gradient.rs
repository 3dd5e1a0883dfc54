//! What `gradient` and its options promise beyond the contract of a transfer.

use mimesh_core::{
    Error,
    mesh::{Mesh, Surface, SurfacePoint},
    spatial::{Orientation, Similarity},
    stage::{BindInput, Marker, Transfer, TransferPair, Transferred, TriangleMap},
    testkit::{meshes, random::Random},
};
use mimesh_transfers::{
    Continuation, Placement,
    copy_displacement::CopyDisplacement,
    gradient::{GradientTransfer, Sampling, Weighting},
    multi_component::MultiComponent,
};
use nalgebra::{Point3, Rotation3, Vector3};

fn bar() -> Surface {
    meshes::bar([12, 3, 3], [4.0, 1.0, 1.0])
}

fn identity_map(source: &Surface) -> TriangleMap {
    TriangleMap {
        source_triangle_count: source.triangle_count(),
        triangles: (0..source.triangle_count() as u32).map(Some).collect(),
        ..TriangleMap::default()
    }
}

/// Bent about z: a quarter turn over the length of the bar.
fn bent(positions: &[Point3<f64>]) -> Vec<Point3<f64>> {
    positions.iter().map(|p| Rotation3::from_axis_angle(&Vector3::z_axis(), 0.4 * p.x) * p).collect()
}

fn run(
    stage: &dyn Transfer,
    source: &Surface,
    target: &Surface,
    map: &TriangleMap,
    posed: &[Point3<f64>],
) -> Transferred {
    let pair = TransferPair { source, target, markers: &[], proximity: None };
    stage.bind(BindInput::new(pair, map)).unwrap().transfer(posed).unwrap()
}

fn largest_distance(a: &[Point3<f64>], b: &[Point3<f64>]) -> f64 {
    a.iter().zip(b).map(|(p, q)| (p - q).norm()).fold(0.0, f64::max)
}

#[test]
fn a_surface_onto_itself_returns_its_poses_with_every_option() {
    let bar = bar();
    let pose = bent(&bar.positions);
    for sampling in [Sampling::Points, Sampling::Triangles] {
        for weighting in [Weighting::Area, Weighting::Uniform] {
            for reweightings in [0, 5] {
                let stage = GradientTransfer { sampling, weighting, reweightings, ..GradientTransfer::default() };
                let result = run(&stage, &bar, &bar, &identity_map(&bar), &pose);
                // The promise to users, in diagonals (4.24); rounding is far below.
                assert!(largest_distance(&result.positions, &pose) < 1e-9 * bar.diagonal(), "{stage:?}");
            }
        }
    }
}

#[test]
fn a_target_that_is_turned_scaled_and_elsewhere_moves_the_same_way_in_its_own_frame() {
    let bar = bar();
    for (seed, turn) in
        [(1, Rotation3::identity()), (2, Rotation3::from_euler_angles(-std::f64::consts::FRAC_PI_2, 0.0, 0.0))]
    {
        let place =
            Similarity { scale: 0.01, rotation: *turn.matrix(), translation: Random::new(seed).vector() * 50.0 };
        let placed = |positions: &[Point3<f64>]| positions.iter().map(|p| place.apply(p)).collect::<Vec<_>>();
        let target = Surface::from_triangles(placed(&bar.positions), bar.triangles.clone()).unwrap();
        let pose: Vec<_> = bent(&bar.positions).iter().map(|p| p + Vector3::new(0.0, 3.0, 0.0)).collect();
        let result = run(&GradientTransfer::default(), &bar, &target, &identity_map(&bar), &pose);
        // Coordinates of 50 with a diagonal of 0.04 leave some 12 digits.
        assert!(largest_distance(&result.positions, &placed(&pose)) < 1e-10);
    }
}

#[test]
fn any_turn_is_followed_when_asked_for_and_none_when_the_axes_are_said_to_be_the_same() {
    let bar = bar();
    let turn = Rotation3::from_euler_angles(0.0, 0.0, 0.3);
    let target =
        Surface::from_triangles(bar.positions.iter().map(|p| turn * p).collect(), bar.triangles.clone()).unwrap();
    let pose = bent(&bar.positions);
    let with = |orientation| {
        let stage = GradientTransfer { orientation, ..GradientTransfer::default() };
        run(&stage, &bar, &target, &identity_map(&bar), &pose).positions
    };
    let turned: Vec<_> = pose.iter().map(|p| turn * p).collect();
    assert!(largest_distance(&with(Orientation::Fitted), &turned) < 1e-9);
    assert!(largest_distance(&with(Orientation::Auto), &turned) < 1e-9, "one shape is turned against itself");
    assert!(largest_distance(&with(Orientation::Same), &turned) > 0.1);
}

#[test]
fn a_target_that_is_turned_by_any_angle_takes_the_pose_and_the_figures_tell_which_rotation_was_taken() {
    let bar = bar();
    let pose = bent(&bar.positions);
    let markers: Vec<_> = (0..8)
        .map(|k| SurfacePoint::Vertex(k * 19))
        .map(|at| Marker { name: format!("{at:?}"), source: at, target: at })
        .collect();
    for (degrees, taken) in
        [(0.0, "axes"), (10.0, "fitted"), (20.0, "fitted"), (29.0, "fitted"), (45.0, "fitted"), (90.0, "axes")]
    {
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), f64::to_radians(degrees));
        let placed = |positions: &[Point3<f64>]| positions.iter().map(|p| turn * p).collect::<Vec<_>>();
        let target = Surface::from_triangles(placed(&bar.positions), bar.triangles.clone()).unwrap();
        for markers in [&markers[..], &[]] {
            let pair = TransferPair { source: &bar, target: &target, markers, proximity: None };
            let bound = GradientTransfer::default().bind(BindInput::new(pair, &identity_map(&bar))).unwrap();
            let figures = bound.figures();
            assert_eq!(figures.values["orientation"], taken, "{degrees}, {} markers", markers.len());
            assert!((figures.number("turned_degrees").unwrap() - degrees).abs() < 1e-5);
            let found = bound.transfer(&pose).unwrap().positions;
            assert!(largest_distance(&found, &placed(&pose)) < 1e-9 * bar.diagonal(), "{degrees}");
        }
    }
    // Another shape, whose points lie off by more than a turn of 5 degrees explains.
    let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), f64::to_radians(5.0));
    let other = |p: &Point3<f64>| turn * Point3::new(p.x, 2.0 * p.y, 0.5 * p.z + 0.2 * p.x * p.x);
    let target = Surface::from_triangles(bar.positions.iter().map(other).collect(), bar.triangles.clone()).unwrap();
    let pair = TransferPair { source: &bar, target: &target, markers: &markers, proximity: None };
    let figures = GradientTransfer::default().bind(BindInput::new(pair, &identity_map(&bar))).unwrap().figures();
    assert_eq!(figures.values["orientation"], "axes");
    assert_eq!(figures.number("turned_degrees"), Some(0.0));
}

/// A cylinder of radius 1 and height 6 about y, and a pose that twists its middle third by `degrees`.
fn twisted_cylinder(degrees: f64) -> (Surface, Vec<Point3<f64>>) {
    let surface = meshes::cylinder(24, 60, 6.0);
    let turn = |p: &Point3<f64>| degrees.to_radians() * ((p.y - 2.0) / 2.0).clamp(0.0, 1.0);
    let pose = surface.positions.iter().map(|p| Rotation3::from_axis_angle(&Vector3::y_axis(), turn(p)) * p).collect();
    (surface, pose)
}

/// What the transfers make of `pose` where the middle of the cylinder, from 2 to 4 along it, corresponds to nothing: the mean distance
/// from `pose`, and the mean radius of the middle ring, of each.
fn without_the_middle(surface: &Surface, pose: &[Point3<f64>], continuation: Continuation) -> [(f64, f64); 2] {
    let mut map = identity_map(surface);
    for (partner, at) in map.triangles.iter_mut().zip(surface.barycentres(&surface.positions)) {
        *partner = partner.filter(|_| !(2.0..4.0).contains(&at.y));
    }
    let stages: [Box<dyn Transfer>; 2] = [
        Box::new(GradientTransfer { continuation, ..GradientTransfer::default() }),
        Box::new(MultiComponent { continuation, ..MultiComponent::default() }),
    ];
    stages.map(|stage| {
        let found = run(&*stage, surface, surface, &map, pose).positions;
        let error: f64 = found.iter().zip(pose).map(|(p, q)| (p - q).norm()).sum();
        let ring: Vec<_> = (0..found.len()).filter(|&v| (surface.positions[v].y - 3.0).abs() < 1e-9).collect();
        assert_eq!(ring.len(), 24);
        let middle = ring.iter().map(|&v| found[v].coords).sum::<Vector3<f64>>() / 24.0;
        let radius = ring.iter().map(|&v| (found[v].coords - middle).norm()).sum::<f64>() / 24.0;
        (error / found.len() as f64, radius)
    })
}

#[test]
fn an_orphan_middle_of_a_twisted_cylinder_keeps_its_width_past_a_half_turn() {
    for degrees in [0.5, 20.0, 90.0, 150.0, 180.0, 270.0] {
        let (surface, pose) = twisted_cylinder(degrees);
        let found = without_the_middle(&surface, &pose, Continuation::Rotations);
        let by_gradients = without_the_middle(&surface, &pose, Continuation::Gradients);
        println!("{degrees} degrees: {found:?}, by gradients {by_gradients:?}");
        for ((error, radius), (before, _)) in found.into_iter().zip(by_gradients) {
            // The ring of triangles that is held reaches half a cell into the middle: that much of the twist is missing there.
            assert!((radius - 1.0).abs() < 1e-6 && error < 1e-4 * degrees, "{degrees}: {radius}, {error}");
            assert!(error < 0.1 * before, "{degrees}: {error}, by gradients {before}");
        }
    }
}

#[test]
fn rotations_continue_a_twist_or_a_bend_of_the_whole_as_well_as_gradients_do() {
    let surface = meshes::cylinder(24, 60, 6.0);
    let along = |p: &Point3<f64>| (p.y - 3.0) / 6.0;
    for degrees in [10.0f64, 60.0, 120.0] {
        let angle = degrees.to_radians();
        let twisted = |p: &Point3<f64>| Rotation3::from_axis_angle(&Vector3::y_axis(), angle * along(p)) * p;
        // The axis becomes an arc of its own length.
        let bent = |p: &Point3<f64>| {
            let (sin, cos) = (angle * along(p)).sin_cos();
            let radius = 6.0 / angle;
            Point3::new(radius - (radius - p.x) * cos, (radius - p.x) * sin, p.z)
        };
        // Both ends straight, and the middle bent between them.
        let hinged = |p: &Point3<f64>| {
            let share = ((p.y - 2.0) / 2.0).clamp(0.0, 1.0);
            let (sin, cos) = (angle * share).sin_cos();
            let radius = 2.0 / angle;
            let beyond = (p.y - 4.0).max(0.0);
            let before = (p.y - 2.0).min(0.0);
            Point3::new(
                radius - (radius - p.x) * cos + beyond * sin,
                2.0 + (radius - p.x) * sin + beyond * cos + before,
                p.z,
            )
        };
        let poses: [(&str, Vec<Point3<f64>>); 3] = [
            ("twisted", surface.positions.iter().map(twisted).collect()),
            ("bent", surface.positions.iter().map(bent).collect()),
            ("hinged", surface.positions.iter().map(hinged).collect()),
        ];
        for (name, pose) in poses {
            let found = without_the_middle(&surface, &pose, Continuation::Rotations);
            let by_gradients = without_the_middle(&surface, &pose, Continuation::Gradients);
            println!("{name} by {degrees}: {found:?}, by gradients {by_gradients:?}");
            let [gradient, parts] = found.map(|(error, _)| error);
            let [gradient_before, parts_before] = by_gradients.map(|(error, _)| error);
            assert!(
                gradient < 0.5 * gradient_before,
                "{name} by {degrees}: {gradient}, by gradients {gradient_before}"
            );
            // Ends that are twisted themselves have a shear that `multi_component` continues as well: 1.5 times the error at most.
            let most = if name == "twisted" { 1.5 } else { 0.7 };
            assert!(parts < most * parts_before, "{name} by {degrees}: {parts}, by gradients {parts_before}");
        }
    }
}

#[test]
fn source_points_carry_a_bend_to_another_mesh_of_the_same_bar() {
    let source = meshes::bar([40, 6, 6], [4.0, 1.0, 1.0]);
    let target = meshes::bar([23, 4, 5], [4.0, 1.0, 1.0]);
    let search = mimesh_core::spatial::ClosestPoint::new(&source.positions, &source.triangles).unwrap();
    let at = |p: &Point3<f64>| search.find(p, f64::INFINITY, |_| true).unwrap();
    let map = TriangleMap {
        source_triangle_count: source.triangle_count(),
        triangles: target.barycentres(&target.positions).iter().map(|p| Some(at(p).triangle)).collect(),
        points: target
            .positions
            .iter()
            .map(at)
            .map(|f| Some(SurfacePoint::Triangle(f.triangle, f.barycentric)))
            .collect(),
        ..TriangleMap::default()
    };
    let pose = bent(&source.positions);
    let truth = bent(&target.positions);
    let error = |sampling| {
        let stage = GradientTransfer { sampling, ..GradientTransfer::default() };
        largest_distance(&run(&stage, &source, &target, &map, &pose).positions, &truth) / target.diagonal()
    };
    // The bend's second derivative is at most 2 · 0.4 + 0.4² · 2.2 = 1.15, so a source point on a chord of a cell (0.1 long) is
    // up to 0.1² / 8 · 1.15 = 1.4e-3 off; two ends of a path, over the diagonal of 4.24.
    assert!(error(Sampling::Points) < 7e-4, "{}", error(Sampling::Points));
    assert!(error(Sampling::Points) < error(Sampling::Triangles));
}

#[test]
fn orphans_follow_their_neighbours() {
    let bar = bar();
    let mut map = identity_map(&bar);
    let middle = |t: &[u32; 3]| t.iter().map(|&v| bar.positions[v as usize].x).sum::<f64>() / 3.0;
    let xs: Vec<_> = bar.triangles.iter().map(middle).collect();
    let low = xs.iter().copied().fold(f64::INFINITY, f64::min);
    for (partner, x) in map.triangles.iter_mut().zip(&xs) {
        if (x - low - 2.0).abs() < 0.8 {
            *partner = None;
        }
    }
    assert!(map.orphan_count() > 50);
    let turn = Random::new(3).rotation();
    let pose: Vec<_> = bar.positions.iter().map(|p| turn * p).collect();
    let result = run(&GradientTransfer::default(), &bar, &bar, &map, &pose);
    // All neighbours turn alike, so do the orphans.
    assert!(largest_distance(&result.positions, &pose) < 1e-9);
}

#[test]
fn reweighting_never_raises_the_energy_and_says_how_often_it_solved() {
    let (source, mut target) = (bar(), bar());
    target.positions.iter_mut().for_each(|p| *p = Point3::new(p.x, 2.0 * p.y, 0.5 * p.z));
    let pose = bent(&source.positions);
    let energy = |reweightings| {
        let stage = GradientTransfer { reweightings, ..GradientTransfer::default() };
        let figures = run(&stage, &source, &target, &identity_map(&source), &pose).figures;
        (figures.number("energy").unwrap(), figures.number("solves").unwrap())
    };
    let energies: Vec<_> = (1..12).map(energy).collect();
    for pair in energies.windows(2) {
        assert!(pair[1].0 <= pair[0].0 * (1.0 + 1e-12), "{energies:?}");
    }
    assert!(energies[0].1 == 2.0 && energies[10].1 < 12.0, "stops once converged: {energies:?}");
}

#[test]
fn triangles_without_area_and_loose_vertices_give_finite_results() {
    for mesh in
        [meshes::with_zero_area_triangle(), meshes::with_unreferenced_vertex(), meshes::with_duplicated_vertex()]
    {
        let surface = Surface::new(&mesh).unwrap();
        if surface.components().count() > 1 {
            continue;
        }
        let pose: Vec<_> = surface.positions.iter().map(|p| p + Vector3::new(0.1 * p.y, 0.0, 0.2)).collect();
        let result = run(&GradientTransfer::default(), &surface, &surface, &identity_map(&surface), &pose);
        assert!(result.positions.iter().all(|p| p.coords.iter().all(|x| x.is_finite())));
    }
}

#[test]
fn placements_put_what_they_name_where_they_say() {
    let bar = bar();
    let lift = Vector3::new(1.0, 2.0, 3.0);
    let pose: Vec<_> = bent(&bar.positions).iter().map(|p| p + lift).collect();
    let markers = [Marker { name: "end".into(), source: SurfacePoint::Vertex(0), target: SurfacePoint::Vertex(0) }];
    let with = |placement| {
        let stage = GradientTransfer { placement, ..GradientTransfer::default() };
        let pair = TransferPair { source: &bar, target: &bar, markers: &markers, proximity: None };
        stage.bind(BindInput::new(pair, &identity_map(&bar))).unwrap().transfer(&pose).unwrap().positions
    };
    assert!(largest_distance(&with(Placement::Motion), &pose) < 1e-9);
    assert!(largest_distance(&with(Placement::Markers), &pose) < 1e-9);
    let at_end = with(Placement::Marker("end".into()));
    assert!((at_end[0] - pose[0]).norm() < 1e-12, "the marker goes where its partner goes");
    let pair = TransferPair { source: &bar, target: &bar, markers: &markers, proximity: None };
    let stage = GradientTransfer { placement: Placement::Marker("edn".into()), ..GradientTransfer::default() };
    let error = stage.bind(BindInput::new(pair, &identity_map(&bar))).unwrap_err().to_string();
    assert!(error.contains("placement.marker") && error.contains("edn") && error.contains("end"), "{error}");
    assert!((with(Placement::Anchor(vec![5]))[5] - bar.positions[5]).norm() < 1e-12);
    let moved = with(Placement::Rest);
    assert!((moved[0] - moved[1] - (pose[0] - pose[1])).norm() < 1e-9 && (moved[0] - pose[0]).norm() > 1.0);
}

#[test]
fn a_target_of_several_components_is_refused_with_the_loose_ones_named() {
    let two = meshes::two_components();
    let mut mesh = Mesh::from_triangles(two.positions.clone(), &two.triangles);
    mesh.parts = vec![mimesh_core::mesh::Part {
        object: Some("left shoe".into()),
        polygons: 0..two.triangle_count(),
        ..Default::default()
    }];
    let surface = Surface::new(&mesh).unwrap();
    let pair = TransferPair { source: &surface, target: &surface, markers: &[], proximity: None };
    let error = GradientTransfer::default().bind(BindInput::new(pair, &identity_map(&surface))).unwrap_err();
    assert!(error.to_string().starts_with("the target has 2 components"), "{error}");
    assert!(error.to_string().contains("left shoe"), "{error}");
    assert!(error.hint().is_some_and(|hint| hint.contains("multi_component")));
    assert!(
        CopyDisplacement::default().bind(BindInput::new(pair, &identity_map(&surface))).is_ok(),
        "the baseline takes any target"
    );
}

#[test]
fn a_map_for_other_meshes_is_refused() {
    let (bar, sphere) = (bar(), meshes::icosphere(1));
    let pair = TransferPair { source: &bar, target: &sphere, markers: &[], proximity: None };
    let error = GradientTransfer::default().bind(BindInput::new(pair, &identity_map(&bar))).unwrap_err();
    assert!(matches!(error, Error::Shape { .. }), "{error}");
}

#[test]
fn copied_displacements_are_exact_for_a_move_and_scale_with_the_target() {
    let bar = bar();
    let target =
        Surface::from_triangles(bar.positions.iter().map(|p| p * 2.0).collect(), bar.triangles.clone()).unwrap();
    let pose: Vec<_> = bar.positions.iter().map(|p| p + Vector3::new(0.0, 0.5, 0.0)).collect();
    let result = run(&CopyDisplacement::default(), &bar, &target, &identity_map(&bar), &pose);
    let expected: Vec<_> = target.positions.iter().map(|p| p + Vector3::new(0.0, 1.0, 0.0)).collect();
    assert!(largest_distance(&result.positions, &expected) < 1e-12);
}
