//! What the tests of metrics share.

use mimesh_core::{
    Figures,
    mesh::{Mesh, Surface},
    stage::{Frame, Measured, Metric, MetricContext, MetricInput, TransferPair},
};
use nalgebra::{Point3, Vector3};

/// What `metric` says of `posed` alone.
pub fn alone(metric: &dyn Metric, rest: &Surface, posed: &[Point3<f64>]) -> Measured {
    let mesh = Mesh::from_triangles(rest.positions.clone(), &rest.triangles);
    let bound = metric.bind(MetricContext::alone(&mesh, rest)).unwrap();
    bound.measure(MetricInput::alone(posed)).unwrap()
}

/// What it says against a known result.
pub fn against(metric: &dyn Metric, rest: &Surface, posed: &[Point3<f64>], truth: &[Point3<f64>]) -> Figures {
    let mesh = Mesh::from_triangles(rest.positions.clone(), &rest.triangles);
    let bound = metric.bind(MetricContext::alone(&mesh, rest)).unwrap();
    bound.measure(MetricInput::against(posed, truth)).unwrap().figures
}

/// What it says of `posed` where the source, of the same rest, moves to `source`.
pub fn with_source(metric: &dyn Metric, rest: &Surface, posed: &[Point3<f64>], source: &[Point3<f64>]) -> Figures {
    let mesh = Mesh::from_triangles(rest.positions.clone(), &rest.triangles);
    let pair = TransferPair { source: rest, target: rest, markers: &[], proximity: None };
    let subject = MetricContext { pair: Some(pair), ..MetricContext::alone(&mesh, rest) };
    let judged = MetricInput { source: Some(source), ..MetricInput::alone(posed) };
    metric.bind(subject).unwrap().measure(judged).unwrap().figures
}

/// What it says of the last of three frames, of target and source, the latest first.
pub fn frames(
    subject: MetricContext<'_>,
    metric: &dyn Metric,
    result: [&[Point3<f64>]; 3],
    source: [&[Point3<f64>]; 3],
) -> Figures {
    let frame = |k: usize| Some(Frame { result: result[k], source: Some(source[k]) });
    let judged = MetricInput { source: Some(source[0]), before: [frame(1), frame(2)], ..MetricInput::alone(result[0]) };
    metric.bind(subject).unwrap().measure(judged).unwrap().figures
}

/// All vertices moved.
pub fn moved(positions: &[Point3<f64>], by: Vector3<f64>) -> Vec<Point3<f64>> {
    positions.iter().map(|p| p + by).collect()
}

/// All vertices scaled about the origin.
pub fn scaled(positions: &[Point3<f64>], by: f64) -> Vec<Point3<f64>> {
    positions.iter().map(|p| p * by).collect()
}

/// Asserts that a figure has a value within `tolerance`.
#[track_caller]
pub fn assert_figure(figures: &Figures, name: &str, expected: f64, tolerance: f64) {
    let found = figures.number(name).unwrap_or_else(|| panic!("no figure `{name}` in {figures:?}"));
    assert!((found - expected).abs() <= tolerance, "{name}: {found}, expected {expected}");
}
