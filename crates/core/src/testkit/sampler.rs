//! The contract of samplers.

use std::collections::HashSet;

use super::{
    meshes,
    support::{one_thread, with_defects},
};
use crate::{
    mesh::{Surface, SurfacePoint},
    operators::is_degenerate,
    stage::Sampler,
};

/// The contract of [`Sampler`], on surfaces of 160 vertices or more and up to 12 components.
pub fn sampler(name: &str, stage: &dyn Sampler) {
    let surfaces = [meshes::icosphere(2), spheres(2), spheres(12), with_defects(meshes::icosphere(2))];
    for surface in &surfaces {
        let run = || stage.sample(surface).unwrap_or_else(|error| panic!("{name}: {error}"));
        let points = run();
        assert!(!points.is_empty(), "{name}: no point");
        assert!(points == one_thread(run), "{name}: other points on one thread");
        points.iter().for_each(|point| exists(name, surface, point));
        let mut places = HashSet::new();
        for point in &points {
            let p = point.position(surface, &surface.positions);
            assert!(places.insert([p.x, p.y, p.z].map(f64::to_bits)), "{name}: two points at {p:?}");
        }
        let components = surface.components();
        let of = |v: u32| components.of_vertex[v as usize];
        let has_point: HashSet<_> = points.iter().map(|point| of(point.corners(surface)[0].0)).collect();
        for t in 0..surface.triangle_count() {
            let has_area = !is_degenerate(&surface.corners(&surface.positions, t));
            let component = of(surface.triangles[t][0]);
            assert!(!has_area || has_point.contains(&component), "{name}: no point on component {component:?}");
        }
    }
}

fn exists(name: &str, surface: &Surface, point: &SurfacePoint) {
    match *point {
        SurfacePoint::Vertex(v) => {
            let used = surface.triangles.iter().flatten().any(|&corner| corner == v);
            assert!(used, "{name}: vertex {v} does not exist or belongs to no triangle");
        }
        SurfacePoint::Triangle(t, b) => {
            assert!((t as usize) < surface.triangle_count(), "{name}: there is no triangle {t}");
            // Rounding of a sum of three.
            let sum: f64 = b.iter().sum();
            assert!((sum - 1.0).abs() < 1e-12 && b.iter().all(|x| *x >= 0.0), "{name}: {b:?} is outside the triangle");
        }
    }
}

/// Spheres of different sizes, apart from each other.
fn spheres(count: u32) -> Surface {
    let sphere = meshes::icosphere(2);
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for k in 0..count {
        let moved = nalgebra::Vector3::new(f64::from(k), f64::from(k % 3), 0.0) * 4.0;
        let start = positions.len() as u32;
        positions.extend(sphere.positions.iter().map(|p| p * (1.0 + 0.3 * f64::from(k % 5)) + moved));
        triangles.extend(sphere.triangles.iter().map(|t| t.map(|v| v + start)));
    }
    Surface::from_triangles(positions, triangles).expect("a sound mesh")
}
