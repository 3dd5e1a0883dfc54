//! How much a motion trembles.

use mimesh_core::{
    Figures, Result, register,
    stage::{BoundMetric, Limit, Measured, Metric, MetricContext, MetricInput},
};
use nalgebra::Point3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{size, spread::Spread};

register!(Metric: Jitter);

/// How much a motion trembles, beyond the source's.
///
/// For each vertex of the welded surface the size of the second difference ‖xᵢ − 2 xᵢ₋₁ + xᵢ₋₂‖ over this frame and the two before,
/// in percent of the diagonal: 0 for a constant velocity, 4a for a trembling by ±a. Figures:
/// - `rms` and `p99` over the vertices; `source_rms`: the same of the source, in percent of its own diagonal;
/// - `beyond` = max(0, `rms` − `source_rms`);
/// - `ratio` = (`rms` + 0.05) / (`source_rms` + 0.05): where neither does more than 0.05 %, a millimetre on a person, it is about 1.
///
/// Poses in their order are taken for frames; where they are unrelated the source jumps as the target does, and `ratio` is about 1.
/// There are no figures for the first two frames, nor after a pose that failed.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Jitter {}

/// What hardly anybody sees, in percent of the diagonal.
const FLOOR: f64 = 0.05;

#[typetag::serde(name = "jitter")]
impl Metric for Jitter {
    fn bind<'a>(&self, subject: MetricContext<'a>) -> Result<Box<dyn BoundMetric + 'a>> {
        let diagonal = size::of_rest(subject.rest)?;
        let source_diagonal = subject.pair.map(|pair| size::of_source(pair.source)).transpose()?;
        Ok(Box::new(Bound { subject, diagonal, source_diagonal }))
    }

    fn figures(&self) -> Vec<&'static str> {
        vec!["ratio", "rms", "p99", "source_rms", "beyond"]
    }

    fn limits(&self) -> Vec<Limit> {
        vec![Limit { figure: "ratio", doubtful: 2.0, bad: 5.0 }]
    }

    fn by_default(&self) -> bool {
        true
    }
}

struct Bound<'a> {
    subject: MetricContext<'a>,
    diagonal: f64,
    source_diagonal: Option<f64>,
}

impl BoundMetric for Bound<'_> {
    fn measure(&self, pose: MetricInput<'_>) -> Result<Measured> {
        self.subject.check(&pose)?;
        let [Some(one), Some(two)] = pose.before else { return Ok(Measured::default()) };
        let surface = self.subject.surface;
        let frames = [pose.result, one.result, two.result].map(|frame| surface.from_mesh(frame));
        let [now, one_before, two_before] = frames;
        let values = second_differences([&now?, &one_before?, &two_before?], self.diagonal);
        let Some(spread) = Spread::even(values.iter().copied()) else { return Ok(Measured::default()) };
        let source = match (self.source_diagonal, pose.source, one.source, two.source) {
            (Some(diagonal), Some(now), Some(one), Some(two)) => {
                Spread::even(second_differences([now, one, two], diagonal))
            }
            _ => None,
        };
        let rms = spread.rms();
        let mut figures = Figures::default();
        figures.set("rms", rms);
        figures.set("p99", spread.percentile(0.99));
        if let Some(source) = &source {
            figures.set("source_rms", source.rms());
            figures.set("beyond", (rms - source.rms()).max(0.0));
            figures.set("ratio", (rms + FLOOR) / (source.rms() + FLOOR));
        }
        let field = size::field(surface, &values);
        let field = field.iter().map(|value| if value.is_finite() { *value } else { f64::NAN }).collect();
        Ok(Measured { figures, about: vec![], field, field_unit: "jitter, %", field_high: 5.0 })
    }
}

fn second_differences([now, one, two]: [&[Point3<f64>]; 3], diagonal: f64) -> Vec<f64> {
    let second =
        |((x, y), z): ((&Point3<f64>, &Point3<f64>), &Point3<f64>)| 100.0 * ((x - y) - (y - z)).norm() / diagonal;
    now.iter().zip(one).zip(two).map(second).collect()
}

#[cfg(test)]
mod tests {
    use mimesh_core::{
        mesh::Mesh,
        stage::{Frame, TransferPair},
        testkit::meshes,
    };
    use nalgebra::Vector3;

    use super::*;
    use crate::testing::{alone, assert_figure, frames, moved};

    #[test]
    fn a_constant_velocity_has_no_jitter_and_trembling_by_a_has_four_a() {
        let sphere = meshes::icosphere(1);
        let mesh = Mesh::from_triangles(sphere.positions.clone(), &sphere.triangles);
        let pair = TransferPair { source: &sphere, target: &sphere, markers: &[], proximity: None };
        let subject = MetricContext { pair: Some(pair), ..MetricContext::alone(&mesh, &sphere) };
        let step = Vector3::new(0.3, 0.1, 0.0);
        let steady = [2.0, 1.0, 0.0].map(|k| moved(&sphere.positions, step * k));
        let steady = [&steady[0][..], &steady[1], &steady[2]];
        let figures = frames(subject, &Jitter {}, steady, steady);
        assert_figure(&figures, "rms", 0.0, 1e-12);
        // Nothing over nothing.
        assert_figure(&figures, "ratio", 1.0, 1e-12);

        let a = 0.01 * sphere.diagonal();
        let trembling = [1.0, -1.0, 1.0].map(|sign| moved(&sphere.positions, Vector3::x() * a * sign));
        let trembling = [&trembling[0][..], &trembling[1], &trembling[2]];
        let figures = frames(subject, &Jitter {}, trembling, steady);
        for name in ["rms", "p99", "beyond"] {
            assert_figure(&figures, name, 4.0, 1e-11);
        }
        assert_figure(&figures, "ratio", 4.05 / 0.05, 1e-9);
    }

    #[test]
    fn there_is_nothing_to_say_of_a_pose_with_fewer_than_two_before_it() {
        let sphere = meshes::icosphere(1);
        assert!(alone(&Jitter {}, &sphere, &sphere.positions).figures.values.is_empty());
        let mesh = Mesh::from_triangles(sphere.positions.clone(), &sphere.triangles);
        let before = Some(Frame { result: &sphere.positions, source: None });
        let judged = MetricInput { before: [before, None], ..MetricInput::alone(&sphere.positions) };
        let bound = Jitter {}.bind(MetricContext::alone(&mesh, &sphere)).unwrap();
        assert!(bound.measure(judged).unwrap().figures.values.is_empty());
    }
}
