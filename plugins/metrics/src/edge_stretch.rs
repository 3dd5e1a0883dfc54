//! How much edges grow and shrink.

use mimesh_core::{
    Figures, Result, register,
    stage::{BoundMetric, Limits, Measured, Metric, MetricContext, MetricInput, Statistic},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{
    diagonal, elements,
    size_change::{self, PosedSizes, SizeChange},
    source_pose::SourcePoses,
};

register!(Metric: EdgeStretch);

/// How much edges grow and shrink, beyond the edges of the source.
///
/// An edge of length l₀ at rest and l in the pose has s = ln(l / l₀). Its change is 100 (e^|s| − 1) percent, so that twice as long
/// and half as long are both 100 %. The median is 100 (eᵐ − 1) with m the median of s, and has a sign. Percentiles count each edge
/// by l₀.
///
/// The jump is the largest change of a length, |l / κ − l₀| in percent of the diagonal: a vertex that is off by itself has a jump of
/// about that distance. The scale κ is that of the source's pose, its median stretch. The jump of the source is multiplied by the
/// ratio of mean lengths, since longer edges change by more.
///
/// Edges shorter than 1e-5 of the diagonal at rest are left out. Shorter lengths in the pose count as that length. The field is the
/// largest change of the edges at a vertex, less `source_p99`.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct EdgeStretch {}

#[typetag::serde(name = "edge_stretch")]
impl Metric for EdgeStretch {
    fn bind<'a>(&self, context: MetricContext<'a>) -> Result<Box<dyn BoundMetric + 'a>> {
        let target = elements::edges(context.surface);
        let source = context.pair.map(|pair| elements::edges(pair.source));
        let diagonal = diagonal::of_target(context.surface)?;
        let poses = context.pair.map(|pair| SourcePoses::new(pair.source));
        let sizes = SizeChange { context, target, source, field_unit: "stretch, %", field_high: 100.0 };
        Ok(Box::new(Bound { sizes, diagonal, source: poses }))
    }

    fn statistics(&self) -> Vec<Statistic> {
        let beyond = Limits { doubtful: 120.0, bad: 500.0 };
        let mut statistics = size_change::statistics(
            beyond,
            Limits { doubtful: 10.0, bad: 40.0 },
            ["stretch beyond the source's", "change of the whole size beyond the source's"],
        );
        // An even scale that the source has too is no fault of the transfer, but perhaps of the units.
        let scale = Limits { doubtful: 50.0, bad: 100_000.0 };
        statistics.iter_mut().filter(|one| one.name == "median").for_each(|one| {
            *one = one.with_title("change of the whole size, as by other units").with_limits(scale.doubtful, scale.bad);
        });
        statistics.extend([
            Statistic::new("jump", "%", "Largest change of a length, in percent of the diagonal."),
            Statistic::new("source_jump", "%", "The same as `jump`, of the source, for edges as long as the target's."),
            Statistic::new(
                "tear",
                "%",
                "How much `jump` exceeds `source_jump`, relative to the largest motion of the source + 1 %.",
            )
            .with_title("tearing beyond the source's")
            .with_limits(16.0, 80.0),
        ]);
        statistics
    }

    fn fault(&self) -> &'static str {
        "edges stretch where those of the source do not: a vertex, a lip or a seam may follow the wrong part"
    }

    fn by_default(&self) -> bool {
        true
    }
}

struct Bound<'a> {
    sizes: SizeChange<'a, 2>,
    /// The diagonal of the target at rest.
    diagonal: f64,
    source: Option<SourcePoses<'a>>,
}

impl BoundMetric for Bound<'_> {
    fn measure(&self, input: MetricInput<'_>) -> Result<Measured> {
        let sizes = self.sizes.sizes(&input)?;
        let mut measured = self.sizes.measured(&sizes, input.wants_field);
        if !measured.statistics.values.is_empty() {
            self.jumps(input, &sizes, &mut measured.statistics);
        }
        Ok(measured)
    }
}

impl Bound<'_> {
    /// Sets the statistics of the largest change of a length.
    fn jumps(&self, input: MetricInput<'_>, sizes: &PosedSizes, statistics: &mut Figures) {
        let target = &self.sizes.target;
        let found = |scale: f64| 100.0 * jump(&target.rest, &sizes.target, scale) / self.diagonal;
        let (Some(poses), Some(posed), Some(lengths)) = (&self.source, input.source, &sizes.source) else {
            statistics.set("jump", found(1.0));
            return;
        };
        let frame = poses.frame_of(posed, lengths);
        let jump_found = found(frame.scale);
        // Lengths relative to the diagonals: a mesh of longer edges has larger jumps.
        let longer = (target.mean_rest() / self.diagonal) / (poses.edges.mean_rest() / poses.diagonal);
        let of_source = 100.0 * jump(&poses.edges.rest, lengths, frame.scale) / poses.diagonal * longer;
        let reach = poses.reach(posed, &frame);
        statistics.set("jump", jump_found);
        statistics.set("source_jump", of_source);
        statistics.set("tear", 100.0 * (jump_found - of_source).max(0.0) / (reach + 1.0));
    }
}

/// The largest finite |l / scale − l₀|, of lengths l₀ at `rest` and l in the pose.
fn jump(rest: &[f64], posed: &[f64], scale: f64) -> f64 {
    let change = |(rest, posed): (&f64, &f64)| (posed / scale - rest).abs();
    rest.iter().zip(posed).map(change).filter(|change| change.is_finite()).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use mimesh_core::testkit::meshes;
    use nalgebra::{Point3, Rotation3, Vector3};

    use super::*;
    use crate::testing::{alone, assert_statistic, scaled, with_source};

    /// Some roundings of numbers of size 100.
    const ROUNDING: f64 = 1e-10;

    #[test]
    fn twice_as_large_and_half_as_large_are_both_stretched_by_a_hundred_percent() {
        let sphere = meshes::icosphere(2);
        let statistics = alone(&EdgeStretch {}, &sphere, &scaled(&sphere.positions, 2.0)).statistics;
        ["p99", "max", "median"].iter().for_each(|name| assert_statistic(&statistics, name, 100.0, ROUNDING));
        assert!(statistics.number("beyond").is_none(), "nothing is known of a source");
        let statistics = alone(&EdgeStretch {}, &sphere, &scaled(&sphere.positions, 0.5)).statistics;
        assert_statistic(&statistics, "p99", 100.0, ROUNDING);
        assert_statistic(&statistics, "median", -50.0, ROUNDING);
    }

    #[test]
    fn a_sheared_plane_stretches_its_three_kinds_of_edges_as_it_should() {
        // Unit cells of edges (1, 0), (0, 1) and (1, 1); sheared they are (1, 0), (1, 1) and (2, 1).
        let grid = meshes::grid(8, 8);
        let sheared: Vec<_> = grid.positions.iter().map(|p| Point3::new(p.x + p.y, p.y, 0.0)).collect();
        let statistics = alone(&EdgeStretch {}, &grid, &sheared).statistics;
        let (up, across) = (100.0 * (2f64.sqrt() - 1.0), 100.0 * (2.5f64.sqrt() - 1.0));
        assert_statistic(&statistics, "p99", across, ROUNDING);
        assert_statistic(&statistics, "max", across, ROUNDING);
        // 72 edges of 1/8 each way, 64 of √2/8: half of the weight lies below those that grow by √2.
        assert_statistic(&statistics, "median", up, ROUNDING);
    }

    #[test]
    fn a_rotation_stretches_nothing_and_what_the_source_does_too_is_not_beyond() {
        let sphere = meshes::icosphere(2);
        let turn = Rotation3::new(Vector3::new(1.0, -0.4, 2.0));
        let turned: Vec<_> = sphere.positions.iter().map(|p| turn * p).collect();
        let larger = scaled(&sphere.positions, 1.5);
        assert_statistic(&alone(&EdgeStretch {}, &sphere, &turned).statistics, "max", 0.0, ROUNDING);
        assert_statistic(&with_source(&EdgeStretch {}, &sphere, &larger, &larger), "beyond", 0.0, 0.0);
        let statistics = with_source(&EdgeStretch {}, &sphere, &larger, &turned);
        assert_statistic(&statistics, "beyond", 50.0, ROUNDING);
        assert_statistic(&statistics, "source_p99", 0.0, ROUNDING);
    }

    #[test]
    fn edges_without_length_are_left_out_and_edges_that_vanish_have_a_finite_stretch() {
        let mut grid = meshes::grid(4, 4);
        grid.positions[6] = grid.positions[7];
        let statistics = alone(&EdgeStretch {}, &grid, &grid.positions).statistics;
        assert_statistic(&statistics, "left_out", 1.0, 0.0);
        assert_statistic(&statistics, "max", 0.0, ROUNDING);
        let point = vec![Point3::origin(); grid.vertex_count()];
        assert!(alone(&EdgeStretch {}, &grid, &point).statistics.number("max").unwrap() > 1e5);
    }

    #[test]
    fn the_field_shows_where_it_is() {
        let grid = meshes::grid(4, 4);
        let mut posed = grid.positions.clone();
        posed[12].z += 1.0;
        let field = alone(&EdgeStretch {}, &grid, &posed).field;
        let largest = field.iter().copied().fold(0.0, f64::max);
        assert_eq!(field[12], largest);
        assert_eq!(field[0], 0.0, "a corner far from it is as it was");
    }
}
