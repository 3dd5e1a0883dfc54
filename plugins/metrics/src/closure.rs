//! Lips and eyelids that do not close, or do not open.

use mimesh_core::{
    Error, Figures, Result,
    mesh::{Surface, bounding_box},
    register,
    stage::{BoundMetric, Measured, Metric, MetricContext, MetricInput, Statistic},
};
use nalgebra::Point3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::distribution::{Distribution, first_largest};

register!(Metric: Closure);

/// Lips and eyelids that do not close or open as far as those of the source.
///
/// Each of the `pairs` has a gap: the mean over its upper vertices of the distance to the nearest lower vertex. It is g in the pose
/// and g₀ at rest. The diagonal of the bounding box of all vertices of the pair at rest is w. The opening of the pair is o = (g −
/// g₀) / max(g₀, w / 10). An open eye that closes has −1. A mouth that is closed at rest opens in proportion to its width. The
/// error of a pair is 100 |o − o of the source| percent.
///
/// There are no statistics without pairs or without a source.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Closure {
    /// The pairs of rims: lips, eyelids, jaws.
    pub pairs: Vec<Rims>,
}

/// Two rims that meet where they close. Vertices count from 0 as in the files.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Rims {
    /// The name of the pair in messages.
    pub name: String,
    /// Vertices of the target's upper rim.
    pub upper: Vec<u32>,
    /// Vertices of the target's lower rim.
    pub lower: Vec<u32>,
    /// Vertices of the source's upper rim.
    pub source_upper: Vec<u32>,
    /// Vertices of the source's lower rim.
    pub source_lower: Vec<u32>,
}

#[typetag::serde(name = "closure")]
impl Metric for Closure {
    fn bind<'a>(&self, context: MetricContext<'a>) -> Result<Box<dyn BoundMetric + 'a>> {
        let mut gaps = Vec::new();
        for rims in &self.pairs {
            let target = [("target upper", &rims.upper), ("target lower", &rims.lower)];
            let target = Gap::new(&rims.name, target, context.surface)?;
            let Some(pair) = context.pair else { continue };
            let source = [("source upper", &rims.source_upper), ("source lower", &rims.source_lower)];
            gaps.push((target, Gap::new(&rims.name, source, pair.source)?));
        }
        let names = self.pairs.iter().map(|pair| pair.name.clone()).collect();
        Ok(Box::new(Bound { context, gaps, names }))
    }

    fn statistics(&self) -> Vec<Statistic> {
        vec![
            Statistic::new("worst_gap_error", "%", "Largest error of a pair.")
                .with_title("gap of a pair that should close as the source's")
                .with_limits(25.0, 75.0),
            Statistic::new("mean_gap_error", "%", "Mean error over the pairs."),
            Statistic::index("worst", "Pair with the largest error, by its place in the list."),
            Statistic::new("worst_gap", "%", "Gap of the worst pair, relative to w."),
            Statistic::new("source_worst_gap", "%", "The same as `worst_gap`, of the source."),
        ]
    }

    fn fault(&self) -> &'static str {
        "lips or eyelids do not close as far as those of the source: give markers along both rims"
    }
}

struct Bound<'a> {
    context: MetricContext<'a>,
    /// The gap of each pair on the target and on the source; empty if no source is known.
    gaps: Vec<(Gap, Gap)>,
    /// The names of the pairs.
    names: Vec<String>,
}

impl BoundMetric for Bound<'_> {
    fn measure(&self, input: MetricInput<'_>) -> Result<Measured> {
        self.context.check(&input)?;
        let Some(source) = input.source else { return Ok(Measured::default()) };
        let posed = input.result.surface;
        let error = |(target, of_source): &(Gap, Gap)| {
            100.0 * (target.opening(target.size(posed)) - of_source.opening(of_source.size(source))).abs()
        };
        let errors: Vec<f64> = self.gaps.iter().map(error).collect();
        let Some(worst) = first_largest(&errors) else { return Ok(Measured::default()) };
        let Some(finite) = Distribution::unweighted(errors.iter().copied()) else { return Ok(Measured::default()) };
        let mut statistics = Figures::default();
        statistics.set("worst_gap_error", errors[worst]);
        statistics.set("mean_gap_error", finite.mean());
        statistics.set("worst", worst);
        let (target, of_source) = &self.gaps[worst];
        statistics.set("worst_gap", 100.0 * target.size(posed) / target.width);
        statistics.set("source_worst_gap", 100.0 * of_source.size(source) / of_source.width);
        let about = self.names.get(worst).map(|name| ("worst_gap_error", name.clone())).into_iter().collect();
        Ok(Measured { statistics, about, ..Measured::default() })
    }
}

/// Two rims of one surface.
struct Gap {
    upper: Vec<u32>,
    lower: Vec<u32>,
    /// Its size at rest, g₀.
    rest: f64,
    /// The diagonal of the bounding box of both rims at rest, w.
    width: f64,
}

impl Gap {
    fn new(name: &str, rims: [(&str, &Vec<u32>); 2], surface: &Surface) -> Result<Self> {
        let [upper, lower] = rims.map(|(rim, vertices)| on_surface(name, rim, vertices, surface));
        let mut gap = Self { upper: upper?, lower: lower?, rest: 0.0, width: 0.0 };
        let all: Vec<Point3<f64>> =
            gap.upper.iter().chain(&gap.lower).map(|&v| surface.positions[v as usize]).collect();
        let (low, high) = bounding_box(&all);
        gap.width = (high - low).norm();
        if gap.width <= 0.0 {
            return Err(Error::data(
                format!("closure pair {name}: all vertices lie at one point at rest"),
                "give vertices along both rims",
            ));
        }
        gap.rest = gap.size(&surface.positions);
        Ok(gap)
    }

    /// The mean distance from the upper rim to the lower one, g; NaN if a vertex is not finite.
    fn size(&self, positions: &[Point3<f64>]) -> f64 {
        let nearest = |&u: &u32| {
            let distance = |&l: &u32| (positions[u as usize] - positions[l as usize]).norm();
            // NaN is kept, so that a broken pose has no statistic instead of a wrong one.
            self.lower.iter().map(distance).fold(f64::INFINITY, |a, b| if b.is_nan() || b < a { b } else { a })
        };
        self.upper.iter().map(nearest).sum::<f64>() / self.upper.len() as f64
    }

    /// (g − g₀) / max(g₀, w / 10).
    fn opening(&self, size: f64) -> f64 {
        (size - self.rest) / self.rest.max(0.1 * self.width)
    }
}

/// The vertices of the surface for `vertices` of the file.
///
/// # Errors
///
/// [`Error::Data`] if there are none, or one of them does not exist.
fn on_surface(name: &str, rim: &str, vertices: &[u32], surface: &Surface) -> Result<Vec<u32>> {
    if vertices.is_empty() {
        let key = rim.replace("target ", "").replace(' ', "_");
        return Err(Error::data(
            format!("closure pair {name}: no vertices of the {rim} rim"),
            format!("name some along the rim: `{key}: [12, 13, 14]`"),
        ));
    }
    let count = surface.vertex_of.len();
    let vertex = |&v: &u32| {
        surface.vertex_of.get(v as usize).copied().flatten().ok_or_else(|| {
            let message = if (v as usize) < count {
                format!("closure pair {name}: vertex {v} of the {rim} rim belongs to no polygon")
            } else {
                format!("closure pair {name}: the {rim} rim has no vertex {v}: expected 0 to {}", count - 1)
            };
            Error::data(message, "vertices count from 0, as in the file; were source and target swapped?")
        })
    };
    vertices.iter().map(vertex).collect()
}

#[cfg(test)]
mod tests {
    use mimesh_core::{mesh::Mesh, stage::TransferPair, testkit::meshes};

    use super::*;
    use crate::testing::{assert_statistic, with_source};

    /// A strip whose rows y = 0.25 and y = 0.5 are the lower and upper rim.
    fn strip() -> (Surface, Closure) {
        let row = |j: u32| (j * 5..j * 5 + 5).collect::<Vec<u32>>();
        let rims =
            Rims { name: "lips".into(), upper: row(2), lower: row(1), source_upper: row(2), source_lower: row(1) };
        (meshes::grid(4, 4), Closure { pairs: vec![rims] })
    }

    /// The strip with its upper rim at `y`.
    fn opened(strip: &Surface, y: f64) -> Vec<Point3<f64>> {
        let mut posed = strip.positions.clone();
        posed[10..15].iter_mut().for_each(|p| p.y = y);
        posed
    }

    #[test]
    fn a_target_that_stays_half_open_where_the_source_closes_is_off_by_a_half() {
        let (strip, closure) = strip();
        let (closed, half) = (opened(&strip, 0.25), opened(&strip, 0.375));
        let statistics = with_source(&closure, &strip, &half, &closed);
        assert_statistic(&statistics, "worst_gap_error", 50.0, 1e-10);
        assert_statistic(&statistics, "worst", 0.0, 0.0);
        // A gap of 1/8 on a rectangle of 1 × 1/4.
        assert_statistic(&statistics, "worst_gap", 12.5 / 1.0625f64.sqrt(), 1e-10);
        assert_statistic(&statistics, "source_worst_gap", 0.0, 1e-10);
        assert_statistic(&with_source(&closure, &strip, &closed, &closed), "worst_gap_error", 0.0, 1e-10);
    }

    #[test]
    fn no_pairs_have_no_statistics_and_vertices_that_do_not_exist_are_named() {
        let (strip, mut closure) = strip();
        assert!(with_source(&Closure::default(), &strip, &strip.positions, &strip.positions).values.is_empty());
        let mesh = Mesh::from_triangles(strip.positions.clone(), &strip.triangles);
        let pair = TransferPair { source: &strip, target: &strip, markers: &[], proximity: None };
        let context = MetricContext { pair: Some(pair), ..MetricContext::alone(&mesh, &strip) };
        closure.pairs[0].source_lower = vec![3, 25];
        let error = closure.bind(context).err().unwrap();
        assert_eq!(error.to_string(), "closure pair lips: the source lower rim has no vertex 25: expected 0 to 24");
        closure.pairs[0].upper = vec![];
        let error = closure.bind(context).err().unwrap();
        assert_eq!(error.to_string(), "closure pair lips: no vertices of the target upper rim");
        assert_eq!(error.hint(), Some("name some along the rim: `upper: [12, 13, 14]`"));
    }
}
