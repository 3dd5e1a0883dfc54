//! How far components are from where they should be, and how they are turned.

use mimesh_core::{
    Figures, Result,
    operators::polar,
    register,
    stage::{BoundMetric, Limit, Measured, Metric, MetricContext, MetricInput},
};
use nalgebra::{Matrix3, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{linked, size, spread::first_largest};

register!(Metric: ComponentMotion);

/// How far components are from where they should be, and how they are turned against it.
///
/// Components are those of the welded surface. The result is first moved so that the mean of all its vertices lies on that of the
/// truth. For each component, the offset is the distance of the means of its vertices in result and truth, in percent of the
/// diagonal, and the turn the angle, in degrees, of the rotation R that takes its vertices in the truth, about their mean, to those
/// in the result with least squares. Figures:
/// - `offset_mean`, `offset_max`, and `worst`, the component of the largest offset, by first vertex, from 0;
/// - `rotation_mean`, `rotation_max`, over components whose vertices do not lie on a line;
/// - `components`.
///
/// Vertices that are not finite are left out. The field is the offset of a vertex's component.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct ComponentMotion {}

#[typetag::serde(name = "component_motion")]
impl Metric for ComponentMotion {
    fn bind<'a>(&self, subject: MetricContext<'a>) -> Result<Box<dyn BoundMetric + 'a>> {
        let diagonal = size::of_rest(subject.rest)?;
        let components = subject.surface.components();
        let (of_vertex, count) = (components.of_vertex.clone(), components.count());
        Ok(Box::new(Bound { subject, diagonal, of_vertex, count }))
    }

    fn figures(&self) -> Vec<&'static str> {
        vec!["offset_mean", "offset_max", "rotation_mean", "rotation_max", "worst", "components"]
    }

    fn limits(&self) -> Vec<Limit> {
        vec![Limit { figure: "offset_max", doubtful: 3.0, bad: 10.0 }]
    }

    fn needs_truth(&self) -> bool {
        true
    }

    fn by_default(&self) -> bool {
        true
    }
}

struct Bound<'a> {
    subject: MetricContext<'a>,
    diagonal: f64,
    of_vertex: Vec<Option<u32>>,
    count: usize,
}

impl BoundMetric for Bound<'_> {
    fn measure(&self, pose: MetricInput<'_>) -> Result<Measured> {
        self.subject.check(&pose)?;
        let Some(truth) = pose.truth.filter(|_| self.count > 1) else { return Ok(Measured::default()) };
        let surface = self.subject.surface;
        let (result, truth) = (surface.from_mesh(pose.result)?, surface.from_mesh(truth)?);
        let mut members: Vec<Vec<(Vector3<f64>, Vector3<f64>)>> = vec![vec![]; self.count];
        for ((p, q), component) in result.iter().zip(&truth).zip(&self.of_vertex) {
            if let (Some(c), true) = (component, size::is_finite(p) && size::is_finite(q)) {
                members[*c as usize].push((p.coords, q.coords));
            }
        }
        let total = members.iter().map(Vec::len).sum::<usize>() as f64;
        if total == 0.0 {
            return Ok(Measured::default());
        }
        let shift = members.iter().flatten().map(|(p, q)| p - q).sum::<Vector3<f64>>() / total;
        let mut offsets = vec![f64::NAN; self.count];
        let mut turns = Vec::new();
        for (offset, members) in offsets.iter_mut().zip(&members).filter(|(_, members)| !members.is_empty()) {
            let number = members.len() as f64;
            let p_mean = members.iter().map(|(p, _)| p).sum::<Vector3<f64>>() / number;
            let q_mean = members.iter().map(|(_, q)| q).sum::<Vector3<f64>>() / number;
            *offset = 100.0 * (p_mean - q_mean - shift).norm() / self.diagonal;
            let covariance = members.iter().map(|(p, q)| (p - p_mean) * (q - q_mean).transpose()).sum();
            turns.extend(turn(&covariance));
        }
        let finite: Vec<f64> = offsets.iter().copied().filter(|offset| offset.is_finite()).collect();
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let max = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
        let mut figures = Figures::default();
        figures.set("offset_mean", mean(&finite));
        figures.set("offset_max", max(&finite));
        if !turns.is_empty() {
            figures.set("rotation_mean", mean(&turns));
            figures.set("rotation_max", max(&turns));
        }
        figures.set("worst", first_largest(&offsets).unwrap_or(0));
        figures.set("components", finite.len());
        let values: Vec<f64> =
            self.of_vertex.iter().map(|component| component.map_or(f64::NAN, |c| offsets[c as usize])).collect();
        let worst = first_largest(&offsets).unwrap_or(0);
        let about = vec![("offset_max", linked::component(surface, worst))];
        let field = size::field(surface, &values);
        Ok(Measured { figures, about, field, field_unit: "offset, %", field_high: 10.0 })
    }
}

/// The angle of the rotation nearest to `covariance`, in degrees; `None` if that leaves it open.
fn turn(covariance: &Matrix3<f64>) -> Option<f64> {
    let values = covariance.singular_values();
    // The covariance squares the width of a cloud.
    if values[0] <= 0.0 || values[1] <= 1e-6 * values[0] {
        return None;
    }
    let r = polar(covariance).rotation;
    let axis = Vector3::new(r[(2, 1)] - r[(1, 2)], r[(0, 2)] - r[(2, 0)], r[(1, 0)] - r[(0, 1)]);
    // By both sine and cosine, since the cosine alone has half the digits at small angles.
    Some(axis.norm().atan2(r.trace() - 1.0).to_degrees())
}

#[cfg(test)]
mod tests {
    use mimesh_core::testkit::meshes;
    use nalgebra::Rotation3;

    use super::*;
    use crate::testing::{against, alone, assert_figure, moved};

    #[test]
    fn a_component_moved_by_d_and_turned_is_off_by_half_of_d_and_by_its_angle() {
        let spheres = meshes::two_components();
        let half = spheres.vertex_count() / 2;
        let turn = Rotation3::new(Vector3::new(0.0, 30f64.to_radians(), 0.0));
        let centre = nalgebra::Point3::new(3.0, 0.0, 0.0);
        let mut posed = spheres.positions.clone();
        let by = Vector3::z() * 0.2 * spheres.diagonal();
        posed[half..].iter_mut().for_each(|p| *p = centre + turn * (*p - centre) + by);
        let figures = against(&ComponentMotion {}, &spheres, &posed, &spheres.positions);
        // Both spheres have as many vertices, so the move of the whole takes half of it.
        assert_figure(&figures, "offset_max", 10.0, 1e-10);
        assert_figure(&figures, "offset_mean", 10.0, 1e-10);
        assert_figure(&figures, "rotation_max", 30.0, 1e-9);
        assert_figure(&figures, "rotation_mean", 15.0, 1e-9);
        assert_figure(&figures, "components", 2.0, 0.0);
    }

    #[test]
    fn a_move_of_everything_is_no_error_and_nothing_is_said_without_a_truth() {
        let spheres = meshes::two_components();
        let posed = moved(&spheres.positions, Vector3::new(1.0, 2.0, 3.0));
        let figures = against(&ComponentMotion {}, &spheres, &posed, &spheres.positions);
        ["offset_max", "rotation_max"].iter().for_each(|name| assert_figure(&figures, name, 0.0, 1e-10));
        assert!(alone(&ComponentMotion {}, &spheres, &posed).figures.values.is_empty());
    }
}
