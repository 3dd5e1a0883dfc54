//! How much triangles grow and shrink.

use mimesh_core::{
    Result, register,
    stage::{BoundMetric, Limits, Metric, MetricContext, Statistic},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{
    elements,
    size_change::{self, SizeChange},
};

register!(Metric: AreaChange);

/// How much triangles grow and shrink, beyond the triangles of the source.
///
/// A triangle of area A₀ at rest and A in the pose has s = ln(A / A₀). Its change is 100 (e^|s| − 1) percent, so that twice as
/// large and half as large are both 100 %. The median is 100 (eᵐ − 1) with m the median of s, and has a sign. Percentiles count
/// each triangle by A₀.
///
/// Triangles of a height below 1e-5 of the diagonal at rest are left out. Areas below the square of that length count as that
/// square. The field is the largest change of the triangles at a vertex, less `source_p99`.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct AreaChange {}

#[typetag::serde(name = "area_change")]
impl Metric for AreaChange {
    fn bind<'a>(&self, context: MetricContext<'a>) -> Result<Box<dyn BoundMetric + 'a>> {
        let target = elements::triangles(context.surface);
        let source = context.pair.map(|pair| elements::triangles(pair.source));
        Ok(Box::new(SizeChange { context, target, source, field_unit: "area, %", field_high: 300.0 }))
    }

    fn statistics(&self) -> Vec<Statistic> {
        let beyond = Limits { doubtful: 300.0, bad: 2000.0 };
        size_change::statistics(
            beyond,
            Limits { doubtful: 20.0, bad: 100.0 },
            ["change of area beyond the source's", "change of the whole area beyond the source's"],
        )
    }

    fn fault(&self) -> &'static str {
        "triangles grow or shrink where those of the source do not"
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
    use crate::testing::{alone, assert_statistic, scaled};

    #[test]
    fn twice_as_large_has_four_times_the_area() {
        let sphere = meshes::icosphere(2);
        let statistics = alone(&AreaChange {}, &sphere, &scaled(&sphere.positions, 2.0)).statistics;
        // Some roundings of numbers of size 300.
        ["p99", "max", "median"].iter().for_each(|name| assert_statistic(&statistics, name, 300.0, 1e-9));
    }

    #[test]
    fn a_shear_keeps_areas_and_a_stretch_along_one_axis_scales_them() {
        let grid = meshes::grid(8, 8);
        let sheared: Vec<_> = grid.positions.iter().map(|p| Point3::new(p.x + p.y, p.y, 0.0)).collect();
        assert_statistic(&alone(&AreaChange {}, &grid, &sheared).statistics, "max", 0.0, 1e-10);
        let longer: Vec<_> = grid.positions.iter().map(|p| Point3::new(p.x, 1.25 * p.y, 0.0)).collect();
        assert_statistic(&alone(&AreaChange {}, &grid, &longer).statistics, "median", 25.0, 1e-10);
    }
}
