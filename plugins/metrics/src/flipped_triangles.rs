//! Triangles that are folded over.

use mimesh_core::{
    Figures, Result, register,
    stage::{BoundMetric, Measured, Metric, MetricContext, MetricInput, Statistic},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{flips::Rest, vertex_field};

register!(Metric: FlippedTriangles);

/// Triangles that are folded over against their neighbours.
///
/// The rotation R of a triangle's neighbourhood is the one nearest to Σ e′eᵀ + 2√(A′A) n′nᵀ. The sum runs over the edges e, unit
/// normals n and areas A at rest, and e′, n′ and A′ in the pose. It takes all triangles that share a vertex with this one, itself
/// included, each once for every vertex that they share. The triangle is flipped if its normal points backwards from where R takes
/// it: n′ · R n < 0.
///
/// So limbs may turn as far as they like. A mesh that is mirrored as a whole has no flipped triangles either; `volume` sees it.
/// Triangles without a normal at rest or in the pose are not flipped. The field is 100 at vertices of flipped triangles, else 0.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct FlippedTriangles {}

#[typetag::serde(name = "flipped_triangles")]
impl Metric for FlippedTriangles {
    fn bind<'a>(&self, context: MetricContext<'a>) -> Result<Box<dyn BoundMetric + 'a>> {
        let source = context.pair.map(|pair| Rest::new(pair.source));
        Ok(Box::new(Bound { context, target: Rest::new(context.surface), source }))
    }

    fn statistics(&self) -> Vec<Statistic> {
        vec![
            Statistic::new("count", "count", "Flipped triangles."),
            Statistic::new("share", "%", "Area at rest of flipped triangles, relative to the whole area."),
            Statistic::new("beyond_share", "%", "How much `share` exceeds `source_share`; 0 if it does not.")
                .with_title("flipped area beyond the source's")
                .with_limits(0.5, 100.0),
            Statistic::new("source_count", "count", "The same as `count`, of the source."),
            Statistic::new("source_share", "%", "The same as `share`, of the source."),
            Statistic::new(
                "degenerate",
                "count",
                "Triangles that lost their area: height below 1e-6 of the longest edge, above 1e-4 at rest.",
            )
            .with_title("triangles that lost their area")
            .with_limits(0.0, 1000.0),
        ]
    }

    fn fault(&self) -> &'static str {
        "the surface folds over itself where that of the source does not"
    }

    fn by_default(&self) -> bool {
        true
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
        let posed = self.target.posed(input.result.surface);
        let flipped = self.target.flipped(&posed);
        let share = self.target.share(&flipped);
        let mut statistics = Figures::default();
        statistics.set("count", count(&flipped));
        statistics.set("share", share);
        if let Some((source, posed)) = self.source.as_ref().zip(input.source) {
            let flipped = source.flipped(&source.posed(posed));
            let source_share = source.share(&flipped);
            statistics.set("beyond_share", (share - source_share).max(0.0));
            statistics.set("source_count", count(&flipped));
            statistics.set("source_share", source_share);
        }
        statistics.set("degenerate", self.target.degenerate_count(&posed));
        let field = if input.wants_field { self.field(&flipped) } else { vec![] };
        Ok(Measured { statistics, about: vec![], field, field_unit: "flipped", field_high: 100.0 })
    }
}

impl Bound<'_> {
    /// 100 at the vertices of flipped triangles, 0 at others that triangles use.
    fn field(&self, flipped: &[bool]) -> Vec<f64> {
        let surface = self.context.surface;
        let mut values = vec![f64::NAN; surface.vertex_count()];
        for (corners, flipped) in surface.triangles.iter().zip(flipped) {
            vertex_field::raise(&mut values, corners, if *flipped { 100.0 } else { 0.0 });
        }
        vertex_field::on_mesh(surface, &values)
    }
}

fn count(flipped: &[bool]) -> usize {
    flipped.iter().filter(|flipped| **flipped).count()
}

#[cfg(test)]
mod tests {
    use mimesh_core::testkit::meshes;
    use nalgebra::{Point3, Rotation3, Vector3};

    use super::*;
    use crate::testing::{alone, assert_statistic, with_source};

    #[test]
    fn a_vertex_pushed_over_its_ring_flips_the_triangles_that_it_turns_over() {
        let grid = meshes::grid(8, 8);
        let mut posed = grid.positions.clone();
        // Vertex (4, 4) is moved by one and a half cells along x: of its six triangles those on the far side turn over.
        posed[40].x += 1.5 / 8.0;
        let turned = (0..grid.triangle_count()).filter(|&t| {
            let [a, b, c] = grid.corners(&posed, t);
            (b - a).cross(&(c - a)).z < 0.0
        });
        let expected = turned.count();
        assert!(expected >= 2);
        let measured = alone(&FlippedTriangles {}, &grid, &posed);
        assert_statistic(&measured.statistics, "count", expected as f64, 0.0);
        // All triangles are alike.
        assert_statistic(&measured.statistics, "share", 100.0 * expected as f64 / 128.0, 1e-12);
        assert_eq!((measured.field[40], measured.field[0]), (100.0, 0.0));
    }

    #[test]
    fn one_triangle_turned_over_in_a_bent_sheet_is_found() {
        let grid = meshes::grid(12, 12);
        let bent = |p: &Point3<f64>| Point3::new((3.0 * p.x).sin() / 3.0, p.y, (1.0 - (3.0 * p.x).cos()) / 3.0);
        let mut posed: Vec<_> = grid.positions.iter().map(bent).collect();
        assert_statistic(&alone(&FlippedTriangles {}, &grid, &posed).statistics, "count", 0.0, 0.0);
        // The corner triangle whose corner is folded inwards over its opposite edge.
        let uses = grid.triangles.iter().flatten().fold(vec![0; grid.vertex_count()], |mut n, &v| {
            n[v as usize] += 1;
            n
        });
        let lone = uses.iter().position(|n| *n == 1).unwrap();
        let t = grid.triangles.iter().position(|t| t.contains(&(lone as u32))).unwrap();
        let others: Vec<_> =
            grid.triangles[t].iter().filter(|&&v| v != lone as u32).map(|&v| posed[v as usize]).collect();
        let middle = nalgebra::center(&others[0], &others[1]);
        posed[lone] = middle + (middle - posed[lone]);
        assert_statistic(&alone(&FlippedTriangles {}, &grid, &posed).statistics, "count", 1.0, 0.0);
    }

    #[test]
    fn large_rotations_and_a_roll_flip_nothing() {
        let sphere = meshes::icosphere(3);
        let turn = Rotation3::new(Vector3::new(0.0, 3.0, 0.3));
        let turned: Vec<_> = sphere.positions.iter().map(|p| turn * p).collect();
        assert_statistic(&alone(&FlippedTriangles {}, &sphere, &turned).statistics, "count", 0.0, 0.0);
        // A sheet rolled up twice.
        let grid = meshes::grid(60, 4);
        let angle = |x: f64| 4.0 * std::f64::consts::PI * x;
        let rolled = |p: &Point3<f64>| {
            let radius = 0.1 + 0.05 * p.x;
            Point3::new(radius * angle(p.x).sin(), p.y, -radius * angle(p.x).cos())
        };
        let rolled: Vec<_> = grid.positions.iter().map(rolled).collect();
        assert_statistic(&alone(&FlippedTriangles {}, &grid, &rolled).statistics, "count", 0.0, 0.0);
    }

    #[test]
    fn triangles_that_lose_their_area_are_degenerate_and_what_the_source_flips_is_not_beyond() {
        let grid = meshes::grid(8, 8);
        let mut posed = grid.positions.clone();
        posed[40] = posed[41];
        let statistics = with_source(&FlippedTriangles {}, &grid, &posed, &grid.positions);
        // The two triangles at the edge that has lost its length.
        assert_statistic(&statistics, "degenerate", 2.0, 0.0);
        posed[40].x += 2.0 / 8.0;
        let statistics = with_source(&FlippedTriangles {}, &grid, &posed, &posed);
        assert!(statistics.number("count").unwrap() > 0.0);
        assert_statistic(&statistics, "beyond_share", 0.0, 0.0);
    }
}
