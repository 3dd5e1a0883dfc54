//! Components that drift apart, or run into each other.

use std::collections::BTreeMap;

use mimesh_core::{
    Figures, Result,
    mesh::Surface,
    register,
    stage::{BoundMetric, Limit, Measured, Metric, MetricContext, MetricInput},
};
use nalgebra::Point3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{
    linked, size,
    spread::{Spread, first_largest},
};

register!(Metric: ComponentGaps);

/// Components that lie together at rest and drift apart in a pose.
///
/// Pairs of vertices are of each component those closest to its six nearest others within 2 % of the diagonal, at most eight for
/// each. (Those of a pipeline's `proximity` may be far apart, and then open and close with any motion.) With d their distance in the pose and d₀ at rest, a pair is
/// opened by max(0, d − d₀), in percent of the diagonal. Figures:
/// - `mean`, `p99`, `max` of that over all pairs;
/// - `source_p99`: the same of the source's components, in percent of its own diagonal, 0 if it has one component; and
///   `beyond` = max(0, `p99` − `source_p99`): a tongue leaves the palate on both;
/// - `worst_component`: the largest over the components of the median over a component's pairs, which shows a single loose one
///   among many, and `worst`, its number by first vertex, from 0;
/// - `closed`: pairs that have come closer than half of d₀, in percent of those with d₀ above 0.1 % of the diagonal;
/// - `pairs`: their number.
///
/// A single component, or components with nothing near, have no figures. The field is the largest opening of a vertex's pairs.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct ComponentGaps {}

/// How far apart components are neighbours, relative to the diagonal.
const REACH: f64 = 0.02;
/// Closer pairs have nothing to close, relative to the diagonal.
const APART: f64 = 1e-3;

#[typetag::serde(name = "component_gaps")]
impl Metric for ComponentGaps {
    fn bind<'a>(&self, subject: MetricContext<'a>) -> Result<Box<dyn BoundMetric + 'a>> {
        let diagonal = size::of_rest(subject.rest)?;
        let surface = subject.surface;
        let of_vertex = surface.components().of_vertex;
        let target = Gaps::near(surface, diagonal)?;
        let source = subject.pair.map(|pair| Gaps::near(pair.source, size::of_source(pair.source)?)).transpose()?;
        Ok(Box::new(Bound { subject, target, source, of_vertex }))
    }

    fn figures(&self) -> Vec<&'static str> {
        vec!["p99", "beyond", "mean", "max", "source_p99", "worst_component", "worst", "closed", "pairs"]
    }

    fn limits(&self) -> Vec<Limit> {
        vec![
            Limit { figure: "beyond", doubtful: 2.0, bad: 5.0 },
            Limit { figure: "worst_component", doubtful: 3.0, bad: 6.0 },
        ]
    }

    fn by_default(&self) -> bool {
        true
    }
}

struct Bound<'a> {
    subject: MetricContext<'a>,
    target: Gaps,
    source: Option<Gaps>,
    /// The component of each vertex.
    of_vertex: Vec<Option<u32>>,
}

impl BoundMetric for Bound<'_> {
    fn measure(&self, pose: MetricInput<'_>) -> Result<Measured> {
        self.subject.check(&pose)?;
        let surface = self.subject.surface;
        let posed = surface.from_mesh(pose.result)?;
        let mut values = vec![f64::NAN; surface.vertex_count()];
        let mut of_component: BTreeMap<u32, Vec<f64>> = BTreeMap::new();
        let (mut closed, mut parted) = (0usize, 0usize);
        for (pair, rest, distance) in self.target.distances(&posed) {
            let by = self.target.opened(rest, distance);
            size::raise(&mut values, &pair, by);
            for component in pair.iter().filter_map(|&v| self.of_vertex[v as usize]) {
                of_component.entry(component).or_default().push(by);
            }
            if rest > APART * self.target.diagonal {
                parted += 1;
                closed += usize::from(distance < 0.5 * rest);
            }
        }
        let Some(opened) = self.target.spread(&posed) else { return Ok(Measured::default()) };
        let mut figures = Figures::default();
        let p99 = opened.percentile(0.99);
        figures.set("p99", p99);
        if let Some((source, posed)) = self.source.as_ref().zip(pose.source) {
            let source_p99 = source.spread(posed).map_or(0.0, |opened| opened.percentile(0.99));
            figures.set("beyond", (p99 - source_p99).max(0.0));
            figures.set("source_p99", source_p99);
        }
        figures.set("mean", opened.mean());
        figures.set("max", opened.max());
        let (numbers, medians): (Vec<u32>, Vec<f64>) = of_component
            .into_iter()
            .filter_map(|(component, opened)| Some((component, Spread::even(opened)?.percentile(0.5))))
            .unzip();
        let mut about = Vec::new();
        if let Some(worst) = first_largest(&medians) {
            figures.set("worst_component", medians[worst]);
            figures.set("worst", numbers[worst]);
            about.push(("worst_component", linked::component(surface, numbers[worst] as usize)));
        }
        figures.set("closed", 100.0 * closed as f64 / parted.max(1) as f64);
        figures.set("pairs", opened.count());
        let field = size::field(surface, &values);
        Ok(Measured { figures, about, field, field_unit: "opened, %", field_high: 6.0 })
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

    /// Those of components that lie near each other.
    fn near(surface: &Surface, diagonal: f64) -> Result<Self> {
        Ok(Self::new(surface, diagonal, linked::pairs(surface, REACH * diagonal)?))
    }

    /// Each pair with its distances at rest and at `posed`, as far as that is finite.
    fn distances(&self, posed: &[Point3<f64>]) -> impl Iterator<Item = ([u32; 2], f64, f64)> {
        let distance = |[a, b]: [u32; 2]| (posed[a as usize] - posed[b as usize]).norm();
        let all = self.pairs.iter().zip(&self.rest).map(move |(pair, rest)| (*pair, *rest, distance(*pair)));
        all.filter(|(_, _, distance)| distance.is_finite())
    }

    /// In percent of the diagonal.
    fn opened(&self, rest: f64, distance: f64) -> f64 {
        100.0 * (distance - rest).max(0.0) / self.diagonal
    }

    fn spread(&self, posed: &[Point3<f64>]) -> Option<Spread> {
        Spread::even(self.distances(posed).map(|(_, rest, distance)| self.opened(rest, distance)))
    }
}

#[cfg(test)]
mod tests {
    use mimesh_core::testkit::meshes;

    use super::*;
    use crate::testing::{alone, assert_figure, moved, with_source};

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
        let figures = with_source(&ComponentGaps {}, &spheres, &posed, &spheres.positions);
        // The pair lies along x, up to the few other pairs within reach.
        assert_figure(&figures, "max", 10.0, 0.2);
        assert_figure(&figures, "beyond", figures.number("p99").unwrap(), 0.0);
        assert_figure(&with_source(&ComponentGaps {}, &spheres, &posed, &posed), "beyond", 0.0, 0.0);
        posed[half..].iter_mut().for_each(|p| p.x -= by + 0.015);
        let figures = alone(&ComponentGaps {}, &spheres, &posed).figures;
        assert_figure(&figures, "max", 0.0, 0.0);
        assert!(figures.number("closed").unwrap() > 0.0, "they come closer than half");
    }

    #[test]
    fn what_moves_as_one_opens_nothing_and_one_component_has_no_gaps() {
        let spheres = near_spheres();
        let figures =
            alone(&ComponentGaps {}, &spheres, &moved(&spheres.positions, nalgebra::Vector3::new(5.0, 1.0, 0.0)))
                .figures;
        // Rounding of positions of size 5.
        assert_figure(&figures, "max", 0.0, 1e-12);
        let sphere = meshes::icosphere(1);
        assert!(alone(&ComponentGaps {}, &sphere, &sphere.positions).figures.values.is_empty());
        let far = meshes::two_components();
        assert!(alone(&ComponentGaps {}, &far, &far.positions).figures.values.is_empty(), "nothing is near");
    }
}
