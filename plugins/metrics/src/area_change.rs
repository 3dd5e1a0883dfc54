//! How much triangles grow and shrink.

use mimesh_core::{
    Result, register,
    stage::{BoundMetric, Limit, Metric, MetricContext},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{
    change::{Change, FIGURES},
    elements,
};

register!(Metric: AreaChange);

/// How much triangles grow and shrink, beyond what the source's triangles do.
///
/// For each triangle of the welded surface s = ln(A / A₀), A its area in the pose and A₀ at rest; its change in percent is
/// 100 (e^|s| − 1), so that twice as large and half as large are both 100 %. Percentiles count each triangle by A₀. Figures:
/// - `p99` and `max` of the change;
/// - `median`: 100 (eᵐ − 1) of the median m of s, with its sign: a wrong scale shows here;
/// - `source_p99`, `source_max`, `source_median`: the same of the source's triangles;
/// - `beyond` = max(0, `p99` − `source_p99`), in percentage points;
/// - `left_out`: triangles of a height below 1e-5 of the diagonal at rest, or with a corner that is not finite.
///
/// Areas below (1e-5 of the diagonal)² count as that. The field is the largest change of the triangles around a vertex beyond
/// `source_p99`.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct AreaChange {}

#[typetag::serde(name = "area_change")]
impl Metric for AreaChange {
    fn bind<'a>(&self, subject: MetricContext<'a>) -> Result<Box<dyn BoundMetric + 'a>> {
        let target = elements::triangles(subject.surface);
        let source = subject.pair.map(|pair| elements::triangles(pair.source));
        Ok(Box::new(Change { subject, target, source, field_unit: "area, %", field_high: 300.0 }))
    }

    fn figures(&self) -> Vec<&'static str> {
        FIGURES.to_vec()
    }

    fn limits(&self) -> Vec<Limit> {
        vec![
            Limit { figure: "beyond", doubtful: 120.0, bad: 300.0 },
            Limit { figure: "median", doubtful: 10.0, bad: 30.0 },
        ]
    }

    fn by_default(&self) -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use mimesh_core::testkit::meshes;
    use nalgebra::Point3;

    use super::*;
    use crate::testing::{alone, assert_figure, scaled};

    #[test]
    fn twice_as_large_has_four_times_the_area() {
        let sphere = meshes::icosphere(2);
        let figures = alone(&AreaChange {}, &sphere, &scaled(&sphere.positions, 2.0)).figures;
        // Some roundings of numbers of size 300.
        ["p99", "max", "median"].iter().for_each(|name| assert_figure(&figures, name, 300.0, 1e-9));
    }

    #[test]
    fn a_shear_keeps_areas_and_a_stretch_along_one_axis_scales_them() {
        let grid = meshes::grid(8, 8);
        let sheared: Vec<_> = grid.positions.iter().map(|p| Point3::new(p.x + p.y, p.y, 0.0)).collect();
        assert_figure(&alone(&AreaChange {}, &grid, &sheared).figures, "max", 0.0, 1e-10);
        let longer: Vec<_> = grid.positions.iter().map(|p| Point3::new(p.x, 1.25 * p.y, 0.0)).collect();
        assert_figure(&alone(&AreaChange {}, &grid, &longer).figures, "median", 25.0, 1e-10);
    }
}
