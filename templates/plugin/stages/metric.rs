//! How much edges differ in length from those of the known result.
//!
//! e = 100 · |ln (l / l*)| of each side of each polygon, l in the result and l* in the truth: in percent, as much for an edge
//! half as long as for one twice as long. Where the whole lies does not matter.

use mimesh_core::{
    Error, Figures, Result, register,
    stage::{BoundMetric, MetricInput, Measured, Metric, MetricContext},
};
use nalgebra::Point3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

register!(Metric: MyStage);

/// How much edges differ in length from those of the known result, in percent: `mean` and `max` over all sides of polygons.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct MyStage {
    /// Differences up to this count as none, in percent.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub tolerance: f64,
}

#[typetag::serde(name = "my_stage")]
impl Metric for MyStage {
    fn bind<'a>(&self, subject: MetricContext<'a>) -> Result<Box<dyn BoundMetric + 'a>> {
        Error::check_setting("tolerance", self.tolerance, 0.0, 100.0)?;
        Ok(Box::new(Bound { subject, tolerance: self.tolerance }))
    }

    fn figures(&self) -> Vec<&'static str> {
        vec!["mean", "max", "edges", "left_out"]
    }

    fn needs_truth(&self) -> bool {
        true
    }
}

struct Bound<'a> {
    subject: MetricContext<'a>,
    tolerance: f64,
}

impl BoundMetric for Bound<'_> {
    fn measure(&self, pose: MetricInput<'_>) -> Result<Measured> {
        self.subject.check(&pose)?;
        let Some(truth) = pose.truth else { return Ok(Measured::default()) };
        let mut figures = Figures::default();
        let (mut sum, mut max, mut edges, mut left_out) = (0.0, 0.0f64, 0usize, 0usize);
        for polygon in self.subject.rest.polygons.iter() {
            for (k, &a) in polygon.iter().enumerate() {
                let b = polygon[(k + 1) % polygon.len()];
                let length = |at: &[Point3<f64>]| (at[b as usize] - at[a as usize]).norm();
                let difference = 100.0 * (length(pose.result) / length(truth)).ln().abs();
                // An edge without a length, or with a vertex that is not finite.
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
        figures.set("edges", edges);
        figures.set("left_out", left_out);
        if edges > 0 {
            figures.set("mean", sum / edges as f64);
            figures.set("max", max);
        }
        // `field`, a value for each vertex, would colour the pictures of a report.
        Ok(Measured { figures, ..Measured::default() })
    }
}

#[cfg(test)]
mod tests {
    use mimesh_core::{mesh::Mesh, testkit::meshes};

    use super::*;

    #[test]
    fn the_truth_has_no_error_and_twice_the_size_that_of_twice_the_length() {
        let surface = meshes::icosphere(1);
        let rest = Mesh::from_triangles(surface.positions.clone(), &surface.triangles);
        let twice: Vec<_> = rest.positions.iter().map(|p| p * 2.0).collect();
        let measure = |result: &[Point3<f64>]| {
            let bound = MyStage::default().bind(MetricContext::alone(&rest, &surface)).unwrap();
            bound.measure(MetricInput::against(result, &rest.positions)).unwrap().figures.number("mean").unwrap()
        };
        assert_eq!(measure(&rest.positions), 0.0);
        // A logarithm and a mean round a little.
        assert!((measure(&twice) - 100.0 * 2f64.ln()).abs() < 1e-9);
    }
}
