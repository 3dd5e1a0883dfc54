//! Feet that slide.

use mimesh_core::{
    Error, Figures, Result,
    mesh::SurfacePoint,
    register,
    stage::{BoundMetric, Limit, Measured, Metric, MetricContext, MetricInput, TransferPair},
};
use nalgebra::Point3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{size, spread::Spread};

register!(Metric: ContactSlide);

/// Feet that slide: how far parts of the target move since the frame before, where the source stands still on the ground.
///
/// A vertex of the target is planted if the point of the source that it takes its motion from moved less than `still` since the
/// frame before, and lies within `height` above the lowest point of the source, both at rest. Its slide is how far it moved itself
/// since then, in percent of the target's diagonal. Figures:
/// - `mean`, `p95`, `max` of the slides; `planted`: number of planted vertices, of the welded surface.
///
/// There are no figures where nothing is planted, without a frame before, and without a map from the target to the source.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct ContactSlide {
    /// A point of the source stands still if it moves less than this between two frames, in percent of the source's diagonal.
    pub still: f64,
    /// The ground reaches this high above the lowest point of the source at rest, in percent of the source's diagonal.
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
    fn bind<'a>(&self, subject: MetricContext<'a>) -> Result<Box<dyn BoundMetric + 'a>> {
        Error::check_setting("still", self.still, 0.0, 100.0)?;
        Error::check_setting("height", self.height, 0.0, 100.0)?;
        let diagonal = size::of_rest(subject.rest)?;
        let (Some(pair), Some(map)) = (subject.pair, subject.map) else {
            return Ok(Box::new(Bound { subject, diagonal, still: 0.0, low: vec![] }));
        };
        let source_diagonal = size::of_source(pair.source)?;
        let low = self.low(pair, &map.source_points(pair)?, self.height / 100.0 * source_diagonal);
        Ok(Box::new(Bound { subject, diagonal, still: self.still / 100.0 * source_diagonal, low }))
    }

    fn figures(&self) -> Vec<&'static str> {
        vec!["mean", "p95", "max", "planted"]
    }

    fn limits(&self) -> Vec<Limit> {
        vec![Limit { figure: "p95", doubtful: 1.0, bad: 3.0 }]
    }

    fn by_default(&self) -> bool {
        true
    }
}

impl ContactSlide {
    /// The vertices of the target that lie on what is low of the source at rest, with their points there.
    fn low(&self, pair: TransferPair<'_>, points: &[SurfacePoint], height: f64) -> Vec<(u32, SurfacePoint)> {
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
    subject: MetricContext<'a>,
    diagonal: f64,
    /// In the unit of the source.
    still: f64,
    low: Vec<(u32, SurfacePoint)>,
}

impl BoundMetric for Bound<'_> {
    fn measure(&self, pose: MetricInput<'_>) -> Result<Measured> {
        self.subject.check(&pose)?;
        let (Some(pair), Some(now), Some(before)) = (self.subject.pair, pose.source, pose.before[0]) else {
            return Ok(Measured::default());
        };
        let Some(source_before) = before.source else { return Ok(Measured::default()) };
        let surface = self.subject.surface;
        let (result, result_before) = (surface.from_mesh(pose.result)?, surface.from_mesh(before.result)?);
        let mut values = vec![f64::NAN; surface.vertex_count()];
        for (v, point) in &self.low {
            let at = |positions: &[Point3<f64>]| point.position(pair.source, positions);
            let slide = 100.0 * (result[*v as usize] - result_before[*v as usize]).norm() / self.diagonal;
            if (at(now) - at(source_before)).norm() < self.still && slide.is_finite() {
                values[*v as usize] = slide;
            }
        }
        let Some(slides) = Spread::even(values.iter().copied()) else { return Ok(Measured::default()) };
        let mut figures = Figures::default();
        figures.set("mean", slides.mean());
        figures.set("p95", slides.percentile(0.95));
        figures.set("max", slides.max());
        figures.set("planted", slides.count());
        Ok(Measured {
            figures,
            about: vec![],
            field: size::field(surface, &values),
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
    use crate::testing::{assert_figure, frames, moved};

    fn slide(target: &Surface, result: [&[Point3<f64>]; 2], source: [&[Point3<f64>]; 2], up: Axis) -> Figures {
        let map = TriangleMap {
            source_triangles: target.triangle_count(),
            partners: (0..target.triangle_count() as u32).map(Some).collect(),
            ..TriangleMap::default()
        };
        let mesh = Mesh::from_triangles(target.positions.clone(), &target.triangles);
        let pair = TransferPair { source: target, target, markers: &[], proximity: None };
        let subject = MetricContext { pair: Some(pair), map: Some(&map), ..MetricContext::alone(&mesh, target) };
        let metric = ContactSlide { up, ..ContactSlide::default() };
        frames(subject, &metric, [result[0], result[1], result[1]], [source[0], source[1], source[1]])
    }

    #[test]
    fn the_foot_of_a_bar_that_stands_slides_by_as_much_as_it_moves() {
        let bar = meshes::bar([2, 6, 2], [0.2, 1.0, 0.2]);
        let foot = bar.positions.iter().filter(|p| p.y < -0.49).count();
        let slid = moved(&bar.positions, Vector3::x() * 0.05 * bar.diagonal());
        // The source leans over its foot.
        let leaning: Vec<_> = bar.positions.iter().map(|p| p + Vector3::x() * (p.y + 0.5)).collect();
        let figures = slide(&bar, [&slid, &bar.positions], [&leaning, &bar.positions], Axis::Y);
        assert_figure(&figures, "planted", foot as f64, 0.0);
        ["mean", "p95", "max"].iter().for_each(|name| assert_figure(&figures, name, 5.0, 1e-12));
        let figures = slide(&bar, [&leaning, &bar.positions], [&leaning, &bar.positions], Axis::Y);
        assert_figure(&figures, "max", 0.0, 1e-12);
    }

    #[test]
    fn nothing_is_planted_where_the_source_walks_and_up_says_where_the_ground_is() {
        let bar = meshes::bar([2, 6, 2], [0.2, 1.0, 0.2]);
        let slid = moved(&bar.positions, Vector3::x() * 0.05);
        assert!(slide(&bar, [&slid, &bar.positions], [&slid, &bar.positions], Axis::Y).values.is_empty());
        let side = bar.positions.iter().filter(|p| p.x < -0.09).count();
        let figures = slide(&bar, [&slid, &bar.positions], [&bar.positions, &bar.positions], Axis::X);
        assert_figure(&figures, "planted", side as f64, 0.0);
    }
}
