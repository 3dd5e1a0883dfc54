//! Surfaces, poses and comparisons that contracts share.

use nalgebra::Point3;

use super::meshes;
use crate::{
    mesh::{Surface, diagonal},
    stage::Work,
};

/// Rounding through one factorisation and solve of these small meshes, relative to the diagonal.
const TOLERANCE: f64 = 1e-9;

pub(super) fn one_thread<T: Send>(run: impl FnOnce() -> T + Send) -> T {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool of one thread");
    pool.install(run)
}

/// Work that somebody waits for, who gets shares from 0 to 1.
pub(super) fn watched<T>(name: &str, run: impl FnOnce(Work<'_>) -> T) -> T {
    let report = |share: f64| assert!((0.0..=1.0).contains(&share), "{name}: {share} of the work is done");
    run(Work::new(&report))
}

pub(super) fn near(name: &str, law: &str, found: &[Point3<f64>], expected: &[Point3<f64>]) {
    near_within(name, law, found, expected, TOLERANCE);
}

pub(super) fn near_within(name: &str, law: &str, found: &[Point3<f64>], expected: &[Point3<f64>], tolerance: f64) {
    assert_eq!(found.len(), expected.len(), "{name}: {law}");
    let size = diagonal(expected);
    for (v, (p, q)) in found.iter().zip(expected).enumerate() {
        let error = (p - q).norm() / size;
        assert!(error < tolerance, "{name}: {law}: vertex {v} is {error:e} diagonals off");
    }
}

/// A bar without symmetry.
pub(super) fn bent_bar() -> Surface {
    let mut surface = meshes::bar([9, 3, 2], [3.0, 0.9, 0.7]);
    for p in &mut surface.positions {
        *p = Point3::new(p.x, p.y + 0.1 * p.x * p.x, p.z * (1.0 + 0.2 * p.x));
    }
    surface
}

/// The surface with a triangle that has a corner twice, as poles of exported spheres have, and one without area.
pub(super) fn with_defects(surface: Surface) -> Surface {
    let (mut positions, mut triangles) = (surface.positions, surface.triangles);
    let [a, b, _] = triangles[7];
    triangles.push([a, a, b]);
    let middle = nalgebra::center(&positions[a as usize], &positions[b as usize]);
    positions.push(middle);
    triangles.push([a, b, positions.len() as u32 - 1]);
    Surface::from_triangles(positions, triangles).expect("finite positions and existing corners")
}

/// Turned about x in proportion to x: `angle` radians a unit of length.
pub(super) fn twisted(surface: &Surface, angle: f64) -> Vec<Point3<f64>> {
    let turn = |p: &Point3<f64>| nalgebra::Rotation3::from_axis_angle(&nalgebra::Vector3::x_axis(), angle * p.x) * p;
    surface.positions.iter().map(turn).collect()
}
