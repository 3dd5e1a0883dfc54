//! The contract of metrics.

use nalgebra::Point3;

use super::{
    contracts::{bent_bar, one_thread, twisted, with_defects},
    random::Random,
};
use crate::{
    Figures,
    mesh::Mesh,
    stage::{Metric, MetricInput},
};

/// The contract of [`Metric`], on a sound mesh and on one with defects.
pub fn metric(name: &str, stage: &dyn Metric) {
    for surface in [bent_bar(), with_defects(bent_bar())] {
        let rest = &Mesh::from_triangles(surface.positions.clone(), &surface.triangles);
        let truth = twisted(&surface, 0.5);
        let mut random = Random::new(1);
        let noisy: Vec<Point3<f64>> = truth.iter().map(|p| p + random.vector() * 0.05).collect();
        let measure =
            |result: &[Point3<f64>], truth: &[Point3<f64>]| stage.measure(MetricInput { rest, result, truth });
        for result in [&truth, &noisy, &surface.positions] {
            let run = || measure(result, &truth).unwrap_or_else(|error| panic!("{name}: {error}"));
            let figures = run();
            assert!(!figures.values.is_empty(), "{name}: no figure");
            is_finite(name, &figures);
            assert!(figures == one_thread(run), "{name}: other figures on one thread");
        }
        assert!(measure(&truth[1..], &truth).is_err(), "{name}: takes a result with a vertex too few");
        assert!(measure(&truth, &truth[1..]).is_err(), "{name}: takes a truth with a vertex too few");
        let mut broken = truth.clone();
        broken[3].y = f64::NAN;
        // Such a vertex may be refused, or left out; but no figure may hide it as NaN, which JSON has no word for.
        if let Ok(figures) = measure(&broken, &truth) {
            is_finite(name, &figures);
        }
    }
}

fn is_finite(name: &str, figures: &Figures) {
    for (key, value) in &figures.values {
        assert!(!value.is_null(), "{name}: figure `{key}` is not finite");
    }
}
