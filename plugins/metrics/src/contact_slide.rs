//! Feet that slide.

use mimesh_core::{
    Figures, Result,
    mesh::SurfacePoint,
    plugin::check_ranges,
    register,
    stage::{BoundMetric, Measured, Metric, MetricContext, MetricInput, Statistic, TransferPair},
};
use nalgebra::Point3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{diagonal, distribution::Distribution, motion, vertex_field};

register!(Metric: ContactSlide);

/// Feet that slide: motion of the target where the source stands still on the ground.
///
/// Each vertex of the target takes its motion from a point of the source. It is planted if that point moved less than `still` since
/// the frame before. At rest the point must also lie at most `height` above the lowest point of the source. The slide of a planted
/// vertex is how far it moved since the frame before, in percent of the target's diagonal.
///
/// Poses in their order count as frames if the source moves on in the last three of them, as for `jitter`. There are no statistics
/// where it does not, if no vertex is planted, without two frames before, or without a map from the target to the source. The field
/// is the slide of each planted vertex.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct ContactSlide {
    /// A point of the source stands still if it moves less than this between two frames, in percent of the source's diagonal.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub still: f64,
    /// The ground reaches this high above the lowest point of the source at rest, in percent of the source's diagonal.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub height: f64,
    /// The axis of the source that points upwards.
    pub up: Axis,
}

/// An axis of a mesh.
#[derive(Clone, Copy, Debug, Default, Deserialize, Eq, JsonSchema, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Axis {
    /// The first coordinate.
    X,
    /// The second coordinate.
    #[default]
    Y,
    /// The third coordinate.
    Z,
}

impl Default for ContactSlide {
    fn default() -> Self {
        Self { still: 0.1, height: 2.0, up: Axis::Y }
    }
}

#[typetag::serde(name = "contact_slide")]
impl Metric for ContactSlide {
    fn bind<'a>(&self, context: MetricContext<'a>) -> Result<Box<dyn BoundMetric + 'a>> {
        check_ranges(self)?;
        let diagonal = diagonal::of_target(context.surface)?;
        let (Some(pair), Some(map)) = (context.pair, context.map) else {
            return Ok(Box::new(Bound { context, diagonal, source_diagonal: diagonal, still: 0.0, contacts: vec![] }));
        };
        let source_diagonal = diagonal::of_source(pair.source)?;
        let contacts = self.foot_contacts(pair, &map.source_points(pair)?, self.height / 100.0 * source_diagonal);
        let still = self.still / 100.0 * source_diagonal;
        Ok(Box::new(Bound { context, diagonal, source_diagonal, still, contacts }))
    }

    fn statistics(&self) -> Vec<Statistic> {
        vec![
            Statistic::new("mean", "%", "Mean slide over planted vertices."),
            Statistic::new("p95", "%", "95th percentile of the slide over planted vertices.")
                .with_title("slide of feet on the ground")
                .with_limits(1.0, 15.0),
            Statistic::new("max", "%", "Largest slide of a planted vertex."),
            Statistic::new("planted", "count", "Planted vertices of the welded surface."),
        ]
    }

    fn fault(&self) -> &'static str {
        "feet slide where those of the source stand"
    }

    fn by_default(&self) -> bool {
        true
    }
}

impl ContactSlide {
    /// The vertices of the target that correspond to points of the source near the ground at rest, with these points.
    fn foot_contacts(&self, pair: TransferPair<'_>, points: &[SurfacePoint], height: f64) -> Vec<(u32, SurfacePoint)> {
        let up = self.up as usize;
        let rest = &pair.source.positions;
        // A stray vertex below the feet is no ground.
        let used = pair.source.triangles.iter().flatten();
        let ground = used.map(|&v| rest[v as usize][up]).fold(f64::INFINITY, f64::min);
        let is_low = |point: &SurfacePoint| point.position(pair.source, rest)[up] <= ground + height;
        (0..).zip(points.iter().copied()).filter(|(_, point)| is_low(point)).collect()
    }
}

struct Bound<'a> {
    context: MetricContext<'a>,
    diagonal: f64,
    source_diagonal: f64,
    /// The largest motion of a point that stands still, in the unit of the source.
    still: f64,
    /// Vertices of the target with their points of the source, where those lie near the ground at rest.
    contacts: Vec<(u32, SurfacePoint)>,
}

impl BoundMetric for Bound<'_> {
    fn measure(&self, input: MetricInput<'_>) -> Result<Measured> {
        self.context.check(&input)?;
        let (Some(pair), Some(now), [Some(before), Some(first)]) = (self.context.pair, input.source, input.before)
        else {
            return Ok(Measured::default());
        };
        let (Some(source_before), Some(source_first)) = (before.source, first.source) else {
            return Ok(Measured::default());
        };
        if !motion::are_frames([now, source_before, source_first], self.source_diagonal) {
            return Ok(Measured::default());
        }
        let surface = self.context.surface;
        let (result, result_before) = (input.result.surface, before.result.surface);
        let mut values = vec![f64::NAN; surface.vertex_count()];
        for (v, point) in &self.contacts {
            let at = |positions: &[Point3<f64>]| point.position(pair.source, positions);
            let slide = 100.0 * (result[*v as usize] - result_before[*v as usize]).norm() / self.diagonal;
            if (at(now) - at(source_before)).norm() < self.still && slide.is_finite() {
                values[*v as usize] = slide;
            }
        }
        let Some(slides) = Distribution::unweighted(values.iter().copied()) else { return Ok(Measured::default()) };
        let mut statistics = Figures::default();
        statistics.set("mean", slides.mean());
        statistics.set("p95", slides.percentile(0.95));
        statistics.set("max", slides.max());
        statistics.set("planted", slides.count());
        Ok(Measured {
            statistics,
            about: vec![],
            field: vertex_field::on_mesh(surface, &values),
            field_unit: "slide, %",
            field_high: 3.0,
        })
    }
}

#[cfg(test)]
mod tests {
    use mimesh_core::{
        mesh::{Mesh, Surface},
        stage::TriangleMap,
        testkit::meshes,
    };
    use nalgebra::Vector3;

    use super::*;
    use crate::testing::{assert_statistic, frames, moved};

    fn slide(target: &Surface, result: [&[Point3<f64>]; 2], source: [&[Point3<f64>]; 3], up: Axis) -> Figures {
        let map = TriangleMap {
            source_triangle_count: target.triangle_count(),
            triangles: (0..target.triangle_count() as u32).map(Some).collect(),
            ..TriangleMap::default()
        };
        let mesh = Mesh::from_triangles(target.positions.clone(), &target.triangles);
        let pair = TransferPair { source: target, target, markers: &[], proximity: None };
        let context = MetricContext { pair: Some(pair), map: Some(&map), ..MetricContext::alone(&mesh, target) };
        let metric = ContactSlide { up, ..ContactSlide::default() };
        frames(context, &metric, [result[0], result[1], result[1]], source)
    }

    #[test]
    fn the_foot_of_a_bar_that_stands_slides_by_as_much_as_it_moves() {
        let bar = meshes::bar([2, 6, 2], [0.2, 1.0, 0.2]);
        let foot = bar.positions.iter().filter(|p| p.y < -0.49).count();
        let slid = moved(&bar.positions, Vector3::x() * 0.05 * bar.diagonal());
        // The source leans over its foot, farther and farther.
        let leaning = |by: f64| bar.positions.iter().map(|p| p + Vector3::x() * by * (p.y + 0.5)).collect::<Vec<_>>();
        let (leaning, halfway) = (leaning(1.0), leaning(0.5));
        let source: [&[Point3<f64>]; 3] = [&leaning, &halfway, &bar.positions];
        let statistics = slide(&bar, [&slid, &bar.positions], source, Axis::Y);
        assert_statistic(&statistics, "planted", foot as f64, 0.0);
        ["mean", "p95", "max"].iter().for_each(|name| assert_statistic(&statistics, name, 5.0, 1e-12));
        let statistics = slide(&bar, [&leaning, &halfway], source, Axis::Y);
        assert_statistic(&statistics, "max", 0.0, 1e-12);
        let unrelated = [&leaning[..], &bar.positions, &leaning];
        assert!(slide(&bar, [&slid, &bar.positions], unrelated, Axis::Y).values.is_empty(), "no motion");
    }

    #[test]
    fn nothing_is_planted_where_the_source_walks_and_up_says_where_the_ground_is() {
        let bar = meshes::bar([2, 6, 2], [0.2, 1.0, 0.2]);
        let rest = &bar.positions[..];
        let (slid, halfway) = (moved(rest, Vector3::x() * 0.05), moved(rest, Vector3::x() * 0.025));
        assert!(slide(&bar, [&slid, rest], [&slid, &halfway, rest], Axis::Y).values.is_empty());
        let side = bar.positions.iter().filter(|p| p.x < -0.09).count();
        let statistics = slide(&bar, [&slid, rest], [rest; 3], Axis::X);
        assert_statistic(&statistics, "planted", side as f64, 0.0);
    }
}
