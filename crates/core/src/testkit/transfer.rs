//! The contract of transfers.

use nalgebra::Point3;

use super::{
    random::Random,
    support::{bent_bar, near, one_thread, twisted, with_defects},
};
use crate::{
    mesh::{Surface, SurfacePoint},
    stage::{BindInput, BoundTransfer, Marker, Transfer, TransferPair, TriangleMap, Work},
};

/// The contract of [`Transfer`], on a sound surface and on one with defects, along triangles and along points.
pub fn transfer(name: &str, stage: &dyn Transfer) {
    for source in [bent_bar(), with_defects(bent_bar())] {
        for by_points in [false, true] {
            transfer_between(name, stage, &source, &stretched(&source), by_points);
        }
    }
}

fn transfer_between(name: &str, stage: &dyn Transfer, source: &Surface, target: &Surface, by_points: bool) {
    let points = (0..source.vertex_count() as u32).map(|v| Some(SurfacePoint::Vertex(v)));
    let map = TriangleMap {
        source_triangle_count: source.triangle_count(),
        triangles: (0..source.triangle_count() as u32).map(Some).collect(),
        points: if by_points { points.collect() } else { vec![] },
        ..TriangleMap::default()
    };
    let markers: Vec<_> = (0..4)
        .map(|k| k * 7)
        .map(|v| Marker { name: v.to_string(), source: SurfacePoint::Vertex(v), target: SurfacePoint::Vertex(v) })
        .collect();
    let bind = |target: &Surface| {
        let pair = TransferPair { source, target, markers: &markers, proximity: None };
        stage.bind(BindInput::new(pair, &map)).unwrap_or_else(|error| panic!("{name}: {error}"))
    };
    let run = |bound: &dyn BoundTransfer, posed: &[Point3<f64>]| {
        bound.transfer(posed).unwrap_or_else(|error| panic!("{name}: {error}")).positions
    };

    let pair = TransferPair { source, target, markers: &markers, proximity: None };
    match stage.bind(BindInput { pair, map: None, poses: &[], work: Work::UNWATCHED }) {
        Ok(_) => assert!(!stage.needs_correspondence(), "{name}: needs a correspondence, and binds without one"),
        Err(error) => {
            assert!(stage.needs_correspondence(), "{name}: {error}");
            assert!(error.to_string().contains("`correspondence`"), "{name}: does not say what is missing: {error}");
        }
    }

    let bound = bind(target);
    assert_eq!(bound.motion().is_some(), stage.gives_motion(), "{name}: gives a motion, or says that it does");
    near(name, "the source at rest gives the target at rest", &run(&*bound, &source.positions), &target.positions);

    let onto_itself = bind(source);
    for seed in 0..5 {
        let motion = Random::new(seed).rigid_motion(source.diagonal());
        let moved: Vec<_> = source.positions.iter().map(|p| motion * p).collect();
        near(name, "a rigid motion of the source moves the target by it", &run(&*onto_itself, &moved), &moved);
    }

    let (pose, other) = (twisted(source, 1.0), twisted(source, -0.5));
    let first = run(&*bound, &pose);
    assert_eq!(first.len(), target.vertex_count(), "{name}: one position a target vertex");
    assert!(first.iter().all(|p| p.coords.iter().all(|x| x.is_finite())), "{name}: results are finite");
    run(&*bound, &other);
    assert!(first == run(&*bound, &pose), "{name}: another result after another pose");
    assert!(first == one_thread(|| run(&*bind(target), &pose)), "{name}: another result on one thread");

    assert!(bound.transfer(&pose[1..]).is_err(), "{name}: takes a pose with a vertex too few");
    let mut broken = pose.clone();
    broken[3].y = f64::NAN;
    assert!(bound.transfer(&broken).is_err(), "{name}: takes a pose with NaN");

    let several: Vec<&[Point3<f64>]> = (0..=bound.at_once()).flat_map(|_| [&other[..], &broken, &pose]).collect();
    let together = bound.transfer_all(&several);
    assert_eq!(together.len(), several.len(), "{name}: one result a pose");
    for (k, result) in together.into_iter().enumerate() {
        match result {
            Ok(_) if k % 3 == 1 => panic!("{name}: takes a pose with NaN among others"),
            Err(_) if k % 3 == 1 => {}
            Ok(result) if k % 3 == 2 => assert!(result.positions == first, "{name}: another result among others"),
            Ok(_) => {}
            Err(error) => panic!("{name}: a pose fails among others: {error}"),
        }
    }
}

/// The same topology with other proportions, of the same mean size.
fn stretched(surface: &Surface) -> Surface {
    let mut result = surface.clone();
    result.positions.iter_mut().for_each(|p| *p = Point3::new(1.3 * p.x, 0.8 * p.y, 0.9 * p.z));
    result
}
