//! How much edges or triangles grow and shrink: what `edge_stretch` and `area_change` have in common.

use mimesh_core::{
    Figures, Result,
    stage::{BoundMetric, Measured, MetricContext, MetricInput},
};

use crate::{elements::Elements, size, spread::Spread};

/// The figures of both metrics.
pub const FIGURES: [&str; 8] =
    ["beyond", "p99", "max", "median", "source_p99", "source_max", "source_median", "left_out"];

/// Elements of the target, and those of the source if it is known.
pub struct Change<'a, const N: usize> {
    pub subject: MetricContext<'a>,
    pub target: Elements<N>,
    pub source: Option<Elements<N>>,
    pub field_unit: &'static str,
    /// From where on it is as bad as can be.
    pub field_high: f64,
}

/// Percentiles of one surface in one pose, in percent.
struct Percent {
    p99: f64,
    max: f64,
    median: f64,
}

impl<const N: usize> BoundMetric for Change<'_, N> {
    fn measure(&self, pose: MetricInput<'_>) -> Result<Measured> {
        self.subject.check(&pose)?;
        let surface = self.subject.surface;
        let logarithms = self.target.logarithms(&surface.from_mesh(pose.result)?);
        let Some(target) = percent(&logarithms, &self.target.rest) else { return Ok(Measured::default()) };
        let source = self.source.as_ref().zip(pose.source);
        let source = source.and_then(|(elements, posed)| percent(&elements.logarithms(posed), &elements.rest));

        let mut figures = Figures::default();
        if let Some(source) = &source {
            figures.set("beyond", (target.p99 - source.p99).max(0.0));
        }
        figures.set("p99", target.p99);
        figures.set("max", target.max);
        figures.set("median", target.median);
        if let Some(source) = &source {
            figures.set("source_p99", source.p99);
            figures.set("source_max", source.max);
            figures.set("source_median", source.median);
        }
        let unfit = logarithms.iter().filter(|s| !s.is_finite()).count();
        figures.set("left_out", self.target.left_out + unfit);

        let ordinary = source.map_or(0.0, |source| source.p99);
        let mut values = vec![f64::NAN; surface.vertex_count()];
        for (corners, s) in self.target.corners.iter().zip(&logarithms).filter(|(_, s)| s.is_finite()) {
            size::raise(&mut values, corners, (growth(s.abs()) - ordinary).max(0.0));
        }
        Ok(Measured {
            about: vec![],
            figures,
            field: size::field(surface, &values),
            field_unit: self.field_unit,
            field_high: self.field_high,
        })
    }
}

/// 100 (eˢ − 1).
fn growth(logarithm: f64) -> f64 {
    100.0 * logarithm.exp_m1()
}

fn percent(logarithms: &[f64], weights: &[f64]) -> Option<Percent> {
    let weighted = || logarithms.iter().copied().zip(weights.iter().copied());
    let signed = Spread::new(weighted())?;
    let sizes = Spread::new(weighted().map(|(s, weight)| (s.abs(), weight)))?;
    Some(Percent {
        p99: growth(sizes.percentile(0.99)),
        max: growth(sizes.max()),
        median: growth(signed.percentile(0.5)),
    })
}
