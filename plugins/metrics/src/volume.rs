//! Change of the volume.

use mimesh_core::{
    Figures, Result,
    mesh::Surface,
    register,
    stage::{BoundMetric, Measured, Metric, MetricContext, MetricInput, Statistic},
};
use nalgebra::{Point3, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{component_pairs, distribution::first_largest};

register!(Metric: Volume);

/// Change of the volume, beyond that of the source.
///
/// The volume of a component is Σ (a − g) · (b − a) × (c − a) / 6 over its triangles abc, with g the mean of their corners. It is
/// positive if triangles face outwards. For an open component it is the volume between the component and g, which bending changes
/// too. Components with less than 1e-3 A^1.5 at rest are sheets and left out; A is their area, and a sphere has 0.094 A^1.5.
///
/// V is the sum of the other volumes in the pose, V₀ at rest. Ratios V / V₀ below 0.001 count as 0.001 in logarithms.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Volume {}

/// The smallest volume of a solid, relative to A^1.5 of its area A; components with less are sheets.
const MIN_SOLID: f64 = 1e-3;
/// The smallest ratio that has a logarithm.
const MIN_RATIO: f64 = 1e-3;

#[typetag::serde(name = "volume")]
impl Metric for Volume {
    fn bind<'a>(&self, context: MetricContext<'a>) -> Result<Box<dyn BoundMetric + 'a>> {
        let source = context.pair.map(|pair| Solids::new(pair.source));
        Ok(Box::new(Bound { context, target: Solids::new(context.surface), source }))
    }

    fn statistics(&self) -> Vec<Statistic> {
        vec![
            Statistic::new("beyond", "%", "How much more the volume changes than that of the source: 100 (e^|d| − 1), d the difference of their ln(V / V₀).")
                .with_title("change of volume beyond the source's").with_limits(15.0, 80.0),
            Statistic::new("change", "%", "100 (V / V₀ − 1), with its sign; −200 for a mesh turned inside out."),
            Statistic::new("source_change", "%", "The same as `change`, of the source."),
            Statistic::new(
                "worst_component",
                "%",
                "Change of the component with the largest |ln(V / V₀)|, among those of at least a tenth of the mean volume.",
            ),
            Statistic::index("worst", "The component of `worst_component`, numbered by first vertex."),
            Statistic::new("components", "count", "Components that are measured."),
            Statistic::new("open", "count", "Measured components with a boundary."),
        ]
    }

    fn fault(&self) -> &'static str {
        "the target swells or shrinks where the source does not"
    }

    fn by_default(&self) -> bool {
        true
    }
}

struct Bound<'a> {
    context: MetricContext<'a>,
    target: Solids<'a>,
    source: Option<Solids<'a>>,
}

impl BoundMetric for Bound<'_> {
    fn measure(&self, input: MetricInput<'_>) -> Result<Measured> {
        self.context.check(&input)?;
        let volumes = self.target.volumes(input.result.surface);
        let Some(ratio) = self.target.ratio(&volumes) else { return Ok(Measured::default()) };
        let mut statistics = Figures::default();
        let source = self.source.as_ref().zip(input.source);
        let source = source.and_then(|(solids, posed)| solids.ratio(&solids.volumes(posed)));
        if let Some(source) = source {
            let difference = (logarithm(ratio) - logarithm(source)).abs();
            statistics.set("beyond", 100.0 * difference.exp_m1());
        }
        statistics.set("change", 100.0 * (ratio - 1.0));
        if let Some(source) = source {
            statistics.set("source_change", 100.0 * (source - 1.0));
        }
        let mut about = Vec::new();
        if let Some((worst, ratio)) = self.target.worst(&volumes) {
            statistics.set("worst_component", 100.0 * (ratio - 1.0));
            statistics.set("worst", worst);
            about.push(("worst_component", component_pairs::describe(self.context.surface, worst)));
        }
        statistics.set("components", self.target.is_solid.iter().filter(|is_solid| **is_solid).count());
        statistics.set("open", self.target.open);
        Ok(Measured { statistics, about, ..Measured::default() })
    }
}

/// The components of a surface and their volumes at rest.
struct Solids<'a> {
    surface: &'a Surface,
    /// The component of each triangle.
    component: Vec<u32>,
    count: usize,
    /// The volume of each component at rest.
    rest: Vec<f64>,
    /// Whether each component is no sheet.
    is_solid: Vec<bool>,
    /// The number of solids with a boundary.
    open: usize,
}

impl<'a> Solids<'a> {
    fn new(surface: &'a Surface) -> Self {
        let components = surface.components();
        let of = |v: u32| components.of_vertex[v as usize].unwrap_or(0);
        let component: Vec<u32> = surface.triangles.iter().map(|t| of(t[0])).collect();
        let count = components.count();
        let mut solids = Self { surface, component, count, rest: vec![], is_solid: vec![], open: 0 };
        solids.rest = solids.volumes(&surface.positions);
        let mut areas = vec![0.0; count];
        for (c, n) in solids.component.iter().zip(surface.area_normals(&surface.positions)) {
            areas[*c as usize] += n.norm() / 2.0;
        }
        solids.is_solid =
            solids.rest.iter().zip(&areas).map(|(volume, area)| volume.abs() > MIN_SOLID * area.powf(1.5)).collect();
        let mut has_boundary = vec![false; count];
        surface.topology().boundary.iter().for_each(|[v, _]| has_boundary[of(*v) as usize] = true);
        solids.open = solids.is_solid.iter().zip(&has_boundary).filter(|(solid, open)| **solid && **open).count();
        solids
    }

    /// The volume of each component at `posed`.
    fn volumes(&self, posed: &[Point3<f64>]) -> Vec<f64> {
        let mut sums = vec![Sums::default(); self.count];
        for (t, &c) in self.surface.triangles.iter().zip(&self.component) {
            sums[c as usize].add(t.map(|v| posed[v as usize]));
        }
        sums.iter().map(Sums::volume).collect()
    }

    /// V / V₀; `None` if there is no solid, or the ratio is not finite.
    fn ratio(&self, volumes: &[f64]) -> Option<f64> {
        let sum = |volumes: &[f64]| -> f64 {
            volumes.iter().zip(&self.is_solid).filter(|(_, is_solid)| **is_solid).map(|(volume, _)| volume).sum()
        };
        let rest = sum(&self.rest);
        let solids = self.rest.iter().zip(&self.is_solid).filter(|(_, is_solid)| **is_solid);
        let largest = solids.map(|(volume, _)| volume.abs()).fold(0.0, f64::max);
        let ratio = sum(volumes) / rest;
        // Components that face inwards and outwards may cancel out.
        (rest.abs() > 1e-3 * largest && ratio.is_finite()).then_some(ratio)
    }

    /// The large component whose volume changes most, and its V / V₀.
    fn worst(&self, volumes: &[f64]) -> Option<(usize, f64)> {
        let solids = || (0..self.count).filter(|&c| self.is_solid[c]);
        let mean = solids().map(|c| self.rest[c].abs()).sum::<f64>() / solids().count().max(1) as f64;
        let is_large = |c: usize| self.is_solid[c] && self.rest[c].abs() >= 0.1 * mean;
        let ratio = |c: usize| volumes[c] / self.rest[c];
        let change = |c: usize| if is_large(c) { logarithm(ratio(c)).abs() } else { f64::NAN };
        let worst = first_largest(&(0..self.count).map(change).collect::<Vec<_>>())?;
        ratio(worst).is_finite().then(|| (worst, ratio(worst)))
    }
}

/// Sums over the triangles abc of a component, taken from its first corner so that nothing cancels out far from the origin.
#[derive(Clone, Default)]
struct Sums {
    first: Option<Point3<f64>>,
    triangles: f64,
    /// Σ a + b + c.
    corners: Vector3<f64>,
    /// Σ n, with n = (b − a) × (c − a).
    normals: Vector3<f64>,
    /// Σ a · n.
    products: f64,
}

impl Sums {
    fn add(&mut self, corners: [Point3<f64>; 3]) {
        let first = *self.first.get_or_insert(corners[0]);
        let [a, b, c] = corners.map(|corner| corner - first);
        let normal = (b - a).cross(&(c - a));
        self.triangles += 1.0;
        self.corners += a + b + c;
        self.normals += normal;
        self.products += a.dot(&normal);
    }

    /// Σ (a − g) · n / 6, with g the mean of the corners. Any point would do for closed components.
    fn volume(&self) -> f64 {
        let mean = self.corners / (3.0 * self.triangles);
        if self.triangles > 0.0 { (self.products - mean.dot(&self.normals)) / 6.0 } else { 0.0 }
    }
}

/// ln of `ratio`, which counts as at least [`MIN_RATIO`]; NaN stays NaN.
fn logarithm(ratio: f64) -> f64 {
    // f64::max would make a number of NaN.
    if ratio.is_nan() { ratio } else { ratio.max(MIN_RATIO).ln() }
}

#[cfg(test)]
mod tests {
    use mimesh_core::testkit::meshes;

    use super::*;
    use crate::testing::{alone, assert_statistic, moved, scaled, with_source};

    #[test]
    fn twice_as_large_has_eight_times_the_volume_and_half_the_source_is_a_factor_of_two() {
        let sphere = meshes::icosphere(2);
        let statistics = with_source(&Volume {}, &sphere, &scaled(&sphere.positions, 2.0), &sphere.positions);
        // Sums over 320 triangles round some hundred times.
        assert_statistic(&statistics, "change", 700.0, 1e-9);
        assert_statistic(&statistics, "beyond", 700.0, 1e-9);
        assert_statistic(&statistics, "worst_component", 700.0, 1e-9);
        assert_statistic(&statistics, "open", 0.0, 0.0);
        let statistics = with_source(&Volume {}, &sphere, &sphere.positions, &scaled(&sphere.positions, 2f64.cbrt()));
        assert_statistic(&statistics, "beyond", 100.0, 1e-9);
    }

    #[test]
    fn inside_out_is_minus_two_hundred_percent() {
        let sphere = meshes::icosphere(2);
        let statistics = with_source(&Volume {}, &sphere, &scaled(&sphere.positions, -1.0), &sphere.positions);
        assert_statistic(&statistics, "change", -200.0, 1e-9);
        // ln 0.001 against ln 1.
        assert_statistic(&statistics, "beyond", 99_900.0, 1e-6);
    }

    #[test]
    fn far_components_do_not_disturb_each_other_and_the_worst_is_named() {
        let spheres = meshes::two_components();
        let half = spheres.vertex_count() / 2;
        let mut posed = moved(&spheres.positions, Vector3::new(100.0, 50.0, 0.0));
        let centre = Point3::new(103.0, 50.0, 0.0);
        posed[half..].iter_mut().for_each(|p| *p = centre + (*p - centre) * 0.5);
        let statistics = alone(&Volume {}, &spheres, &posed).statistics;
        // Positions of size 100 cost two digits.
        assert_statistic(&statistics, "worst_component", -87.5, 1e-7);
        assert_statistic(&statistics, "worst", 1.0, 0.0);
        assert_statistic(&statistics, "change", -43.75, 1e-7);
    }

    #[test]
    fn sheets_have_no_volume_and_open_solids_say_so() {
        let grid = meshes::grid(4, 4);
        assert!(alone(&Volume {}, &grid, &grid.positions).statistics.values.is_empty());
        let sphere = meshes::icosphere(2);
        let open = Surface::from_triangles(sphere.positions.clone(), sphere.triangles[1..].to_vec()).unwrap();
        let statistics = alone(&Volume {}, &open, &scaled(&open.positions, 2.0)).statistics;
        assert_statistic(&statistics, "change", 700.0, 1e-9);
        assert_statistic(&statistics, "open", 1.0, 0.0);
    }
}
