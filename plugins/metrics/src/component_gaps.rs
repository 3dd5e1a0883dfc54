//! Components that drift apart, or run into each other.

use std::collections::BTreeMap;

use mimesh_core::{
    Figures, Result,
    mesh::{Surface, SurfacePoint},
    register,
    stage::{BoundMetric, Measured, Metric, MetricContext, MetricInput, Statistic, TransferPair, TriangleMap},
};
use nalgebra::Point3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{
    component_pairs, diagonal,
    distribution::{Distribution, first_largest},
    source_pose::SourcePoses,
    vertex_field,
};

register!(Metric: ComponentGaps);

/// Components that lie together at rest and drift apart in a pose.
///
/// It looks at pairs of vertices of components that lie within 2 % of the diagonal of each other. Each component has pairs with its
/// six nearest others, at most eight with each: the closest, and in turn the farthest from those chosen. A pair is d₀ apart at rest
/// and d in the pose. It is opened by max(0, d / κ − d₀), in percent of the diagonal, with κ the even scale of the source's pose, its
/// median stretch. If a map is known, a gap may open as far as the two points of the source that its ends follow.
///
/// (The pairs of a pipeline's `proximity` may be far apart, and then open and close with any motion.) There are no statistics for a
/// single component, or for components that all lie alone. The field is the largest opening of the pairs of a vertex.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct ComponentGaps {}

/// The largest distance of a pair at rest, relative to the diagonal.
const MAX_DISTANCE: f64 = 0.02;
/// Pairs closer than this at rest have nothing to close, relative to the diagonal.
const MIN_DISTANCE: f64 = 1e-3;

#[typetag::serde(name = "component_gaps")]
impl Metric for ComponentGaps {
    fn bind<'a>(&self, context: MetricContext<'a>) -> Result<Box<dyn BoundMetric + 'a>> {
        let diagonal = diagonal::of_target(context.surface)?;
        let surface = context.surface;
        let of_vertex = surface.components().of_vertex;
        let target = Gaps::near(surface, diagonal)?;
        let source = context.pair.map(|pair| Gaps::near(pair.source, diagonal::of_source(pair.source)?)).transpose()?;
        let poses = context.pair.map(|pair| SourcePoses::new(pair.source));
        let followed = match (context.pair, context.map) {
            (Some(pair), Some(map)) if !target.pairs.is_empty() => Some(Followed::new(pair, map)?),
            _ => None,
        };
        Ok(Box::new(Bound { context, target, source, poses, followed, of_vertex }))
    }

    fn statistics(&self) -> Vec<Statistic> {
        vec![
            Statistic::new("p99", "%", "99th percentile of the opening over pairs."),
            Statistic::new("beyond", "%", "How much `p99` exceeds `source_p99`; 0 if it does not.")
                .with_title("gaps between parts beyond the source's")
                .with_limits(2.0, 8.0),
            Statistic::new("mean", "%", "Mean opening over pairs."),
            Statistic::new("max", "%", "Largest opening of a pair."),
            Statistic::new(
                "source_p99",
                "%",
                "The same as `p99`, of the components of the source; 0 if it has only one.",
            ),
            Statistic::new(
                "worst_component",
                "%",
                "Largest median opening of the pairs of one component; it shows one loose component among many.",
            )
            .with_title("gap around the loosest part")
            .with_limits(3.0, 8.0),
            Statistic::new(
                "loose",
                "%",
                "The same as `worst_component`, relative to the largest motion of the source + 1 %.",
            )
            .with_title("gap around the loosest part relative to the motion")
            .with_limits(8.0, 60.0),
            Statistic::index("worst", "Component with the largest median opening, numbered by first vertex."),
            Statistic::new(
                "closed",
                "%",
                "Share of pairs closer than half of d₀, among those with d₀ above 0.1 % of the diagonal.",
            ),
            Statistic::new("pairs", "count", "Pairs of vertices that are measured."),
        ]
    }

    fn fault(&self) -> &'static str {
        "parts that lie together at rest drift apart: `transfer: multi_component` with `proximity` holds them"
    }

    fn by_default(&self) -> bool {
        true
    }
}

struct Bound<'a> {
    context: MetricContext<'a>,
    target: Gaps,
    source: Option<Gaps>,
    poses: Option<SourcePoses<'a>>,
    followed: Option<Followed<'a>>,
    /// The component of each vertex.
    of_vertex: Vec<Option<u32>>,
}

impl BoundMetric for Bound<'_> {
    fn measure(&self, input: MetricInput<'_>) -> Result<Measured> {
        self.context.check(&input)?;
        if self.target.pairs.is_empty() {
            return Ok(Measured::default());
        }
        let surface = self.context.surface;
        let scale = self.poses.as_ref().zip(input.source).map_or(1.0, |(poses, posed)| poses.scale(posed));
        let posed: Vec<Point3<f64>> = input.result.surface.iter().map(|p| p / scale).collect();
        let followed = self.followed.as_ref().zip(input.source);
        // A gap may open as far as the points of the source that it follows.
        let allowed = |pair: [u32; 2], rest: f64| {
            rest + followed.map_or(0.0, |(followed, posed)| followed.opening(pair, posed, scale))
        };
        let mut openings = Vec::new();
        let mut values = vec![f64::NAN; surface.vertex_count()];
        let mut of_component: BTreeMap<u32, Vec<f64>> = BTreeMap::new();
        let (mut closed, mut apart) = (0usize, 0usize);
        for (pair, rest, distance) in self.target.distances(&posed) {
            let opening = self.target.opening(allowed(pair, rest), distance);
            openings.push(opening);
            vertex_field::raise(&mut values, &pair, opening);
            for component in pair.iter().filter_map(|&v| self.of_vertex[v as usize]) {
                of_component.entry(component).or_default().push(opening);
            }
            if rest > MIN_DISTANCE * self.target.diagonal {
                apart += 1;
                closed += usize::from(distance < 0.5 * rest);
            }
        }
        let Some(openings) = Distribution::unweighted(openings) else { return Ok(Measured::default()) };
        let mut statistics = Figures::default();
        let p99 = openings.percentile(0.99);
        statistics.set("p99", p99);
        if let Some((source, posed)) = self.source.as_ref().zip(input.source) {
            let posed: Vec<Point3<f64>> = posed.iter().map(|p| p / scale).collect();
            let source_p99 = source.openings(&posed).map_or(0.0, |openings| openings.percentile(0.99));
            statistics.set("beyond", (p99 - source_p99).max(0.0));
            statistics.set("source_p99", source_p99);
        }
        statistics.set("mean", openings.mean());
        statistics.set("max", openings.max());
        let (numbers, medians): (Vec<u32>, Vec<f64>) = of_component
            .into_iter()
            .filter_map(|(component, openings)| Some((component, Distribution::unweighted(openings)?.percentile(0.5))))
            .unzip();
        let mut about = Vec::new();
        if let Some(worst) = first_largest(&medians) {
            statistics.set("worst_component", medians[worst]);
            if let Some((poses, posed)) = self.poses.as_ref().zip(input.source) {
                statistics.set("loose", 100.0 * medians[worst] / (poses.reach(posed, &poses.frame(posed)) + 1.0));
                about.push(("loose", component_pairs::describe(surface, numbers[worst] as usize)));
            }
            statistics.set("worst", numbers[worst]);
            about.push(("worst_component", component_pairs::describe(surface, numbers[worst] as usize)));
        }
        statistics.set("closed", 100.0 * closed as f64 / apart.max(1) as f64);
        statistics.set("pairs", openings.count());
        let field = vertex_field::on_mesh(surface, &values);
        Ok(Measured { statistics, about, field, field_unit: "opened, %", field_high: 6.0 })
    }
}

/// The points of the source that vertices take their motion from.
struct Followed<'a> {
    source: &'a Surface,
    points: Vec<SurfacePoint>,
    /// The size of the target relative to the source.
    size: f64,
}

impl<'a> Followed<'a> {
    fn new(pair: TransferPair<'a>, map: &TriangleMap) -> Result<Self> {
        let size = diagonal::of_target(pair.target)? / diagonal::of_source(pair.source)?;
        Ok(Self { source: pair.source, points: map.source_points(pair)?, size })
    }

    /// How much farther apart the points of a pair are in the pose, in the unit of the target; `scale` is that of the pose.
    fn opening(&self, pair: [u32; 2], posed: &[Point3<f64>], scale: f64) -> f64 {
        let apart = |positions: &[Point3<f64>]| {
            let [a, b] = pair.map(|v| self.points[v as usize].position(self.source, positions));
            (a - b).norm()
        };
        self.size * (apart(posed) / scale - apart(&self.source.positions)).max(0.0)
    }
}

/// Pairs of vertices of one surface and their distances at rest.
struct Gaps {
    pairs: Vec<[u32; 2]>,
    rest: Vec<f64>,
    diagonal: f64,
}

impl Gaps {
    fn new(surface: &Surface, diagonal: f64, pairs: Vec<[u32; 2]>) -> Self {
        let apart = |[a, b]: &[u32; 2]| (surface.positions[*a as usize] - surface.positions[*b as usize]).norm();
        let rest = pairs.iter().map(apart).collect();
        Self { pairs, rest, diagonal }
    }

    /// The pairs of components that lie near each other.
    fn near(surface: &Surface, diagonal: f64) -> Result<Self> {
        Ok(Self::new(surface, diagonal, component_pairs::near(surface, MAX_DISTANCE * diagonal)?))
    }

    /// Each pair with its distances at rest and at `posed`, without pairs whose distance is not finite.
    fn distances(&self, posed: &[Point3<f64>]) -> impl Iterator<Item = ([u32; 2], f64, f64)> {
        let distance = |[a, b]: [u32; 2]| (posed[a as usize] - posed[b as usize]).norm();
        let all = self.pairs.iter().zip(&self.rest).map(move |(pair, rest)| (*pair, *rest, distance(*pair)));
        all.filter(|(_, _, distance)| distance.is_finite())
    }

    /// max(0, d − d₀) in percent of the diagonal.
    fn opening(&self, rest: f64, distance: f64) -> f64 {
        100.0 * (distance - rest).max(0.0) / self.diagonal
    }

    fn openings(&self, posed: &[Point3<f64>]) -> Option<Distribution> {
        Distribution::unweighted(self.distances(posed).map(|(_, rest, distance)| self.opening(rest, distance)))
    }
}

#[cfg(test)]
mod tests {
    use mimesh_core::testkit::meshes;

    use super::*;
    use crate::testing::{alone, assert_statistic, moved, with_source};

    /// Two spheres nearly touching: their gap is 1 % of the first one's diameter.
    fn near_spheres() -> Surface {
        let mut spheres = meshes::two_components();
        let half = spheres.vertex_count() / 2;
        let reach = spheres.positions[..half].iter().map(|p| p.x).fold(0.0, f64::max);
        spheres.positions[half..].iter_mut().for_each(|p| p.x += 2.0 * reach + 0.02 - 3.0);
        spheres
    }

    #[test]
    fn components_moved_apart_by_d_are_opened_by_d() {
        let spheres = near_spheres();
        let half = spheres.vertex_count() / 2;
        let mut posed = spheres.positions.clone();
        let by = 0.1 * spheres.diagonal();
        posed[half..].iter_mut().for_each(|p| p.x += by);
        let statistics = with_source(&ComponentGaps {}, &spheres, &posed, &spheres.positions);
        // The pair lies along x, up to the few other pairs within reach.
        assert_statistic(&statistics, "max", 10.0, 0.2);
        assert_statistic(&statistics, "beyond", statistics.number("p99").unwrap(), 0.0);
        assert_statistic(&with_source(&ComponentGaps {}, &spheres, &posed, &posed), "beyond", 0.0, 0.0);
        posed[half..].iter_mut().for_each(|p| p.x -= by + 0.015);
        let statistics = alone(&ComponentGaps {}, &spheres, &posed).statistics;
        assert_statistic(&statistics, "max", 0.0, 0.0);
        assert!(statistics.number("closed").unwrap() > 0.0, "they come closer than half");
    }

    #[test]
    fn what_moves_as_one_opens_nothing_and_one_component_has_no_gaps() {
        let spheres = near_spheres();
        let statistics =
            alone(&ComponentGaps {}, &spheres, &moved(&spheres.positions, nalgebra::Vector3::new(5.0, 1.0, 0.0)))
                .statistics;
        // Rounding of positions of size 5.
        assert_statistic(&statistics, "max", 0.0, 1e-12);
        let sphere = meshes::icosphere(1);
        assert!(alone(&ComponentGaps {}, &sphere, &sphere.positions).statistics.values.is_empty());
        let far = meshes::two_components();
        assert!(alone(&ComponentGaps {}, &far, &far.positions).statistics.values.is_empty(), "nothing is near");
    }
}
