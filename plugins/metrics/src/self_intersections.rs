//! Parts that run into each other.

use mimesh_core::{
    Figures, Result,
    mesh::Surface,
    register,
    stage::{BoundMetric, Measured, Metric, MetricContext, MetricInput, Statistic},
};
use nalgebra::Point3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{crossing::triangles_cross, triangle_tree::TriangleTree, vertex_field};

register!(Metric: SelfIntersections);

/// Parts that run into each other: triangles that cross others in the pose but none at rest.
///
/// Two triangles of the welded surface that share no vertex cross if an edge of one passes through the other. The ends of that edge
/// must lie on both sides of the other's plane, farther from it than 1e-6 of the diagonal. So triangles that touch or lie in one
/// plane do not cross. A triangle counts if it crosses another in the pose and crossed none at rest.
///
/// The field is 100 at vertices of triangles that count, else 0.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct SelfIntersections {}

/// Triangles that cross by less only touch, relative to the diagonal; single precision is a tenth of it.
const TOLERANCE: f64 = 1e-6;

#[typetag::serde(name = "self_intersections")]
impl Metric for SelfIntersections {
    fn bind<'a>(&self, context: MetricContext<'a>) -> Result<Box<dyn BoundMetric + 'a>> {
        let source = context.pair.map(|pair| Rest::new(pair.source));
        Ok(Box::new(Bound { context, target: Rest::new(context.surface), source }))
    }

    fn statistics(&self) -> Vec<Statistic> {
        vec![
            Statistic::new("share", "%", "Share of triangles that count."),
            Statistic::new("pairs", "count", "Crossing pairs with a triangle that counts."),
            Statistic::new("beyond_share", "%", "How much `share` exceeds `source_share`; 0 if it does not.")
                .with_title("triangles that cross, beyond the source's")
                .with_limits(3.0, 100.0),
            Statistic::new("source_share", "%", "The same as `share`, of the source."),
            Statistic::new("rest_share", "%", "Share of triangles that cross another at rest."),
        ]
    }

    fn fault(&self) -> &'static str {
        "parts run into each other where those of the source do not"
    }
}

struct Bound<'a> {
    context: MetricContext<'a>,
    target: Rest<'a>,
    source: Option<Rest<'a>>,
}

impl BoundMetric for Bound<'_> {
    fn measure(&self, input: MetricInput<'_>) -> Result<Measured> {
        self.context.check(&input)?;
        let surface = self.context.surface;
        let (crossing, pairs) = self.target.new_crossings(input.result.surface);
        let share = percent(&crossing);
        let mut statistics = Figures::default();
        statistics.set("share", share);
        statistics.set("pairs", pairs);
        if let Some((source, posed)) = self.source.as_ref().zip(input.source) {
            let source_share = percent(&source.new_crossings(posed).0);
            statistics.set("beyond_share", (share - source_share).max(0.0));
            statistics.set("source_share", source_share);
        }
        statistics.set("rest_share", percent(&self.target.crossing));
        let mut values = vec![f64::NAN; surface.vertex_count()];
        for (corners, crossing) in surface.triangles.iter().zip(&crossing) {
            vertex_field::raise(&mut values, corners, if *crossing { 100.0 } else { 0.0 });
        }
        Ok(Measured {
            statistics,
            about: vec![],
            field: vertex_field::on_mesh(surface, &values),
            field_unit: "crossing",
            field_high: 100.0,
        })
    }
}

/// A surface and its crossings at rest.
struct Rest<'a> {
    surface: &'a Surface,
    tree: TriangleTree,
    /// Triangles that cross by less only touch, in the unit of the surface.
    tolerance: f64,
    /// Whether each triangle crosses another at rest.
    crossing: Vec<bool>,
}

impl<'a> Rest<'a> {
    fn new(surface: &'a Surface) -> Self {
        let tree = TriangleTree::new(&surface.positions, &surface.triangles);
        let tolerance = TOLERANCE * surface.diagonal();
        let mut crossing = vec![false; surface.triangle_count()];
        for pair in crossings(surface, &tree, tolerance, &surface.positions) {
            pair.iter().for_each(|&t| crossing[t as usize] = true);
        }
        Self { surface, tree, tolerance, crossing }
    }

    /// Whether each triangle crosses another and did not at rest, and the number of crossing pairs with such a triangle.
    fn new_crossings(&self, posed: &[Point3<f64>]) -> (Vec<bool>, usize) {
        let mut crossing = vec![false; self.surface.triangle_count()];
        let mut pairs = 0;
        for pair in crossings(self.surface, &self.tree, self.tolerance, posed) {
            let is_new = pair.map(|t| !self.crossing[t as usize]);
            pair.iter().zip(is_new).filter(|(_, is_new)| *is_new).for_each(|(&t, _)| crossing[t as usize] = true);
            pairs += usize::from(is_new[0] || is_new[1]);
        }
        (crossing, pairs)
    }
}

/// Pairs of triangles without a common vertex that cross at `posed`.
fn crossings(surface: &Surface, tree: &TriangleTree, tolerance: f64, posed: &[Point3<f64>]) -> Vec<[u32; 2]> {
    let triangles = &surface.triangles;
    tree.pairs(posed, triangles, |a, b| {
        let (of_a, of_b) = (&triangles[a as usize], &triangles[b as usize]);
        let are_neighbours = of_a.iter().any(|v| of_b.contains(v));
        let corners = |t: u32| surface.corners(posed, t as usize);
        !are_neighbours && triangles_cross(&corners(a), &corners(b), tolerance)
    })
}

/// The share of triangles that cross, in percent.
fn percent(crossing: &[bool]) -> f64 {
    100.0 * crossing.iter().filter(|crossing| **crossing).count() as f64 / crossing.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use mimesh_core::testkit::meshes;
    use nalgebra::Vector3;

    use super::*;
    use crate::testing::{alone, assert_statistic, with_source};

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
        let statistics = alone(&SelfIntersections {}, &spheres, &apart).statistics;
        assert_statistic(&statistics, "share", 0.0, 0.0);
        let (_, into) = pushed(2.0);
        let measured = alone(&SelfIntersections {}, &spheres, &into);
        assert!(measured.statistics.number("pairs").unwrap() > 10.0);
        // They meet in the circle half way between their centres.
        for (value, p) in measured.field.iter().zip(&into) {
            assert!(*value == 0.0 || (p.x - 0.5).abs() < 0.7, "{p} is far from where the spheres meet");
        }
    }

    #[test]
    fn what_crosses_at_rest_or_in_the_source_does_not_count_as_new() {
        let (mut spheres, into) = pushed(2.0);
        let statistics = with_source(&SelfIntersections {}, &spheres, &into, &into);
        assert!(statistics.number("share").unwrap() > 0.0);
        assert_statistic(&statistics, "beyond_share", 0.0, 0.0);
        spheres.positions = into.clone();
        let further: Vec<_> = into.iter().map(|p| p + Vector3::y()).collect();
        let statistics = alone(&SelfIntersections {}, &spheres, &further).statistics;
        assert_statistic(&statistics, "share", 0.0, 0.0);
        assert!(statistics.number("rest_share").unwrap() > 0.0);
    }

    #[test]
    fn a_flat_sheet_and_one_folded_flat_do_not_cross_themselves() {
        let grid = meshes::grid(10, 10);
        let folded: Vec<_> = grid.positions.iter().map(|p| Point3::new((p.x - 0.5).abs(), p.y, 0.0)).collect();
        for posed in [&grid.positions, &folded] {
            assert_statistic(&alone(&SelfIntersections {}, &grid, posed).statistics, "share", 0.0, 0.0);
        }
    }
}
