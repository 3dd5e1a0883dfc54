use std::f64::consts::PI;

use mimesh_core::{
    mesh::Surface,
    stage::{Clusterer, Regions},
    testkit::{contracts, meshes, random::Random},
};
use nalgebra::{DMatrix, Point3, Rotation3, Vector3};

use crate::{RotationKmeans, Start, WeightKmeans};

/// Weights of two handles at the ends of a bar, which change slowly along it.
fn blended(surface: &Surface) -> DMatrix<f64> {
    let (low, high) = mimesh_core::mesh::bounding_box(&surface.positions);
    DMatrix::from_fn(surface.vertex_count(), 2, |i, k| {
        let x = (surface.positions[i].x - low.x) / (high.x - low.x);
        if k == 0 { 1.0 - x } else { x }
    })
}

/// `surface` with what lies beyond x = `from` turned about the x axis, each vertex as far as `angle` says.
fn turned(surface: &Surface, from: f64, mut angle: impl FnMut() -> f64) -> Vec<Point3<f64>> {
    let turn = |p: &Point3<f64>| if p.x > from { Rotation3::new(Vector3::x() * angle()) * p } else { *p };
    surface.positions.iter().map(turn).collect()
}

fn bar() -> Surface {
    meshes::bar([20, 4, 4], [5.0, 1.0, 1.0])
}

fn regions(stage: &dyn Clusterer, surface: &Surface, poses: &[Vec<Point3<f64>>], weights: &DMatrix<f64>) -> Regions {
    stage.bind(surface, poses).unwrap().cluster(weights).unwrap()
}

/// How many vertices farther than an edge from x = `from` are in the region of the other side.
fn misplaced(surface: &Surface, regions: &Regions, from: f64) -> usize {
    let far = |p: &Point3<f64>| (p.x - from).abs() > 0.3;
    let first = regions.of_vertex[surface.positions.iter().position(|p| far(p) && p.x < from).unwrap()];
    let wrong = |(p, region): &(&Point3<f64>, &u32)| far(p) && (**region == first) != (p.x < from);
    surface.positions.iter().zip(&regions.of_vertex).filter(wrong).count()
}

#[test]
fn both_keep_the_contract_of_clusterers() {
    contracts::clusterer("weight_kmeans", &WeightKmeans::default());
    contracts::clusterer("rotation_kmeans", &RotationKmeans::default());
    contracts::clusterer("rotation_kmeans", &RotationKmeans { start: Start::PlusPlus, ..RotationKmeans::default() });
}

#[test]
fn parts_that_turn_apart_are_separated_by_rotations_although_weights_do_not() {
    let surface = bar();
    let weights = blended(&surface);
    // A third of the bar turns, while weights change over from the one handle to the other in the middle.
    let pose = turned(&surface, 0.9, || 1.2);
    let by_rotation = regions(&RotationKmeans::default(), &surface, std::slice::from_ref(&pose), &weights);
    assert_eq!(misplaced(&surface, &by_rotation, 0.9), 0);
    let by_weight = regions(&WeightKmeans::default(), &surface, &[pose], &weights);
    assert!(misplaced(&surface, &by_weight, 0.9) > 20, "weights know nothing of the pose");
}

#[test]
fn a_part_that_makes_about_half_a_turn_is_one_region() {
    let surface = bar();
    let mut random = Random::new(2);
    // The larger part stays; of the other some vertices turn a little less than half and some a little more.
    let pose = turned(&surface, 0.9, || PI + random.between(-0.02, 0.02));
    let found = regions(&RotationKmeans::default(), &surface, &[pose], &blended(&surface));
    assert_eq!(misplaced(&surface, &found, 0.9), 0);
}

#[test]
fn regions_do_not_depend_on_where_a_pose_stands_and_faces() {
    let surface = bar();
    let weights = blended(&surface);
    let stage = RotationKmeans { regions: Some(4), ..RotationKmeans::default() };
    let poses = [turned(&surface, 0.9, || 1.2), turned(&surface, -0.4, || -0.7)];
    let found = regions(&stage, &surface, &poses, &weights);
    for seed in 0..10 {
        let mut random = Random::new(seed);
        let moved = poses.clone().map(|pose| {
            let motion = random.rigid_motion(20.0);
            pose.iter().map(|q| motion * q).collect()
        });
        assert_eq!(found.of_vertex, regions(&stage, &surface, &moved, &weights).of_vertex, "seed {seed}");
    }
}

#[test]
fn flat_collapsed_and_loose_rings_give_finite_regions() {
    let mut flat = meshes::grid(6, 6);
    // A vertex without triangles, a triangle of no area, and a ring that is a point.
    let corner = flat.positions[0];
    flat.positions.extend([Point3::new(3.0, 1.0, 2.0), corner, corner, corner]);
    let count = flat.positions.len() as u32;
    flat.triangles.extend([[3, 3, 9], [count - 1, count - 2, count - 3]]);
    let flat = Surface::from_triangles(flat.positions, flat.triangles).unwrap();
    let weights = DMatrix::from_fn(flat.vertex_count(), 3, |i, k| f64::from(u8::from(i % 3 == k)));
    let onto_a_line = flat.positions.iter().map(|p| Point3::new(p.x, 0.0, 0.0)).collect();
    let onto_a_point = vec![Point3::new(1.0, 2.0, 3.0); flat.vertex_count()];
    let mirrored = flat.positions.iter().map(|p| Point3::new(-p.x, p.y, p.z)).collect();
    let found = regions(&RotationKmeans::default(), &flat, &[onto_a_line, onto_a_point, mirrored], &weights);
    assert!(found.figures.number("inertia").is_some_and(f64::is_finite), "{found:?}");
    found.check(flat.vertex_count()).unwrap();
}

#[test]
fn a_flat_sheet_that_is_folded_is_divided_at_the_fold() {
    let sheet = meshes::grid(20, 8);
    let fold = |p: &Point3<f64>| {
        let x = p.x - 0.3;
        if x > 0.0 { Point3::new(0.3, p.y, x) } else { *p }
    };
    let pose = sheet.positions.iter().map(fold).collect();
    let weights = DMatrix::from_fn(sheet.vertex_count(), 2, |i, k| {
        let x = sheet.positions[i].x;
        if k == 0 { 1.0 - x } else { x }
    });
    let found = regions(&RotationKmeans::default(), &sheet, &[pose], &weights);
    let wrong = sheet
        .positions
        .iter()
        .zip(&found.of_vertex)
        .filter(|(p, g)| (p.x - 0.3).abs() > 0.06 && (**g == found.of_vertex[0]) != (p.x < 0.3));
    assert_eq!(wrong.count(), 0, "vertices farther than an edge from the fold");
}

#[test]
fn settings_out_of_range_are_named() {
    let surface = bar();
    let error = RotationKmeans { stretch_weight: -1.0, ..RotationKmeans::default() }.bind(&surface, &[]).unwrap_err();
    assert_eq!(error.to_string(), "stretch_weight: expected at least 0, found -1");
    let error = WeightKmeans { restarts: 0, ..WeightKmeans::default() }.bind(&surface, &[]).unwrap_err();
    assert_eq!(error.to_string(), "restarts: expected at least 1, found 0");
}

#[test]
fn a_number_of_regions_may_be_given() {
    let surface = bar();
    let stage = WeightKmeans { regions: Some(5), ..WeightKmeans::default() };
    assert_eq!(regions(&stage, &surface, &[], &blended(&surface)).count, 5);
}
