//! How much edges or triangles grow and shrink: the common part of `edge_stretch` and `area_change`.

use mimesh_core::{
    Figures, Result,
    stage::{BoundMetric, Limits, Measured, MetricContext, MetricInput, Statistic},
};

use crate::{distribution::Distribution, elements::Elements, vertex_field};

/// The statistics of both metrics, with the limits of `beyond` and `median_beyond`.
pub fn statistics(beyond: Limits, median: Limits) -> Vec<Statistic> {
    vec![
        Statistic::new("beyond", "%", "How much 1 + `p99` is larger than 1 + `source_p99`; 0 if it is not.")
            .with_limits(beyond.doubtful, beyond.bad),
        Statistic::new("p99", "%", "99th percentile of the change."),
        Statistic::new("max", "%", "Largest change."),
        Statistic::new("median", "%", "Median change with its sign."),
        Statistic::new(
            "median_beyond",
            "%",
            "How much 1 + `median` differs from 1 + `source_median`; it shows a scale that the source has not.",
        )
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

/// Percentiles of logarithms over one surface in one pose.
struct Percentiles {
    p99: f64,
    max: f64,
    median: f64,
}

impl<const N: usize> BoundMetric for SizeChange<'_, N> {
    fn measure(&self, input: MetricInput<'_>) -> Result<Measured> {
        self.context.check(&input)?;
        let surface = self.context.surface;
        let logarithms = self.target.logarithms(input.result.surface);
        let Some(target) = percentiles(&logarithms, &self.target.rest) else { return Ok(Measured::default()) };
        let source = self.source.as_ref().zip(input.source);
        let source = source.and_then(|(elements, posed)| percentiles(&elements.logarithms(posed), &elements.rest));

        let mut statistics = Figures::default();
        if let Some(source) = &source {
            statistics.set("beyond", growth((target.p99 - source.p99).max(0.0)));
        }
        statistics.set("p99", growth(target.p99));
        statistics.set("max", growth(target.max));
        statistics.set("median", growth(target.median));
        if let Some(source) = &source {
            statistics.set("median_beyond", growth((target.median - source.median).abs()));
            statistics.set("source_p99", growth(source.p99));
            statistics.set("source_max", growth(source.max));
            statistics.set("source_median", growth(source.median));
        }
        let not_finite = logarithms.iter().filter(|s| !s.is_finite()).count();
        statistics.set("left_out", self.target.left_out + not_finite);

        let source_p99 = source.map_or(0.0, |source| growth(source.p99));
        let mut values = vec![f64::NAN; surface.vertex_count()];
        for (corners, s) in self.target.corners.iter().zip(&logarithms).filter(|(_, s)| s.is_finite()) {
            vertex_field::raise(&mut values, corners, (growth(s.abs()) - source_p99).max(0.0));
        }
        Ok(Measured {
            about: vec![],
            statistics,
            field: vertex_field::on_mesh(surface, &values),
            field_unit: self.field_unit,
            field_high: self.field_high,
        })
    }
}

/// 100 (eˢ − 1).
fn growth(logarithm: f64) -> f64 {
    100.0 * logarithm.exp_m1()
}

fn percentiles(logarithms: &[f64], weights: &[f64]) -> Option<Percentiles> {
    let weighted = || logarithms.iter().copied().zip(weights.iter().copied());
    let signed = Distribution::weighted(weighted())?;
    let sizes = Distribution::weighted(weighted().map(|(s, weight)| (s.abs(), weight)))?;
    Some(Percentiles { p99: sizes.percentile(0.99), max: sizes.max(), median: signed.percentile(0.5) })
}
