//! Trembling of a motion.

use mimesh_core::{
    Figures, Result, register,
    stage::{Aggregate, BoundMetric, Measured, Metric, MetricContext, MetricInput, Statistic},
};
use nalgebra::Point3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{diagonal, distribution::Distribution, motion, vertex_field};

register!(Metric: Jitter);

/// Trembling of a motion, beyond that of the source.
///
/// Each vertex of the surface has a second difference ‖xᵢ − 2 xᵢ₋₁ + xᵢ₋₂‖ over this frame and the two before, in percent of the
/// diagonal. It is 0 at a constant velocity, and 4a for a trembling by ±a.
///
/// Poses in their order count as frames if the source moves on in them: Σ v₁ · v₀ ≥ ¼ √(Σ ‖v₁‖² Σ ‖v₀‖²) for its two velocities v
/// between the three frames, summed over vertices. Unrelated shapes have about −½ there, and no statistics.
///
/// There are no statistics for the first two frames, nor for the two after a pose that failed. The field is the second difference.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Jitter {}

/// A second difference that hardly anybody sees, in percent of the diagonal.
const NOISE_FLOOR: f64 = 0.05;

#[typetag::serde(name = "jitter")]
impl Metric for Jitter {
    fn bind<'a>(&self, context: MetricContext<'a>) -> Result<Box<dyn BoundMetric + 'a>> {
        let diagonal = diagonal::of_target(context.surface)?;
        let source_diagonal = context.pair.map(|pair| diagonal::of_source(pair.source)).transpose()?;
        Ok(Box::new(Bound { context, diagonal, source_diagonal }))
    }

    fn statistics(&self) -> Vec<Statistic> {
        vec![
            Statistic::new(
                "ratio",
                "ratio",
                "(`rms` + 0.05) / (`source_rms` + 0.05), about 1 if neither moves by more than 0.05 %.",
            )
            .with_title("jitter relative to the source's")
            .with_limits(2.0, 20.0),
            Statistic::new("rms", "%", "Root mean square of the second difference over vertices.")
                .with_aggregate(Aggregate::RootMeanSquare),
            Statistic::new("p99", "%", "99th percentile of the second difference over vertices."),
            Statistic::new("source_rms", "%", "The same as `rms`, of the source, relative to its own diagonal.")
                .with_aggregate(Aggregate::RootMeanSquare),
            Statistic::new("beyond", "%", "How much `rms` exceeds `source_rms`; 0 if it does not."),
        ]
    }

    fn fault(&self) -> &'static str {
        "the motion trembles more than that of the source"
    }

    fn by_default(&self) -> bool {
        true
    }
}

struct Bound<'a> {
    context: MetricContext<'a>,
    diagonal: f64,
    source_diagonal: Option<f64>,
}

impl BoundMetric for Bound<'_> {
    fn measure(&self, input: MetricInput<'_>) -> Result<Measured> {
        self.context.check(&input)?;
        let [Some(one), Some(two)] = input.before else { return Ok(Measured::default()) };
        let sources = match (self.source_diagonal, input.source, one.source, two.source) {
            (Some(diagonal), Some(now), Some(one), Some(two)) => Some(([now, one, two], diagonal)),
            _ => None,
        };
        if sources.is_some_and(|(sources, diagonal)| !motion::are_frames(sources, diagonal)) {
            return Ok(Measured::default());
        }
        let surface = self.context.surface;
        let frames = [input.result, one.result, two.result].map(|posed| posed.surface);
        let values = second_differences(frames, self.diagonal);
        let Some(target) = Distribution::unweighted(values.iter().copied()) else { return Ok(Measured::default()) };
        let source =
            sources.and_then(|(sources, diagonal)| Distribution::unweighted(second_differences(sources, diagonal)));
        let rms = target.rms();
        let mut statistics = Figures::default();
        statistics.set("rms", rms);
        statistics.set("p99", target.percentile(0.99));
        if let Some(source) = &source {
            statistics.set("source_rms", source.rms());
            statistics.set("beyond", (rms - source.rms()).max(0.0));
            statistics.set("ratio", (rms + NOISE_FLOOR) / (source.rms() + NOISE_FLOOR));
        }
        let shown = || values.iter().map(|value| if value.is_finite() { *value } else { f64::NAN }).collect::<Vec<_>>();
        let field = if input.wants_field { vertex_field::on_mesh(surface, &shown()) } else { vec![] };
        Ok(Measured { statistics, about: vec![], field, field_unit: "jitter, %", field_high: 5.0 })
    }
}

/// ‖x − 2 y + z‖ of each vertex over three frames, in percent of `diagonal`.
fn second_differences([now, one, two]: [&[Point3<f64>]; 3], diagonal: f64) -> Vec<f64> {
    let second =
        |((x, y), z): ((&Point3<f64>, &Point3<f64>), &Point3<f64>)| 100.0 * ((x - y) - (y - z)).norm() / diagonal;
    now.iter().zip(one).zip(two).map(second).collect()
}

#[cfg(test)]
mod tests {
    use mimesh_core::{
        mesh::Mesh,
        stage::{Frame, Posed, TransferPair},
        testkit::meshes,
    };
    use nalgebra::Vector3;

    use super::*;
    use crate::testing::{alone, assert_statistic, frames, moved};

    #[test]
    fn a_constant_velocity_has_no_jitter_and_trembling_by_a_has_four_a() {
        let sphere = meshes::icosphere(1);
        let mesh = Mesh::from_triangles(sphere.positions.clone(), &sphere.triangles);
        let pair = TransferPair { source: &sphere, target: &sphere, markers: &[], proximity: None };
        let context = MetricContext { pair: Some(pair), ..MetricContext::alone(&mesh, &sphere) };
        let step = Vector3::new(0.3, 0.1, 0.0);
        let steady = [2.0, 1.0, 0.0].map(|k| moved(&sphere.positions, step * k));
        let steady = [&steady[0][..], &steady[1], &steady[2]];
        let statistics = frames(context, &Jitter {}, steady, steady);
        assert_statistic(&statistics, "rms", 0.0, 1e-12);
        // Nothing over nothing.
        assert_statistic(&statistics, "ratio", 1.0, 1e-12);

        let a = 0.01 * sphere.diagonal();
        let trembling = [1.0, -1.0, 1.0].map(|sign| moved(&sphere.positions, Vector3::x() * a * sign));
        let trembling = [&trembling[0][..], &trembling[1], &trembling[2]];
        let statistics = frames(context, &Jitter {}, trembling, steady);
        for name in ["rms", "p99", "beyond"] {
            assert_statistic(&statistics, name, 4.0, 1e-11);
        }
        assert_statistic(&statistics, "ratio", 4.05 / 0.05, 1e-9);
    }

    #[test]
    fn there_is_nothing_to_say_of_a_pose_with_fewer_than_two_before_it() {
        let sphere = meshes::icosphere(1);
        assert!(alone(&Jitter {}, &sphere, &sphere.positions).statistics.values.is_empty());
        let mesh = Mesh::from_triangles(sphere.positions.clone(), &sphere.triangles);
        let rest = Posed::without_seams(&sphere.positions);
        let before = Some(Frame { result: rest, source: None });
        let input = MetricInput { before: [before, None], ..MetricInput::alone(rest) };
        let bound = Jitter {}.bind(MetricContext::alone(&mesh, &sphere)).unwrap();
        assert!(bound.measure(input).unwrap().statistics.values.is_empty());
    }
}
