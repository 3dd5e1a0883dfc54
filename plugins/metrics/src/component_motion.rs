//! Distance and rotation of components against the known result.

use mimesh_core::{
    Figures, Result,
    operators::polar,
    register,
    stage::{BoundMetric, Measured, Metric, MetricContext, MetricInput, Statistic},
};
use nalgebra::{Matrix3, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{component_pairs, diagonal, distribution::first_largest, vertex_field};

register!(Metric: ComponentMotion);

/// Distance and rotation of components against the known result.
///
/// Components are those of the welded surface. The result is first moved so that the mean of its vertices lies on that of the known
/// result. The offset of a component is then the distance between the means of its vertices in both, in percent of the diagonal.
/// Its rotation takes its known vertices to those of the result with least squares, both about their means.
///
/// Vertices that are not finite are left out. Components whose vertices lie on a line have no rotation. There are no statistics for
/// a single component. The field is the offset of the component of a vertex.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct ComponentMotion {}

#[typetag::serde(name = "component_motion")]
impl Metric for ComponentMotion {
    fn bind<'a>(&self, context: MetricContext<'a>) -> Result<Box<dyn BoundMetric + 'a>> {
        let diagonal = diagonal::of_target(context.surface)?;
        let components = context.surface.components();
        let (of_vertex, count) = (components.of_vertex.clone(), components.count());
        Ok(Box::new(Bound { context, diagonal, of_vertex, count }))
    }

    fn statistics(&self) -> Vec<Statistic> {
        vec![
            Statistic::new("offset_mean", "%", "Mean offset over components."),
            Statistic::new("offset_max", "%", "Largest offset of a component.")
                .with_title("largest offset of a part")
                .with_limits(2.0, 5.0),
            Statistic::new("rotation_mean", "degrees", "Mean angle of rotation over components."),
            Statistic::new("rotation_max", "degrees", "Largest angle of rotation of a component."),
            Statistic::index("worst", "Component with the largest offset, numbered by first vertex."),
            Statistic::new("components", "count", "Components that are measured."),
        ]
    }

    fn fault(&self) -> &'static str {
        "parts are out of place against the known result"
    }

    fn needs_ground_truth(&self) -> bool {
        true
    }

    fn by_default(&self) -> bool {
        true
    }
}

struct Bound<'a> {
    context: MetricContext<'a>,
    diagonal: f64,
    of_vertex: Vec<Option<u32>>,
    count: usize,
}

impl BoundMetric for Bound<'_> {
    fn measure(&self, input: MetricInput<'_>) -> Result<Measured> {
        self.context.check(&input)?;
        let Some(ground_truth) = input.ground_truth.filter(|_| self.count > 1) else { return Ok(Measured::default()) };
        let surface = self.context.surface;
        let (result, known) = (input.result.surface, ground_truth.surface);
        let mut members: Vec<Vec<(Vector3<f64>, Vector3<f64>)>> = vec![vec![]; self.count];
        for ((p, q), component) in result.iter().zip(known).zip(&self.of_vertex) {
            if let (Some(c), true) = (component, vertex_field::is_finite(p) && vertex_field::is_finite(q)) {
                members[*c as usize].push((p.coords, q.coords));
            }
        }
        let total = members.iter().map(Vec::len).sum::<usize>() as f64;
        if total == 0.0 {
            return Ok(Measured::default());
        }
        let shift = members.iter().flatten().map(|(p, q)| p - q).sum::<Vector3<f64>>() / total;
        let mut offsets = vec![f64::NAN; self.count];
        let mut angles = Vec::new();
        for (offset, members) in offsets.iter_mut().zip(&members).filter(|(_, members)| !members.is_empty()) {
            let number = members.len() as f64;
            let p_mean = members.iter().map(|(p, _)| p).sum::<Vector3<f64>>() / number;
            let q_mean = members.iter().map(|(_, q)| q).sum::<Vector3<f64>>() / number;
            *offset = 100.0 * (p_mean - q_mean - shift).norm() / self.diagonal;
            let covariance = members.iter().map(|(p, q)| (p - p_mean) * (q - q_mean).transpose()).sum();
            angles.extend(rotation_angle(&covariance));
        }
        let finite: Vec<f64> = offsets.iter().copied().filter(|offset| offset.is_finite()).collect();
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let max = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
        let mut statistics = Figures::default();
        statistics.set("offset_mean", mean(&finite));
        statistics.set("offset_max", max(&finite));
        if !angles.is_empty() {
            statistics.set("rotation_mean", mean(&angles));
            statistics.set("rotation_max", max(&angles));
        }
        let worst = first_largest(&offsets).unwrap_or(0);
        statistics.set("worst", worst);
        statistics.set("components", finite.len());
        let values: Vec<f64> =
            self.of_vertex.iter().map(|component| component.map_or(f64::NAN, |c| offsets[c as usize])).collect();
        let about = vec![("offset_max", component_pairs::describe(surface, worst))];
        let field = vertex_field::on_mesh(surface, &values);
        Ok(Measured { statistics, about, field, field_unit: "offset, %", field_high: 10.0 })
    }
}

/// The angle of the rotation nearest to `covariance`, in degrees; `None` if the points lie on a line.
fn rotation_angle(covariance: &Matrix3<f64>) -> Option<f64> {
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
    use crate::testing::{against, alone, assert_statistic, moved};

    #[test]
    fn a_component_moved_by_d_and_turned_is_off_by_half_of_d_and_by_its_angle() {
        let spheres = meshes::two_components();
        let half = spheres.vertex_count() / 2;
        let turn = Rotation3::new(Vector3::new(0.0, 30f64.to_radians(), 0.0));
        let centre = nalgebra::Point3::new(3.0, 0.0, 0.0);
        let mut posed = spheres.positions.clone();
        let by = Vector3::z() * 0.2 * spheres.diagonal();
        posed[half..].iter_mut().for_each(|p| *p = centre + turn * (*p - centre) + by);
        let statistics = against(&ComponentMotion {}, &spheres, &posed, &spheres.positions);
        // Both spheres have as many vertices, so the move of the whole takes half of it.
        assert_statistic(&statistics, "offset_max", 10.0, 1e-10);
        assert_statistic(&statistics, "offset_mean", 10.0, 1e-10);
        assert_statistic(&statistics, "rotation_max", 30.0, 1e-9);
        assert_statistic(&statistics, "rotation_mean", 15.0, 1e-9);
        assert_statistic(&statistics, "components", 2.0, 0.0);
    }

    #[test]
    fn a_move_of_everything_is_no_error_and_there_are_no_statistics_without_a_known_result() {
        let spheres = meshes::two_components();
        let posed = moved(&spheres.positions, Vector3::new(1.0, 2.0, 3.0));
        let statistics = against(&ComponentMotion {}, &spheres, &posed, &spheres.positions);
        ["offset_max", "rotation_max"].iter().for_each(|name| assert_statistic(&statistics, name, 0.0, 1e-10));
        assert!(alone(&ComponentMotion {}, &spheres, &posed).statistics.values.is_empty());
    }
}
