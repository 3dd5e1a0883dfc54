//! Landmarks without clicks, on the built-in animals, whose generator knows the true partner of each point.
#![cfg(feature = "bundled")]

#[path = "common/named_animals.rs"]
mod named_animals;

// Links the bundled stages.
use mimesh as _;
use mimesh_core::{
    Result,
    mesh::Surface,
    plugin::instance,
    random::Random,
    stage::{Landmarks, Marker, Proposal, TransferPair},
    testkit::meshes,
};
use nalgebra::{Matrix3, Point3, Unit, Vector3};
use named_animals::{Animal, animal};
use serde_json::json;

/// A point farther than this share of the diagonal from its true partner is wrong: a hoof is 4 % wide, a head 15 % long.
const WRONG: f64 = 0.08;

fn propose(source: &Surface, target: &Surface) -> Result<Proposal> {
    let stage = instance::<dyn Landmarks>("extremities").expect("the stage is linked");
    stage.propose(TransferPair { source, target, markers: &[], proximity: None })
}

/// How far the target's point of `marker` lies from its true partner, relative to the diagonal, and the name of the nearest landmark.
///
/// The partner lies beside that landmark as the source's point does, for which both animals stand alike.
fn error_of(marker: &Marker, source: &Animal, target: &Animal, on: &Surface) -> (f64, String) {
    let p = marker.source.position(&source.surface, &source.surface.positions);
    let q = marker.target.position(on, &target.surface.positions);
    let distance = |k: &usize| (source.places[*k] - p).norm();
    let nearest = (0..source.places.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).expect("landmarks");
    let name = &source.names[nearest];
    let partner = target.places[target.names.iter().position(|other| other == name).expect("the same names")];
    let offset = (p - source.places[nearest]) * (target.surface.diagonal() / source.surface.diagonal());
    ((q - (partner + offset)).norm() / target.surface.diagonal(), name.clone())
}

fn check_pairs(case: &str, proposal: &Proposal, source: &Animal, target: &Animal, on: &Surface) {
    let mut found = Vec::new();
    // Only the ends of limbs have partners that the generator knows.
    for pair in proposal.pairs.iter().filter(|pair| pair.marker.name.starts_with("limb")) {
        let (error, name) = error_of(&pair.marker, source, target, on);
        assert!(error < WRONG, "{case}: {} at the {name} is {error} off: {:?}", pair.marker.name, proposal.figures);
        found.push(name);
    }
    for leg in ["left_front", "right_front", "left_hind", "right_hind"] {
        assert!(found.iter().any(|name| name.starts_with(leg)), "{case}: no point of the {leg} leg among {found:?}");
    }
}

#[test]
fn built_in_animals_are_paired_with_the_right_legs_and_heads() {
    let kinds = ["horse", "camel", "giraffe"];
    for (a, b) in kinds.iter().flat_map(|a| kinds.iter().map(move |b| (a, b))) {
        let (source, target) = (animal(json!({ "proportions": a })), animal(json!({ "proportions": b, "seed": 1 })));
        let proposal = propose(&source.surface, &target.surface).unwrap();
        check_pairs(&format!("{a} to {b}"), &proposal, &source, &target, &target.surface);
    }
}

/// The target turned, made larger, moved, and with its vertices and triangles in another order, is the same shape.
#[test]
fn axes_size_place_and_order_of_the_target_do_not_matter() {
    let (source, target) = (animal(json!({})), animal(json!({ "proportions": "camel", "seed": 1 })));
    for (k, turn) in turns().into_iter().enumerate() {
        let mut on = shuffled(&target.surface, k as u64);
        on.positions.iter_mut().for_each(|p| *p = turn * *p * 37.0 + Vector3::new(900.0, -40.0, 5.0));
        let proposal = propose(&source.surface, &on).unwrap();
        // The pairs are judged where the target stood before.
        on.positions.iter_mut().for_each(|p| *p = turn.transpose() * (*p - Vector3::new(900.0, -40.0, 5.0)) / 37.0);
        let there = Animal { surface: on.clone(), names: target.names.clone(), places: target.places.clone() };
        check_pairs(&format!("turn {k}"), &proposal, &source, &there, &on);
        let figures = &proposal.figures;
        assert!(figures.number("next_score") > figures.number("score"), "turn {k}: another turn fits as well");
    }
}

/// The rotations that take axes to axes.
fn turns() -> Vec<Matrix3<f64>> {
    let quarter = |axis: Unit<Vector3<f64>>, times: u32| {
        let angle = f64::from(times) * std::f64::consts::FRAC_PI_2;
        nalgebra::Rotation3::from_axis_angle(&axis, angle).matrix().map(f64::round)
    };
    // What was up points to each of six sides, in four turns about it.
    let sides = [
        quarter(Vector3::x_axis(), 0),
        quarter(Vector3::x_axis(), 1),
        quarter(Vector3::x_axis(), 2),
        quarter(Vector3::x_axis(), 3),
    ];
    let others = [1, 3].map(|times| quarter(Vector3::z_axis(), times));
    sides
        .iter()
        .chain(&others)
        .flat_map(|side| [0, 1, 2, 3].map(|times| side * quarter(Vector3::y_axis(), times)))
        .collect()
}

/// The same surface with its vertices and triangles in another order.
fn shuffled(surface: &Surface, seed: u64) -> Surface {
    let mut random = Random::new(seed);
    let mut order = |count: usize| {
        let mut order: Vec<usize> = (0..count).collect();
        (1..count).rev().for_each(|k| order.swap(k, random.index(k + 1)));
        order
    };
    let (vertices, triangles) = (order(surface.vertex_count()), order(surface.triangle_count()));
    let mut number = vec![0; vertices.len()];
    (0u32..).zip(&vertices).for_each(|(new, &old)| number[old] = new);
    let positions = vertices.iter().map(|&v| surface.positions[v]).collect();
    let triangles = triangles.iter().map(|&t| surface.triangles[t].map(|v| number[v as usize])).collect();
    Surface::from_triangles(positions, triangles).unwrap()
}

#[test]
fn shapes_without_limbs_are_refused_with_a_way_out() {
    let horse = animal(json!({})).surface;
    for round in [meshes::icosphere(3), meshes::bar([9, 3, 2], [3.0, 0.9, 0.7])] {
        let error = propose(&horse, &round).unwrap_err();
        assert!(error.to_string().starts_with("the target has "), "{error}");
        assert!(error.hint().is_some_and(|hint| hint.contains("points by hand")), "{error}");
    }
}

#[test]
fn a_target_that_is_inside_out_gives_the_same_points_and_a_warning() {
    let (source, mut target) = (animal(json!({})), animal(json!({ "seed": 1 })));
    target.surface.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    let proposal = propose(&source.surface, &target.surface).unwrap();
    check_pairs("inside out", &proposal, &source, &target, &target.surface);
    let warnings = &proposal.figures.warnings;
    assert!(warnings.iter().any(|warning| warning.contains("point inwards")), "{warnings:?}");
}

#[test]
fn a_target_turned_by_any_angle_is_found() {
    let (source, target) = (animal(json!({})), animal(json!({ "seed": 1 })));
    let axes = [Vector3::y_axis(), Unit::new_normalize(Vector3::new(1.0, 2.0, -0.5))];
    for (axis, degrees) in [(axes[0], 29.0_f64), (axes[0], 140.0), (axes[1], 65.0)] {
        let turn = nalgebra::Rotation3::from_axis_angle(&axis, degrees.to_radians());
        let mut on = target.surface.clone();
        on.positions.iter_mut().for_each(|p| *p = turn * *p);
        let proposal = propose(&source.surface, &on).unwrap();
        // The pairs are judged where the target stood before.
        check_pairs(&format!("{degrees} degrees"), &proposal, &source, &target, &target.surface);
    }
}

#[test]
fn right_matches_are_sure_and_wrong_ones_are_doubtful_or_refused() {
    let sureness = |source: &Surface, target: &Surface| {
        let proposal = propose(source, target).ok()?;
        let mean = proposal.pairs.iter().map(|pair| pair.confidence).sum::<f64>() / proposal.pairs.len() as f64;
        Some((mean, !proposal.figures.warnings.is_empty(), proposal.figures.number("agreement")?))
    };
    let [horse, camel] = ["horse", "camel"].map(|kind| animal(json!({ "proportions": kind })).surface);
    let (mean, is_doubtful, agreement) = sureness(&horse, &camel).expect("landmarks");
    // Half of what is possible, as that is where landmarks become doubtful.
    assert!(mean > 0.5 && !is_doubtful && agreement > 0.75, "{mean} {agreement}");
    // A star of six arms has limbs, none of which are those of an animal.
    let star = star();
    for (source, target) in [(&horse, &star), (&star, &horse)] {
        if let Some((mean, is_doubtful, agreement)) = sureness(source, target) {
            assert!(is_doubtful && mean < 0.5, "{mean} {agreement}");
        }
    }
}

/// A ball drawn out along both ways of each axis.
fn star() -> Surface {
    let mut ball = meshes::icosphere(4);
    for p in &mut ball.positions {
        let most = p.coords.amax();
        p.coords *= 1.0 + 3.0 * most.powi(20);
    }
    ball
}

/// A ball that is no turn of itself, as a head is: it has a nose, a chin, and ears of two sizes.
fn head(nose: f64) -> Surface {
    let mut ball = meshes::icosphere(4);
    let bumps = [([0.0, 0.0, 1.0], nose), ([0.0, -0.8, 0.6], 0.25), ([0.9, 0.3, 0.0], 0.3), ([-0.9, 0.3, -0.2], 0.2)];
    for p in &mut ball.positions {
        let rise =
            |(at, height): &([f64; 3], f64)| height * (-8.0 * (p.coords - Vector3::from(*at)).norm_squared()).exp();
        let grown = 1.0 + bumps.iter().map(rise).sum::<f64>();
        *p = Point3::new(0.8 * p.x * grown, 1.2 * p.y * grown, p.z * grown);
    }
    ball
}

#[test]
fn shapes_without_limbs_that_lie_alike_are_paired_by_place() {
    let (source, target) = (head(0.4), head(0.5));
    for turn in [turns()[0], turns()[5]] {
        let mut on = target.clone();
        on.positions.iter_mut().for_each(|p| *p = turn * *p * 10.0);
        let proposal = propose(&source, &on).unwrap();
        assert!(proposal.pairs.len() >= 8, "{:?}", proposal.pairs);
        for pair in &proposal.pairs {
            // Both heads are one ball, vertex by vertex.
            let q = pair.marker.target.position(&target, &target.positions);
            let p = pair.marker.source.position(&target, &target.positions);
            assert!((p - q).norm() < 0.03 * target.diagonal(), "{} is {} off", pair.marker.name, (p - q).norm());
        }
    }
}
