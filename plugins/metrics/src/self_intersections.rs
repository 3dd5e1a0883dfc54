//! Parts that run into each other.

use mimesh_core::{
    Figures, Result,
    mesh::Surface,
    register,
    stage::{BoundMetric, Limit, Measured, Metric, MetricContext, MetricInput},
};
use nalgebra::Point3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{crossing::cross, size, triangle_tree::TriangleTree};

register!(Metric: SelfIntersections);

/// Parts that run into each other: triangles that cross others in the pose, and none at rest.
///
/// Two triangles of the welded surface that share no vertex cross if an edge of one passes through the other, and its ends lie
/// more than 1e-6 of the diagonal from the other's plane, on both sides: those that touch or lie in one plane do not. Figures:
/// - `share`: triangles that cross another and did not at rest, in percent of all; `pairs`: crossing pairs with such a triangle;
/// - `source_share`: the same of the source; `beyond_share` = max(0, `share` − `source_share`);
/// - `rest_share`: triangles that cross another at rest, in percent of all.
///
/// The field is 100 at vertices of triangles that count, else 0.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct SelfIntersections {}

/// What counts as touching, relative to the diagonal: single precision is a tenth of it.
const SLACK: f64 = 1e-6;

#[typetag::serde(name = "self_intersections")]
impl Metric for SelfIntersections {
    fn bind<'a>(&self, subject: MetricContext<'a>) -> Result<Box<dyn BoundMetric + 'a>> {
        let source = subject.pair.map(|pair| Rest::new(pair.source));
        Ok(Box::new(Bound { subject, target: Rest::new(subject.surface), source }))
    }

    fn figures(&self) -> Vec<&'static str> {
        vec!["share", "pairs", "beyond_share", "source_share", "rest_share"]
    }

    fn limits(&self) -> Vec<Limit> {
        vec![Limit { figure: "beyond_share", doubtful: 3.0, bad: 8.0 }]
    }
}

struct Bound<'a> {
    subject: MetricContext<'a>,
    target: Rest<'a>,
    source: Option<Rest<'a>>,
}

impl BoundMetric for Bound<'_> {
    fn measure(&self, pose: MetricInput<'_>) -> Result<Measured> {
        self.subject.check(&pose)?;
        let surface = self.subject.surface;
        let (crossing, pairs) = self.target.new_crossings(&surface.from_mesh(pose.result)?);
        let share = percent(&crossing);
        let mut figures = Figures::default();
        figures.set("share", share);
        figures.set("pairs", pairs);
        if let Some((source, posed)) = self.source.as_ref().zip(pose.source) {
            let source_share = percent(&source.new_crossings(posed).0);
            figures.set("beyond_share", (share - source_share).max(0.0));
            figures.set("source_share", source_share);
        }
        figures.set("rest_share", percent(&self.target.crossing));
        let mut values = vec![f64::NAN; surface.vertex_count()];
        for (corners, crossing) in surface.triangles.iter().zip(&crossing) {
            size::raise(&mut values, corners, if *crossing { 100.0 } else { 0.0 });
        }
        Ok(Measured {
            figures,
            about: vec![],
            field: size::field(surface, &values),
            field_unit: "crossing",
            field_high: 100.0,
        })
    }
}

/// A surface and what crosses at rest.
struct Rest<'a> {
    surface: &'a Surface,
    tree: TriangleTree,
    slack: f64,
    /// Whether each triangle crosses another.
    crossing: Vec<bool>,
}

impl<'a> Rest<'a> {
    fn new(surface: &'a Surface) -> Self {
        let tree = TriangleTree::new(&surface.positions, &surface.triangles);
        let slack = SLACK * surface.diagonal();
        let mut crossing = vec![false; surface.triangle_count()];
        for pair in crossings(surface, &tree, slack, &surface.positions) {
            pair.iter().for_each(|&t| crossing[t as usize] = true);
        }
        Self { surface, tree, slack, crossing }
    }

    /// Whether each triangle crosses another and did not at rest, and the number of pairs with such a one.
    fn new_crossings(&self, posed: &[Point3<f64>]) -> (Vec<bool>, usize) {
        let mut crossing = vec![false; self.surface.triangle_count()];
        let mut pairs = 0;
        for pair in crossings(self.surface, &self.tree, self.slack, posed) {
            let fresh = pair.map(|t| !self.crossing[t as usize]);
            pair.iter().zip(fresh).filter(|(_, fresh)| *fresh).for_each(|(&t, _)| crossing[t as usize] = true);
            pairs += usize::from(fresh[0] || fresh[1]);
        }
        (crossing, pairs)
    }
}

/// Pairs of triangles without a common vertex that cross.
fn crossings(surface: &Surface, tree: &TriangleTree, slack: f64, posed: &[Point3<f64>]) -> Vec<[u32; 2]> {
    let triangles = &surface.triangles;
    tree.pairs(posed, triangles, |a, b| {
        let (of_a, of_b) = (&triangles[a as usize], &triangles[b as usize]);
        let are_neighbours = of_a.iter().any(|v| of_b.contains(v));
        let corners = |t: u32| surface.corners(posed, t as usize);
        !are_neighbours && cross(&corners(a), &corners(b), slack)
    })
}

fn percent(crossing: &[bool]) -> f64 {
    100.0 * crossing.iter().filter(|crossing| **crossing).count() as f64 / crossing.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use mimesh_core::testkit::meshes;
    use nalgebra::Vector3;

    use super::*;
    use crate::testing::{alone, assert_figure, with_source};

    /// Two spheres, the second moved towards the first by `by`.
    fn pushed(by: f64) -> (Surface, Vec<Point3<f64>>) {
        let spheres = meshes::two_components();
        let half = spheres.vertex_count() / 2;
        let mut posed = spheres.positions.clone();
        posed[half..].iter_mut().for_each(|p| p.x -= by);
        (spheres, posed)
    }

    #[test]
    fn two_spheres_cross_where_they_are_pushed_into_each_other_and_nowhere_else() {
        let (spheres, apart) = pushed(0.5);
        let figures = alone(&SelfIntersections {}, &spheres, &apart).figures;
        assert_figure(&figures, "share", 0.0, 0.0);
        let (_, into) = pushed(2.0);
        let measured = alone(&SelfIntersections {}, &spheres, &into);
        assert!(measured.figures.number("pairs").unwrap() > 10.0);
        // They meet in the circle half way between their centres.
        for (value, p) in measured.field.iter().zip(&into) {
            assert!(*value == 0.0 || (p.x - 0.5).abs() < 0.7, "{p} is far from where the spheres meet");
        }
    }

    #[test]
    fn what_crosses_at_rest_or_in_the_source_does_not_count_as_new() {
        let (mut spheres, into) = pushed(2.0);
        let figures = with_source(&SelfIntersections {}, &spheres, &into, &into);
        assert!(figures.number("share").unwrap() > 0.0);
        assert_figure(&figures, "beyond_share", 0.0, 0.0);
        spheres.positions = into.clone();
        let further: Vec<_> = into.iter().map(|p| p + Vector3::y()).collect();
        let figures = alone(&SelfIntersections {}, &spheres, &further).figures;
        assert_figure(&figures, "share", 0.0, 0.0);
        assert!(figures.number("rest_share").unwrap() > 0.0);
    }

    #[test]
    fn a_flat_sheet_and_one_folded_flat_do_not_cross_themselves() {
        let grid = meshes::grid(10, 10);
        let folded: Vec<_> = grid.positions.iter().map(|p| Point3::new((p.x - 0.5).abs(), p.y, 0.0)).collect();
        for posed in [&grid.positions, &folded] {
            assert_figure(&alone(&SelfIntersections {}, &grid, posed).figures, "share", 0.0, 0.0);
        }
    }
}
