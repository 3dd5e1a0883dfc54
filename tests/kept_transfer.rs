//! Transfers whose markers come and go, against those that are bound anew.
#![cfg(feature = "bundled")]

// Links the bundled stages.
use mimesh::core::{
    mesh::{Surface, SurfacePoint},
    plugin::configured,
    stage::{BindInput, Marker, Transfer, TransferPair, Work},
    testkit::meshes,
};
use nalgebra::{Point3, Vector3};
use serde_json::json;

fn farthest(a: &[Point3<f64>], b: &[Point3<f64>]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}

/// A ball, a longer one of more vertices, and two poses of the first.
fn balls() -> (Surface, Surface, [Vec<Point3<f64>>; 2]) {
    let (source, mut target) = (meshes::icosphere(2), meshes::icosphere(3));
    target.positions.iter_mut().for_each(|p| p.x *= 1.5);
    let bent = source.positions.iter().map(|p| p + Vector3::x() * (0.3 * p.y * p.y)).collect();
    let longer = source.positions.iter().map(|p| Point3::new(p.x, 1.2 * p.y, p.z)).collect();
    (source, target, [bent, longer])
}

/// Six pairs, the second of which is at vertex `moved` of the target.
fn markers(moved: u32) -> Vec<Marker> {
    let marker = |v: u32| Marker {
        name: v.to_string(),
        source: SurfacePoint::Vertex(v),
        target: SurfacePoint::Vertex(if v == 3 { moved } else { v }),
    };
    [0, 3, 5, 7, 9, 11].map(marker).to_vec()
}

/// The largest distance, in diagonals, between kept transfers and those that are bound anew, while a marker goes from place to place.
fn farthest_from_anew(residual: bool) -> f64 {
    let (source, target, poses) = balls();
    let settings = json!({ "type": "biharmonic", "weights": { "type": "biharmonic" }, "residual": residual });
    let transfer = configured::<dyn Transfer>(settings).expect("bundled stages");
    let first = markers(3);
    let pair = TransferPair { source: &source, target: &target, markers: &first, proximity: None };
    let input = BindInput { pair, map: None, poses: &poses, work: Work::UNWATCHED };
    let mut kept = transfer.keep(input).unwrap().expect("these weights keep their factors");
    let mut off = 0.0_f64;
    // A neighbour, a vertex a quarter away, one that is wrong by half the ball, and back.
    for moved in [3, 12, 20, 100, 3] {
        let markers = markers(moved);
        let pair = TransferPair { markers: &markers, ..pair };
        let anew = transfer.bind(BindInput { pair, ..input }).unwrap();
        let kept = kept.bind(pair).unwrap();
        for pose in &poses {
            let [a, b] = [&anew, &kept].map(|bound| bound.transfer(pose).unwrap().positions);
            off = off.max(farthest(&a, &b) / target.diagonal());
        }
    }
    off
}

#[test]
fn markers_that_move_give_what_binding_anew_gives() {
    // Rounding of two systems that are solved in different frames.
    let off = farthest_from_anew(false);
    assert!(off < 1e-9, "{off}");
    // The residual changes by less than its own size where it is taken from half a hundredth of the diagonal aside.
    let off = farthest_from_anew(true);
    assert!(off < 5e-3, "{off}");
}

#[test]
fn rest_gives_rest_with_weights_below_zero_and_a_wrong_pair() {
    let (source, target, poses) = balls();
    for weights in ["biharmonic", "harmonic", "bounded_biharmonic"] {
        let settings = json!({ "type": "biharmonic", "weights": { "type": weights } });
        let transfer = configured::<dyn Transfer>(settings).expect("bundled stages");
        for moved in [3, 12, 100] {
            let markers = markers(moved);
            let pair = TransferPair { source: &source, target: &target, markers: &markers, proximity: None };
            let bound = transfer.bind(BindInput { pair, map: None, poses: &poses, work: Work::UNWATCHED }).unwrap();
            let off = farthest(&bound.transfer(&source.positions).unwrap().positions, &target.positions);
            // Rounding, at the condition of weights that are many times as large as 1.
            assert!(off < 1e-9 * target.diagonal(), "{weights}, {moved}: {off}");
        }
    }
}
