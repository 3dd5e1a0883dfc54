//! Triangles that are folded over.

use mimesh_core::{
    Figures, Result,
    mesh::Surface,
    operators::{polar, relative_height},
    register,
    stage::{BoundMetric, Limit, Measured, Metric, MetricContext, MetricInput},
};
use nalgebra::{Matrix3, Point3, Vector3};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::size;

register!(Metric: FlippedTriangles);

/// Triangles that are folded over against what lies around them.
///
/// The rotation R of a triangle's surroundings is the one that takes the edges e and unit normals n of all triangles that share a
/// vertex with it (itself included) from rest to the pose best: the rotation nearest to Σ e′eᵀ + 2√(A′A) n′nᵀ, A their areas. The
/// triangle is flipped if its normal points backwards from where R takes it: n′ · R n < 0. However far a limb turns, its
/// triangles are not flipped; and neither is a mesh that is mirrored as a whole, which `volume` sees. Figures:
/// - `count`: flipped triangles; `share`: their area at rest, in percent of all;
/// - `source_count`, `source_share`: the same of the source;
/// - `beyond_share` = max(0, `share` − `source_share`);
/// - `degenerate`: triangles that have lost their area: a height below 1e-6 of the longest edge, above 1e-4 at rest.
///
/// Triangles without a normal at rest or in the pose are not flipped. The field is 100 at vertices of flipped triangles, else 0.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct FlippedTriangles {}

#[typetag::serde(name = "flipped_triangles")]
impl Metric for FlippedTriangles {
    fn bind<'a>(&self, subject: MetricContext<'a>) -> Result<Box<dyn BoundMetric + 'a>> {
        let source = subject.pair.map(|pair| Rest::new(pair.source));
        Ok(Box::new(Bound { subject, target: Rest::new(subject.surface), source }))
    }

    fn figures(&self) -> Vec<&'static str> {
        vec!["count", "share", "beyond_share", "source_count", "source_share", "degenerate"]
    }

    fn limits(&self) -> Vec<Limit> {
        vec![
            Limit { figure: "beyond_share", doubtful: 0.5, bad: 2.0 },
            Limit { figure: "degenerate", doubtful: 0.0, bad: 100.0 },
        ]
    }

    fn by_default(&self) -> bool {
        true
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
        let posed = surface.from_mesh(pose.result)?;
        let flipped = self.target.flipped(&posed);
        let share = self.target.share(&flipped);
        let mut figures = Figures::default();
        figures.set("count", count(&flipped));
        figures.set("share", share);
        if let Some((source, posed)) = self.source.as_ref().zip(pose.source) {
            let flipped = source.flipped(posed);
            let source_share = source.share(&flipped);
            figures.set("beyond_share", (share - source_share).max(0.0));
            figures.set("source_count", count(&flipped));
            figures.set("source_share", source_share);
        }
        figures.set("degenerate", self.target.degenerate(&posed));
        let mut values = vec![f64::NAN; surface.vertex_count()];
        for (corners, flipped) in surface.triangles.iter().zip(&flipped) {
            size::raise(&mut values, corners, if *flipped { 100.0 } else { 0.0 });
        }
        Ok(Measured {
            figures,
            about: vec![],
            field: size::field(surface, &values),
            field_unit: "flipped",
            field_high: 100.0,
        })
    }
}

/// A surface at rest.
struct Rest<'a> {
    surface: &'a Surface,
    /// Unit normal of each triangle and twice its area; `None` without area.
    normals: Vec<Option<(Vector3<f64>, f64)>>,
    around: Vec<Vec<u32>>,
    area: f64,
}

impl<'a> Rest<'a> {
    fn new(surface: &'a Surface) -> Self {
        let normals = normals(surface, &surface.positions);
        let area = normals.iter().flatten().map(|(_, area)| area).sum();
        Self { surface, normals, around: surface.triangles_around(), area }
    }

    /// Whether each triangle is.
    fn flipped(&self, posed: &[Point3<f64>]) -> Vec<bool> {
        let surface = self.surface;
        let now = normals(surface, posed);
        let term = |t: usize| {
            let (Some((n, area)), Some((m, now))) = (self.normals[t], now[t]) else { return Matrix3::zeros() };
            let [rest, there] = [surface.corners(&surface.positions, t), surface.corners(posed, t)];
            let edge = |i: usize, j: usize| (there[j] - there[i]) * (rest[j] - rest[i]).transpose();
            edge(0, 1) + edge(1, 2) + edge(2, 0) + m * n.transpose() * (area * now).sqrt()
        };
        let terms: Vec<Matrix3<f64>> =
            (0..surface.triangle_count()).into_par_iter().with_min_len(1024).map(term).collect();
        let around = |triangles: &Vec<u32>| triangles.iter().map(|&t| terms[t as usize]).sum();
        let rings: Vec<Matrix3<f64>> = self.around.par_iter().with_min_len(1024).map(around).collect();
        let flipped = |t: usize| {
            let (Some((n, _)), Some((m, _))) = (self.normals[t], now[t]) else { return false };
            let ring: Matrix3<f64> = surface.triangles[t].iter().map(|&v| rings[v as usize]).sum();
            m.dot(&(polar(&ring).rotation * n)) < 0.0
        };
        (0..surface.triangle_count()).into_par_iter().with_min_len(1024).map(flipped).collect()
    }

    /// The area at rest of those that are, in percent.
    fn share(&self, flipped: &[bool]) -> f64 {
        let areas = self.normals.iter().zip(flipped).filter(|(_, flipped)| **flipped);
        let sum = areas.filter_map(|(normal, _)| normal.map(|(_, area)| area)).fold(0.0, |sum, area| sum + area);
        if self.area > 0.0 { 100.0 * sum / self.area } else { 0.0 }
    }

    fn degenerate(&self, posed: &[Point3<f64>]) -> usize {
        let surface = self.surface;
        let lost = |&t: &usize| {
            relative_height(&surface.corners(posed, t)) < 1e-6
                && relative_height(&surface.corners(&surface.positions, t)) > 1e-4
        };
        (0..surface.triangle_count()).filter(lost).count()
    }
}

fn count(flipped: &[bool]) -> usize {
    flipped.iter().filter(|flipped| **flipped).count()
}

fn normals(surface: &Surface, positions: &[Point3<f64>]) -> Vec<Option<(Vector3<f64>, f64)>> {
    let normal = |n: &Vector3<f64>| {
        let area = n.norm();
        (area.is_finite() && area > 0.0).then(|| (n / area, area))
    };
    surface.area_normals(positions).iter().map(normal).collect()
}

#[cfg(test)]
mod tests {
    use mimesh_core::testkit::meshes;
    use nalgebra::{Rotation3, Vector3};

    use super::*;
    use crate::testing::{alone, assert_figure, with_source};

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
        assert_figure(&measured.figures, "count", expected as f64, 0.0);
        // All triangles are alike.
        assert_figure(&measured.figures, "share", 100.0 * expected as f64 / 128.0, 1e-12);
        assert_eq!((measured.field[40], measured.field[0]), (100.0, 0.0));
    }

    #[test]
    fn one_triangle_turned_over_in_a_bent_sheet_is_found() {
        let grid = meshes::grid(12, 12);
        let bent = |p: &Point3<f64>| Point3::new((3.0 * p.x).sin() / 3.0, p.y, (1.0 - (3.0 * p.x).cos()) / 3.0);
        let mut posed: Vec<_> = grid.positions.iter().map(bent).collect();
        assert_figure(&alone(&FlippedTriangles {}, &grid, &posed).figures, "count", 0.0, 0.0);
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
        assert_figure(&alone(&FlippedTriangles {}, &grid, &posed).figures, "count", 1.0, 0.0);
    }

    #[test]
    fn large_rotations_and_a_roll_flip_nothing() {
        let sphere = meshes::icosphere(3);
        let turn = Rotation3::new(Vector3::new(0.0, 3.0, 0.3));
        let turned: Vec<_> = sphere.positions.iter().map(|p| turn * p).collect();
        assert_figure(&alone(&FlippedTriangles {}, &sphere, &turned).figures, "count", 0.0, 0.0);
        // A sheet rolled up twice.
        let grid = meshes::grid(60, 4);
        let angle = |x: f64| 4.0 * std::f64::consts::PI * x;
        let rolled = |p: &Point3<f64>| {
            let radius = 0.1 + 0.05 * p.x;
            Point3::new(radius * angle(p.x).sin(), p.y, -radius * angle(p.x).cos())
        };
        let rolled: Vec<_> = grid.positions.iter().map(rolled).collect();
        assert_figure(&alone(&FlippedTriangles {}, &grid, &rolled).figures, "count", 0.0, 0.0);
    }

    #[test]
    fn triangles_that_lose_their_area_are_degenerate_and_what_the_source_flips_is_not_beyond() {
        let grid = meshes::grid(8, 8);
        let mut posed = grid.positions.clone();
        posed[40] = posed[41];
        let figures = with_source(&FlippedTriangles {}, &grid, &posed, &grid.positions);
        // The two triangles at the edge that has lost its length.
        assert_figure(&figures, "degenerate", 2.0, 0.0);
        posed[40].x += 2.0 / 8.0;
        let figures = with_source(&FlippedTriangles {}, &grid, &posed, &posed);
        assert!(figures.number("count").unwrap() > 0.0);
        assert_figure(&figures, "beyond_share", 0.0, 0.0);
    }
}
