//! Helpers for the tests of metrics, all on meshes without seams.

use mimesh_core::{
    Figures,
    mesh::{Mesh, Surface},
    stage::{Frame, Measured, Metric, MetricContext, MetricInput, Posed, TransferPair},
};
use nalgebra::{Point3, Vector3};

/// Measures `posed` without a source or a known result.
pub fn alone(metric: &dyn Metric, rest: &Surface, posed: &[Point3<f64>]) -> Measured {
    let mesh = Mesh::from_triangles(rest.positions.clone(), &rest.triangles);
    let bound = metric.bind(MetricContext::alone(&mesh, rest)).unwrap();
    bound.measure(MetricInput::alone(Posed::without_seams(posed))).unwrap()
}

/// Measures `posed` against a known result.
pub fn against(metric: &dyn Metric, rest: &Surface, posed: &[Point3<f64>], known: &[Point3<f64>]) -> Figures {
    let mesh = Mesh::from_triangles(rest.positions.clone(), &rest.triangles);
    let bound = metric.bind(MetricContext::alone(&mesh, rest)).unwrap();
    let input = MetricInput::against(Posed::without_seams(posed), Posed::without_seams(known));
    bound.measure(input).unwrap().statistics
}

/// Measures `posed` if the source, which has the same rest, moves to `source`.
pub fn with_source(metric: &dyn Metric, rest: &Surface, posed: &[Point3<f64>], source: &[Point3<f64>]) -> Figures {
    let mesh = Mesh::from_triangles(rest.positions.clone(), &rest.triangles);
    let pair = TransferPair { source: rest, target: rest, markers: &[], proximity: None };
    let context = MetricContext { pair: Some(pair), ..MetricContext::alone(&mesh, rest) };
    let input = MetricInput { source: Some(source), ..MetricInput::alone(Posed::without_seams(posed)) };
    metric.bind(context).unwrap().measure(input).unwrap().statistics
}

/// Measures the last of three frames of target and source, given the latest first.
pub fn frames(
    context: MetricContext<'_>,
    metric: &dyn Metric,
    result: [&[Point3<f64>]; 3],
    source: [&[Point3<f64>]; 3],
) -> Figures {
    let frame = |k: usize| Some(Frame { result: Posed::without_seams(result[k]), source: Some(source[k]) });
    let input = MetricInput {
        source: Some(source[0]),
        before: [frame(1), frame(2)],
        ..MetricInput::alone(Posed::without_seams(result[0]))
    };
    metric.bind(context).unwrap().measure(input).unwrap().statistics
}

/// All vertices moved.
pub fn moved(positions: &[Point3<f64>], by: Vector3<f64>) -> Vec<Point3<f64>> {
    positions.iter().map(|p| p + by).collect()
}

/// All vertices scaled about the origin.
pub fn scaled(positions: &[Point3<f64>], by: f64) -> Vec<Point3<f64>> {
    positions.iter().map(|p| p * by).collect()
}

/// Asserts that a statistic has a value within `tolerance`.
#[track_caller]
pub fn assert_statistic(statistics: &Figures, name: &str, expected: f64, tolerance: f64) {
    let found = statistics.number(name).unwrap_or_else(|| panic!("no statistic `{name}` in {statistics:?}"));
    assert!((found - expected).abs() <= tolerance, "{name}: {found}, expected {expected}");
}
