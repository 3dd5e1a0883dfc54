//! How much edges differ in length from those of the known result.
//!
//! An edge of length l in the result and l* in the known result differs by e = 100 |ln (l / l*)| percent: as much for half the
//! length as for twice the length. The edges are the sides of the polygons. The place of the mesh does not matter.

use mimesh_core::{
    Figures, Result,
    plugin::check_ranges,
    register,
    stage::{BoundMetric, Measured, Metric, MetricContext, MetricInput, Statistic},
};
use nalgebra::Point3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

register!(Metric: MyStage);

/// How much edges differ in length from those of the known result, in percent.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct MyStage {
    /// Differences up to this count as none, in percent.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub tolerance: f64,
}

#[typetag::serde(name = "my_stage")]
impl Metric for MyStage {
    fn bind<'a>(&self, context: MetricContext<'a>) -> Result<Box<dyn BoundMetric + 'a>> {
        check_ranges(self)?;
        Ok(Box::new(Bound { context, tolerance: self.tolerance }))
    }

    fn statistics(&self) -> Vec<Statistic> {
        // `.with_limits(2.0, 5.0)` would say from where on a statistic is doubtful, and from where bad.
        vec![
            Statistic::new("mean", "%", "Mean difference over all sides of polygons."),
            Statistic::new("max", "%", "Largest difference of a side."),
            Statistic::new("edges", "count", "Sides that are measured."),
            Statistic::new("left_out", "count", "Sides without a length, or with a vertex that is not finite."),
        ]
    }

    fn needs_ground_truth(&self) -> bool {
        true
    }
}

struct Bound<'a> {
    context: MetricContext<'a>,
    tolerance: f64,
}

impl BoundMetric for Bound<'_> {
    fn measure(&self, input: MetricInput<'_>) -> Result<Measured> {
        self.context.check(&input)?;
        let Some(ground_truth) = input.ground_truth else { return Ok(Measured::default()) };
        let mut statistics = Figures::default();
        let (mut sum, mut max, mut edges, mut left_out) = (0.0, 0.0f64, 0usize, 0usize);
        for polygon in self.context.rest.polygons.iter() {
            for (k, &a) in polygon.iter().enumerate() {
                let b = polygon[(k + 1) % polygon.len()];
                // Polygons count the vertices of the mesh; triangles of `context.surface` would count those of the surface.
                let length = |at: &[Point3<f64>]| (at[b as usize] - at[a as usize]).norm();
                let difference = 100.0 * (length(input.result.mesh) / length(ground_truth.mesh)).ln().abs();
                if !difference.is_finite() {
                    left_out += 1;
                    continue;
                }
                let counted = if difference > self.tolerance { difference } else { 0.0 };
                edges += 1;
                sum += counted;
                max = max.max(counted);
            }
        }
        statistics.set("edges", edges);
        statistics.set("left_out", left_out);
        if edges > 0 {
            statistics.set("mean", sum / edges as f64);
            statistics.set("max", max);
        }
        // `field`, a value for each vertex of the mesh, would colour the pictures of a report.
        Ok(Measured { statistics, ..Measured::default() })
    }
}

#[cfg(test)]
mod tests {
    use mimesh_core::{mesh::Mesh, stage::Posed, testkit::meshes};

    use super::*;

    #[test]
    fn the_known_result_has_no_error_and_twice_the_size_that_of_twice_the_length() {
        let surface = meshes::icosphere(1);
        let rest = Mesh::from_triangles(surface.positions.clone(), &surface.triangles);
        let twice: Vec<_> = rest.positions.iter().map(|p| p * 2.0).collect();
        let measure = |result: &[Point3<f64>]| {
            let context = MetricContext::alone(&rest, &surface);
            let input = MetricInput::against(Posed::without_seams(result), context.at_rest());
            let measured = MyStage::default().bind(context).unwrap().measure(input).unwrap();
            measured.statistics.number("mean").unwrap()
        };
        assert_eq!(measure(&rest.positions), 0.0);
        // A logarithm and a mean round a little.
        assert!((measure(&twice) - 100.0 * 2f64.ln()).abs() < 1e-9);
    }
}
