//! How much edges or triangles grow and shrink: the common part of `edge_stretch` and `area_change`.

use mimesh_core::{
    Figures, Result,
    stage::{BoundMetric, Limits, Measured, MetricContext, MetricInput, Statistic},
};
use nalgebra::Point3;

use crate::{
    distribution::Distribution,
    elements::{Corners, Elements},
    vertex_field,
};

/// The statistics of both metrics, with the limits of `beyond` and `median_beyond`, and the titles of both.
pub fn statistics(beyond: Limits, median: Limits, titles: [&'static str; 2]) -> Vec<Statistic> {
    vec![
        Statistic::new("beyond", "%", "How much 1 + `p99` is larger than 1 + `source_p99`; 0 if it is not.")
            .with_title(titles[0])
            .with_limits(beyond.doubtful, beyond.bad),
        Statistic::new("p99", "%", "99th percentile of the change."),
        Statistic::new("max", "%", "Largest change."),
        Statistic::new("median", "%", "Median change with its sign."),
        Statistic::new(
            "median_beyond",
            "%",
            "How much 1 + `median` differs from 1 + `source_median`; it shows a scale that the source has not.",
        )
        .with_title(titles[1])
        .with_limits(median.doubtful, median.bad),
        Statistic::new("source_p99", "%", "The same as `p99`, of the source."),
        Statistic::new("source_max", "%", "The same as `max`, of the source."),
        Statistic::new("source_median", "%", "The same as `median`, of the source."),
        Statistic::new(
            "left_out",
            "count",
            "Edges or triangles that are too small at rest, or not finite in the pose.",
        ),
    ]
}

/// A bound metric of edges (N = 2) or triangles (N = 3).
pub struct SizeChange<'a, const N: usize> {
    pub context: MetricContext<'a>,
    pub target: Elements<N>,
    /// The elements of the source, if it is known.
    pub source: Option<Elements<N>>,
    pub field_unit: &'static str,
    pub field_high: f64,
}

/// Percentiles of the change over one surface in one pose, each as the ratio of sizes, eˢ or e^|s|.
struct Percentiles {
    p99: f64,
    max: f64,
    median: f64,
}

/// The sizes of elements in a pose.
pub struct PosedSizes {
    /// Those of the target.
    pub target: Vec<f64>,
    /// Those of the source, if they are known.
    pub source: Option<Vec<f64>>,
}

impl<const N: usize> SizeChange<'_, N>
where
    [Point3<f64>; N]: Corners,
{
    /// The sizes of the elements in the pose.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`](mimesh_core::Error::Shape) if vertex counts differ.
    pub fn sizes(&self, input: &MetricInput<'_>) -> Result<PosedSizes> {
        self.context.check(input)?;
        let source = self.source.as_ref().zip(input.source).map(|(elements, posed)| elements.sizes(posed));
        Ok(PosedSizes { target: self.target.sizes(input.result.surface), source })
    }

    /// The statistics and the field; no statistics if no size is finite.
    pub fn measured(&self, sizes: &PosedSizes, wants_field: bool) -> Measured {
        let ratios = self.target.ratios(&sizes.target);
        let Some(target) = percentiles(&ratios, &self.target.rest) else { return Measured::default() };
        let source = self.source.as_ref().zip(sizes.source.as_ref());
        let source = source.and_then(|(elements, sizes)| percentiles(&elements.ratios(sizes), &elements.rest));

        let mut statistics = Figures::default();
        if let Some(source) = &source {
            statistics.set("beyond", percent((target.p99 / source.p99).max(1.0)));
        }
        statistics.set("p99", percent(target.p99));
        statistics.set("max", percent(target.max));
        statistics.set("median", percent(target.median));
        if let Some(source) = &source {
            statistics.set("median_beyond", percent(without_sign(target.median / source.median)));
            statistics.set("source_p99", percent(source.p99));
            statistics.set("source_max", percent(source.max));
            statistics.set("source_median", percent(source.median));
        }
        let not_finite = ratios.iter().filter(|ratio| !ratio.is_finite()).count();
        statistics.set("left_out", self.target.left_out + not_finite);
        let field =
            if wants_field { self.field(&ratios, source.map_or(0.0, |source| percent(source.p99))) } else { vec![] };
        Measured { about: vec![], statistics, field, field_unit: self.field_unit, field_high: self.field_high }
    }

    /// The largest change of the elements at each vertex of the target's mesh, less `source_p99`.
    fn field(&self, ratios: &[f64], source_p99: f64) -> Vec<f64> {
        let surface = self.context.surface;
        let mut values = vec![f64::NAN; surface.vertex_count()];
        for (corners, ratio) in self.target.corners.iter().zip(ratios).filter(|(_, ratio)| ratio.is_finite()) {
            vertex_field::raise(&mut values, corners, (percent(without_sign(*ratio)) - source_p99).max(0.0));
        }
        vertex_field::on_mesh(surface, &values)
    }
}

impl<const N: usize> BoundMetric for SizeChange<'_, N>
where
    [Point3<f64>; N]: Corners,
{
    fn measure(&self, input: MetricInput<'_>) -> Result<Measured> {
        Ok(self.measured(&self.sizes(&input)?, input.wants_field))
    }
}

/// The change of a size that is `ratio` times what it was.
fn percent(ratio: f64) -> f64 {
    100.0 * (ratio - 1.0)
}

/// e^|s| of a ratio eˢ.
fn without_sign(ratio: f64) -> f64 {
    ratio.max(1.0 / ratio)
}

fn percentiles(ratios: &[f64], weights: &[f64]) -> Option<Percentiles> {
    let weighted = || ratios.iter().copied().zip(weights.iter().copied());
    let signed = Distribution::weighted(weighted())?;
    let sizes = Distribution::weighted(weighted().map(|(ratio, weight)| (without_sign(ratio), weight)))?;
    Some(Percentiles { p99: sizes.percentile(0.99), max: sizes.max(), median: signed.percentile(0.5) })
}
