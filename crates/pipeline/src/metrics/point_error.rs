//! The error of a single result, for commands that compare meshes.

use mimesh_core::{
    Error, Result,
    mesh::{Mesh, Surface},
    plugin,
    stage::{Measured, Metric, MetricContext, MetricInput, Posed},
};
use nalgebra::Point3;

/// The error of each vertex of `result` against `ground_truth`, both poses of `rest`, whose surface is `surface`.
///
/// # Errors
///
/// [`Error::Data`] if the metric `point_error` is not linked into this program, else the errors of that metric.
pub fn point_error(
    rest: &Mesh,
    surface: &Surface,
    result: &[Point3<f64>],
    ground_truth: &[Point3<f64>],
) -> Result<Measured> {
    let Some(metric) = plugin::instance::<dyn Metric>("point_error") else {
        let hint = "link the crate mimesh-metrics, or build with the feature `bundled`";
        return Err(Error::data("the metric point_error is not linked into this program", hint));
    };
    let result = Posed { mesh: result, surface: &surface.from_mesh(result)? };
    let ground_truth = Posed { mesh: ground_truth, surface: &surface.from_mesh(ground_truth)? };
    metric.bind(MetricContext::alone(rest, surface))?.measure(MetricInput::against(result, ground_truth))
}
