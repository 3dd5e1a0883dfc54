//! How the volume changes.

use mimesh_core::{
    Figures, Result,
    mesh::Surface,
    register,
    stage::{BoundMetric, Limit, Measured, Metric, MetricContext, MetricInput},
};
use nalgebra::{Point3, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{linked, spread::first_largest};

register!(Metric: Volume);

/// How the volume changes, beyond what the source's does.
///
/// The volume of a component is Σ (a − g) · (b − a) × (c − a) / 6 over its triangles abc, g the mean of their corners: positive
/// where triangles face outwards. For an open component that is the volume between it and g, which bending changes too. Components
/// of less than 1e-3 A^1.5 at rest, A their area, are sheets without a volume and left out; a sphere has 0.094 A^1.5. V is the sum of
/// the others in the pose, V₀ at rest. Figures:
/// - `change` = 100 (V / V₀ − 1), with its sign; −200 for what is turned inside out;
/// - `source_change`: the same of the source;
/// - `beyond` = 100 (e^|d| − 1), d = ln(V / V₀) − ln(V / V₀ of the source); ratios below 0.001 count as that;
/// - `worst_component`: the change of the component that changes most, by the size of its ln(V / V₀), among those of at least a
///   tenth of the mean volume, and `worst`, its number by first vertex, from 0;
/// - `components`: those measured; `open`: those of them that have a boundary.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Volume {}

/// Components of less volume than this times A^1.5 are sheets.
const SHEET: f64 = 1e-3;
/// The smallest ratio that has a logarithm.
const SMALLEST: f64 = 1e-3;

#[typetag::serde(name = "volume")]
impl Metric for Volume {
    fn bind<'a>(&self, subject: MetricContext<'a>) -> Result<Box<dyn BoundMetric + 'a>> {
        let source = subject.pair.map(|pair| Solids::new(pair.source));
        Ok(Box::new(Bound { subject, target: Solids::new(subject.surface), source }))
    }

    fn figures(&self) -> Vec<&'static str> {
        vec!["beyond", "change", "source_change", "worst_component", "worst", "components", "open"]
    }

    fn limits(&self) -> Vec<Limit> {
        vec![
            Limit { figure: "beyond", doubtful: 15.0, bad: 50.0 },
            Limit { figure: "change", doubtful: 30.0, bad: 80.0 },
        ]
    }

    fn by_default(&self) -> bool {
        true
    }
}

struct Bound<'a> {
    subject: MetricContext<'a>,
    target: Solids<'a>,
    source: Option<Solids<'a>>,
}

impl BoundMetric for Bound<'_> {
    fn measure(&self, pose: MetricInput<'_>) -> Result<Measured> {
        self.subject.check(&pose)?;
        let posed = self.subject.surface.from_mesh(pose.result)?;
        let volumes = self.target.volumes(&posed);
        let Some(ratio) = self.target.ratio(&volumes) else { return Ok(Measured::default()) };
        let mut figures = Figures::default();
        let source = self.source.as_ref().zip(pose.source);
        let source = source.and_then(|(solids, posed)| solids.ratio(&solids.volumes(posed)));
        if let Some(source) = source {
            let apart = (logarithm(ratio) - logarithm(source)).abs();
            figures.set("beyond", 100.0 * apart.exp_m1());
        }
        figures.set("change", 100.0 * (ratio - 1.0));
        if let Some(source) = source {
            figures.set("source_change", 100.0 * (source - 1.0));
        }
        let mut about = Vec::new();
        if let Some((worst, ratio)) = self.target.worst(&volumes) {
            figures.set("worst_component", 100.0 * (ratio - 1.0));
            figures.set("worst", worst);
            about.push(("worst_component", linked::component(self.subject.surface, worst)));
        }
        figures.set("components", self.target.solid.iter().filter(|solid| **solid).count());
        figures.set("open", self.target.open);
        Ok(Measured { figures, about, ..Measured::default() })
    }
}

/// The components of a surface.
struct Solids<'a> {
    surface: &'a Surface,
    /// Of each triangle.
    component: Vec<u32>,
    count: usize,
    /// Of each component at rest.
    rest: Vec<f64>,
    /// Whether it has a volume to speak of.
    solid: Vec<bool>,
    /// Solids with a boundary.
    open: usize,
}

impl<'a> Solids<'a> {
    fn new(surface: &'a Surface) -> Self {
        let components = surface.components();
        let of = |v: u32| components.of_vertex[v as usize].unwrap_or(0);
        let component: Vec<u32> = surface.triangles.iter().map(|t| of(t[0])).collect();
        let count = components.count();
        let mut solids = Self { surface, component, count, rest: vec![], solid: vec![], open: 0 };
        solids.rest = solids.volumes(&surface.positions);
        let mut areas = vec![0.0; count];
        for (c, n) in solids.component.iter().zip(surface.area_normals(&surface.positions)) {
            areas[*c as usize] += n.norm() / 2.0;
        }
        solids.solid =
            solids.rest.iter().zip(&areas).map(|(volume, area)| volume.abs() > SHEET * area.powf(1.5)).collect();
        let mut has_boundary = vec![false; count];
        surface.topology().boundary.iter().for_each(|[v, _]| has_boundary[of(*v) as usize] = true);
        solids.open = solids.solid.iter().zip(&has_boundary).filter(|(solid, open)| **solid && **open).count();
        solids
    }

    /// The volume of each component at `posed`.
    fn volumes(&self, posed: &[Point3<f64>]) -> Vec<f64> {
        let mut centres = vec![(Vector3::zeros(), 0.0); self.count];
        for (t, &c) in self.surface.triangles.iter().zip(&self.component) {
            // Any point would do for closed components.
            let (sum, number) = &mut centres[c as usize];
            t.iter().for_each(|&v| *sum += posed[v as usize].coords);
            *number += 3.0;
        }
        let mut volumes = vec![0.0; self.count];
        for ((t, n), &c) in self.surface.triangles.iter().zip(self.surface.area_normals(posed)).zip(&self.component) {
            let (sum, number) = &centres[c as usize];
            volumes[c as usize] += (posed[t[0] as usize].coords - sum / *number).dot(&n) / 6.0;
        }
        volumes
    }

    /// V / V₀; `None` if there is no solid, or it is not finite.
    fn ratio(&self, volumes: &[f64]) -> Option<f64> {
        let sum = |volumes: &[f64]| -> f64 {
            volumes.iter().zip(&self.solid).filter(|(_, solid)| **solid).map(|(volume, _)| volume).sum()
        };
        let rest = sum(&self.rest);
        let solids = self.rest.iter().zip(&self.solid).filter(|(_, solid)| **solid);
        let largest = solids.map(|(volume, _)| volume.abs()).fold(0.0, f64::max);
        let ratio = sum(volumes) / rest;
        // Components that face inwards and outwards may leave nothing.
        (rest.abs() > 1e-3 * largest && ratio.is_finite()).then_some(ratio)
    }

    /// The component that changes most, and its V / V₀.
    fn worst(&self, volumes: &[f64]) -> Option<(usize, f64)> {
        let solids = || (0..self.count).filter(|&c| self.solid[c]);
        let mean = solids().map(|c| self.rest[c].abs()).sum::<f64>() / solids().count().max(1) as f64;
        let is_large = |c: usize| self.solid[c] && self.rest[c].abs() >= 0.1 * mean;
        let ratio = |c: usize| volumes[c] / self.rest[c];
        let change = |c: usize| if is_large(c) { logarithm(ratio(c)).abs() } else { f64::NAN };
        let worst = first_largest(&(0..self.count).map(change).collect::<Vec<_>>())?;
        ratio(worst).is_finite().then(|| (worst, ratio(worst)))
    }
}

fn logarithm(ratio: f64) -> f64 {
    // f64::max would make a number of NaN.
    if ratio.is_nan() { ratio } else { ratio.max(SMALLEST).ln() }
}

#[cfg(test)]
mod tests {
    use mimesh_core::testkit::meshes;

    use super::*;
    use crate::testing::{alone, assert_figure, moved, scaled, with_source};

    #[test]
    fn twice_as_large_has_eight_times_the_volume_and_half_the_source_is_a_factor_of_two() {
        let sphere = meshes::icosphere(2);
        let figures = with_source(&Volume {}, &sphere, &scaled(&sphere.positions, 2.0), &sphere.positions);
        // Sums over 320 triangles round some hundred times.
        assert_figure(&figures, "change", 700.0, 1e-9);
        assert_figure(&figures, "beyond", 700.0, 1e-9);
        assert_figure(&figures, "worst_component", 700.0, 1e-9);
        assert_figure(&figures, "open", 0.0, 0.0);
        let figures = with_source(&Volume {}, &sphere, &sphere.positions, &scaled(&sphere.positions, 2f64.cbrt()));
        assert_figure(&figures, "beyond", 100.0, 1e-9);
    }

    #[test]
    fn inside_out_is_minus_two_hundred_percent() {
        let sphere = meshes::icosphere(2);
        let figures = with_source(&Volume {}, &sphere, &scaled(&sphere.positions, -1.0), &sphere.positions);
        assert_figure(&figures, "change", -200.0, 1e-9);
        // ln 0.001 against ln 1.
        assert_figure(&figures, "beyond", 99_900.0, 1e-6);
    }

    #[test]
    fn far_components_do_not_disturb_each_other_and_the_worst_is_named() {
        let spheres = meshes::two_components();
        let half = spheres.vertex_count() / 2;
        let mut posed = moved(&spheres.positions, Vector3::new(100.0, 50.0, 0.0));
        let centre = Point3::new(103.0, 50.0, 0.0);
        posed[half..].iter_mut().for_each(|p| *p = centre + (*p - centre) * 0.5);
        let figures = alone(&Volume {}, &spheres, &posed).figures;
        // Positions of size 100 cost two digits.
        assert_figure(&figures, "worst_component", -87.5, 1e-7);
        assert_figure(&figures, "worst", 1.0, 0.0);
        assert_figure(&figures, "change", -43.75, 1e-7);
    }

    #[test]
    fn sheets_have_no_volume_and_open_solids_say_so() {
        let grid = meshes::grid(4, 4);
        assert!(alone(&Volume {}, &grid, &grid.positions).figures.values.is_empty());
        let sphere = meshes::icosphere(2);
        let open = Surface::from_triangles(sphere.positions.clone(), sphere.triangles[1..].to_vec()).unwrap();
        let figures = alone(&Volume {}, &open, &scaled(&open.positions, 2.0)).figures;
        assert_figure(&figures, "change", 700.0, 1e-9);
        assert_figure(&figures, "open", 1.0, 0.0);
    }
}
