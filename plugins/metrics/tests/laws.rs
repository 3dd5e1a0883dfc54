//! Laws of every metric: neither the place of the meshes nor their unit changes a statistic.

use mimesh_core::{
    Figures,
    mesh::{Mesh, Surface, SurfacePoint},
    plugin,
    stage::{Frame, Marker, Metric, MetricContext, MetricInput, Posed, TransferPair, TriangleMap},
    testkit::{meshes, random::Random},
};
use mimesh_metrics as _;
use nalgebra::{Isometry3, Point3};
use proptest::prelude::*;

type Positions = Vec<Point3<f64>>;

/// Two bars side by side in three frames of a motion, for the source and for the target, which is noisy.
struct Scene {
    rest: Surface,
    /// The latest first.
    source: [Positions; 3],
    result: [Positions; 3],
    ground_truth: Positions,
}

impl Scene {
    fn new(seed: u64, noise: f64) -> Self {
        let bar = meshes::bar([6, 3, 2], [2.0, 0.7, 0.5]);
        let beside = |p: &Point3<f64>| Point3::new(p.x + 0.1, p.y + 0.72, 1.2 * p.z + 0.1 * p.x);
        let positions = bar.positions.iter().copied().chain(bar.positions.iter().map(beside)).collect();
        let count = bar.vertex_count() as u32;
        let again = bar.triangles.iter().map(|t| t.map(|v| v + count));
        let triangles = bar.triangles.iter().copied().chain(again).collect();
        let rest = Surface::from_triangles(positions, triangles).unwrap();
        let bent = |amount: f64| -> Positions {
            let bend = |p: &Point3<f64>| Point3::new(p.x, p.y + amount * p.x * p.x, p.z + 0.5 * amount * p.x * p.y);
            rest.positions.iter().map(bend).collect()
        };
        let mut random = Random::new(seed);
        let mut noisy =
            |positions: &Positions| -> Positions { positions.iter().map(|p| p + random.vector() * noise).collect() };
        let source = [bent(0.4), bent(0.3), bent(0.15)];
        let result = [noisy(&source[0]), noisy(&source[1]), noisy(&source[2])];
        let ground_truth = source[0].clone();
        Self { rest, source, result, ground_truth }
    }

    /// All of it in another unit.
    fn scaled(&self, by: f64) -> Self {
        let scale = |positions: &Positions| -> Positions { positions.iter().map(|p| p * by).collect() };
        let rest = Surface::from_triangles(scale(&self.rest.positions), self.rest.triangles.clone()).unwrap();
        let (source, result) = (self.source.each_ref().map(scale), self.result.each_ref().map(scale));
        Self { rest, source, result, ground_truth: scale(&self.ground_truth) }
    }

    /// All that is posed, elsewhere.
    fn moved(&self, motion: &Isometry3<f64>) -> Self {
        let moved = |positions: &Positions| -> Positions { positions.iter().map(|p| motion * p).collect() };
        let (source, result) = (self.source.each_ref().map(moved), self.result.each_ref().map(moved));
        Self { rest: self.rest.clone(), source, result, ground_truth: moved(&self.ground_truth) }
    }

    fn measure(&self, metric: &dyn Metric) -> Figures {
        let rest = &self.rest;
        let mesh = Mesh::from_triangles(rest.positions.clone(), &rest.triangles);
        let marker = |v: u32| Marker {
            name: v.to_string(),
            source: SurfacePoint::Vertex(v),
            target: SurfacePoint::Vertex((v + 3) % rest.vertex_count() as u32),
        };
        let markers: Vec<_> = (0..rest.vertex_count() as u32).step_by(9).map(marker).collect();
        let count = rest.triangle_count() as u32;
        let map = TriangleMap {
            source_triangle_count: count as usize,
            triangles: (0..count).map(|t| Some((t + 5) % count)).collect(),
            ..TriangleMap::default()
        };
        let pair = TransferPair { source: rest, target: rest, markers: &markers, proximity: None };
        let context = MetricContext { rest: &mesh, surface: rest, pair: Some(pair), map: Some(&map) };
        let frame =
            |k: usize| Some(Frame { result: Posed::without_seams(&self.result[k]), source: Some(&self.source[k]) });
        let input = MetricInput {
            result: Posed::without_seams(&self.result[0]),
            ground_truth: Some(Posed::without_seams(&self.ground_truth)),
            source: Some(&self.source[0]),
            before: [frame(1), frame(2)],
            wants_field: false,
        };
        metric.bind(context).unwrap().measure(input).unwrap().statistics
    }
}

fn assert_alike(here: &Scene, there: &Scene, tolerance: f64) {
    for (name, metric) in plugin::instances::<dyn Metric>() {
        let (a, b) = (here.measure(&*metric), there.measure(&*metric));
        assert_eq!(a.values.len(), b.values.len(), "{name}");
        for key in a.values.keys() {
            let (Some(x), Some(y)) = (a.number(key), b.number(key)) else { continue };
            assert!((x - y).abs() <= tolerance * (1.0 + x.abs()), "{name}: {key} is {x}, and {y}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn another_unit_changes_no_statistic(seed in 0u64..1000, noise in 0.0..0.1f64, exponent in -12i32..12) {
        let scene = Scene::new(seed, noise);
        // A power of two scales without rounding; cube and square roots of it in between do round.
        assert_alike(&scene, &scene.scaled(2f64.powi(exponent)), 1e-9);
    }

    #[test]
    fn a_rigid_motion_of_all_that_is_posed_changes_no_statistic(seed in 0u64..1000, noise in 0.001..0.1f64) {
        let scene = Scene::new(seed, noise);
        let motion = Random::new(seed + 1).rigid_motion(10.0);
        // Places ten units away cost a digit or two of sixteen, and ill-shaped triangles magnify what is lost.
        assert_alike(&scene, &scene.moved(&motion), 1e-7);
    }
}
