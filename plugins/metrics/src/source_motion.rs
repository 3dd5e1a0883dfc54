//! Parts that do not move as the source does.

use mimesh_core::{
    Figures, Result,
    mesh::{Surface, SurfacePoint},
    register,
    spatial::{Orientation, Similarity},
    stage::{BoundMetric, Measured, Metric, MetricContext, MetricInput, Statistic, TransferPair, TriangleMap},
};
use nalgebra::{Point3, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{diagonal, distribution::Distribution, elements, source_pose::SourcePoses, vertex_field};

register!(Metric: SourceMotion);

/// Parts that do not move as the source does: limbs that stay, eyelids that do not close, targets that remain at rest.
///
/// A vertex x of the target takes its motion from a point u of the source, x̃ and ũ in the pose. The source's motion there is e = s R
/// (Q ũ / κ − u), and that of the target d = R Q Rᵀ x̃ / κ − x. The similarity of s and R takes the points u to x with least squares.
/// The rotation Q takes the source's pose to its rest, and κ is its median stretch of edges: turns and scales of the whole are no
/// motion. Each vertex is off by r = ‖(d − d̄) − (e − ē)‖ in percent of
/// the diagonal, with d̄ and ē the means over vertices.
///
/// The difference has two causes: faults, and shapes that differ. The second is about in proportion to the motion and to how far the
/// shapes differ at rest. So `still_excess` allows for it, and is measured only where the source hardly moves.
///
/// A vertex stands out by ‖d − mean of d over its neighbours‖. Sharp places such as the corners of a mouth do on the source too. So a
/// spike is what a vertex stands out beyond twice that of the source at its point, for edges of the same length. It is a fault in a
/// small motion, and a joint in a large one.
///
/// Without a map the markers stand for the vertices. There are no statistics without a source, with fewer than four markers, or where
/// the known result is given, since `point_error` then says more. The field is r at each vertex.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct SourceMotion {}

/// The smallest number of points that say how a mesh moves.
const MIN_POINTS: usize = 4;
/// What shapes may differ by in their motion, relative to the product of misfit and reach, both in percent.
const ALLOWED: f64 = 0.025;
/// Poses in which the source moves less than this in the mean hardly move, in percent.
const STILL: f64 = 5.5;

#[typetag::serde(name = "source_motion")]
impl Metric for SourceMotion {
    fn bind<'a>(&self, context: MetricContext<'a>) -> Result<Box<dyn BoundMetric + 'a>> {
        let diagonal = diagonal::of_target(context.surface)?;
        let moving = context.pair.map(|pair| Moving::new(pair, context.map, diagonal)).transpose()?;
        Ok(Box::new(Bound { context, diagonal, moving }))
    }

    fn statistics(&self) -> Vec<Statistic> {
        vec![
            Statistic::new("p999", "%", "How far nearly the worst point is from the motion of the source: the 99.9th percentile of r.").with_title("distance of the worst points from the source's motion").with_limits(12.0, 60.0),
            Statistic::new("mean", "%", "Mean of r.").with_title("mean distance from the source's motion").with_limits(4.5, 10.0),
            Statistic::new("max", "%", "Largest r."),
            Statistic::new("lag", "%", "`p999` relative to the source's largest motion: about 100 if a part does not move at all; 100 `p999` / (`reach` + 1).")
                .with_title("lag behind the source's motion").with_limits(40.0, 300.0),
            Statistic::new(
                "still_excess",
                "%",
                "How far the worst point is off the source's motion, beyond 0.025 `misfit` `reach` that shapes explain; missing if `source_mean` is above 5.5 %.",
            )
            .with_title("motion where the source hardly moves").with_limits(0.9, 50.0),
            Statistic::new("spike", "%", "Largest spike of a vertex, divided by 1 + (`reach` / 10 %)².")
                .with_title("vertices that stick out").with_limits(0.36, 5.0),
            Statistic::new("reach", "%", "Largest motion of a point of the source, ‖e − ē‖."),
            Statistic::new("source_mean", "%", "Mean motion of the points of the source."),
            Statistic::new("misfit", "%", "Root mean square distance of the shapes at rest, after the similarity."),
        ]
    }

    fn fault(&self) -> &'static str {
        "parts stay behind, or move where those of the source rest: look at the colours of the pose, and give a marker there"
    }

    fn by_default(&self) -> bool {
        true
    }
}

struct Bound<'a> {
    context: MetricContext<'a>,
    diagonal: f64,
    moving: Option<Moving<'a>>,
}

/// Points of the target with the points of the source that they move like.
struct Moving<'a> {
    points: Vec<(SurfacePoint, SurfacePoint)>,
    /// Where these are at rest.
    rest: Vec<(Point3<f64>, Point3<f64>)>,
    /// Takes the source to the target at rest.
    similarity: Similarity,
    misfit: f64,
    poses: SourcePoses<'a>,
    /// The edges of the target.
    edges: Vec<[u32; 2]>,
    /// Mean length of the target's edges over that of the source's, relative to diagonals; at least 1.
    longer: f64,
}

impl<'a> Moving<'a> {
    fn new(pair: TransferPair<'a>, map: Option<&TriangleMap>, diagonal: f64) -> Result<Self> {
        let points = match map {
            Some(map) => mapped(pair, map)?,
            None => pair.markers.iter().map(|marker| (marker.target, marker.source)).collect(),
        };
        let places = |surface: &Surface, at: fn(&(SurfacePoint, SurfacePoint)) -> SurfacePoint| -> Vec<Point3<f64>> {
            points.iter().map(|pair| at(pair).position(surface, &surface.positions)).collect()
        };
        let (target, source) = (places(pair.target, |pair| pair.0), places(pair.source, |pair| pair.1));
        let similarity = Similarity::fit(&source, &target, &vec![1.0; points.len()], Orientation::Auto);
        let misfits = source.iter().zip(&target).map(|(u, x)| 100.0 * (similarity.apply(u) - x).norm() / diagonal);
        let misfit = Distribution::unweighted(misfits).map_or(0.0, |misfits| misfits.rms());
        let (poses, edges) = (SourcePoses::new(pair.source), elements::edges(pair.target));
        let longer = (edges.mean_rest() / diagonal) / (poses.edges.mean_rest() / poses.diagonal);
        let rest = target.into_iter().zip(source).collect();
        Ok(Self { points, rest, similarity, misfit, poses, edges: edges.corners, longer: longer.max(1.0) })
    }
}

impl Moving<'_> {
    /// The largest spike, given how far the vertices of target and source stand out, in percent.
    fn spike(&self, pair: TransferPair<'_>, (target, source): &(Vec<f64>, Vec<f64>)) -> f64 {
        let spike = |(of_target, of_source): &(SurfacePoint, SurfacePoint)| {
            let SurfacePoint::Vertex(v) = of_target else { return 0.0 };
            let corners = of_source.corners(pair.source).into_iter().map(|(u, _)| source[u as usize]);
            target[*v as usize] - 2.0 * self.longer * corners.fold(0.0, f64::max)
        };
        self.points.iter().map(spike).filter(|spike| spike.is_finite()).fold(0.0, f64::max)
    }
}

/// How far the motion of each vertex lies from the mean of its neighbours'.
fn standing_out(
    posed: &[Point3<f64>],
    rest: &[Point3<f64>],
    edges: &[[u32; 2]],
    motion: impl Fn(&Point3<f64>, &Point3<f64>) -> Vector3<f64>,
) -> Vec<f64> {
    let motions: Vec<Vector3<f64>> = posed.iter().zip(rest).map(|(p, q)| motion(p, q)).collect();
    let mut around = vec![(Vector3::zeros(), 0.0); rest.len()];
    for &[a, b] in edges {
        for (v, other) in [(a, b), (b, a)] {
            let (sum, count) = &mut around[v as usize];
            *sum += motions[other as usize];
            *count += 1.0;
        }
    }
    let distance = |(motion, (sum, count)): (&Vector3<f64>, &(Vector3<f64>, f64))| {
        if *count > 0.0 { (motion - sum / *count).norm() } else { 0.0 }
    };
    motions.iter().zip(&around).map(distance).collect()
}

/// Vertices of the target that the map knows a point of the source for, or a partner of a triangle around them.
fn mapped(pair: TransferPair<'_>, map: &TriangleMap) -> Result<Vec<(SurfacePoint, SurfacePoint)>> {
    let points = map.source_points(pair)?;
    let mut is_known: Vec<bool> = map.points.iter().map(Option::is_some).collect();
    is_known.resize(pair.target.vertex_count(), false);
    let partnered = pair.target.triangles.iter().zip(&map.triangles).filter(|(_, partner)| partner.is_some());
    partnered.flat_map(|(corners, _)| corners).for_each(|&v| is_known[v as usize] = true);
    let vertices = (0..).map(SurfacePoint::Vertex).zip(points).zip(is_known);
    Ok(vertices.filter(|(_, is_known)| *is_known).map(|(pair, _)| pair).collect())
}

impl BoundMetric for Bound<'_> {
    fn measure(&self, input: MetricInput<'_>) -> Result<Measured> {
        self.context.check(&input)?;
        if input.ground_truth.is_some() {
            return Ok(Measured::default());
        }
        let (Some(pair), Some(moving), Some(source)) = (self.context.pair, &self.moving, input.source) else {
            return Ok(Measured::default());
        };
        let percent = 100.0 / self.diagonal;
        let frame = moving.poses.frame(source);
        let turn = moving.similarity.rotation;
        // Rest and pose in the unit and the axes of the target at rest, without the turn and the scale of the whole.
        let of_source = |p: &Point3<f64>, q: &Point3<f64>| {
            turn * (frame.back * p.coords / frame.scale - q.coords) * (moving.similarity.scale * percent)
        };
        let back = turn * frame.back * turn.transpose();
        let of_target = |p: &Point3<f64>, q: &Point3<f64>| (back * p.coords / frame.scale - q.coords) * percent;
        let both = moving.points.iter().zip(&moving.rest).map(|((target, point), (target_rest, source_rest))| {
            let d = of_target(&target.position(pair.target, input.result.surface), target_rest);
            (d, of_source(&point.position(pair.source, source), source_rest))
        });
        let both: Vec<_> =
            both.map(|(d, e)| (d.iter().chain(e.iter()).all(|x| x.is_finite())).then_some((d, e))).collect();
        let count = both.iter().flatten().count();
        if count < MIN_POINTS {
            return Ok(Measured::default());
        }
        let zero = (Vector3::zeros(), Vector3::zeros());
        let (d_sum, e_sum) = both.iter().flatten().fold(zero, |(d_sum, e_sum), (d, e)| (d_sum + d, e_sum + e));
        let (d_mean, e_mean) = (d_sum / count as f64, e_sum / count as f64);
        let off: Vec<f64> =
            both.iter().map(|pair| pair.map_or(f64::NAN, |(d, e)| ((d - d_mean) - (e - e_mean)).norm())).collect();
        let motions = both.iter().flatten().map(|(_, e)| (e - e_mean).norm());
        let (Some(r), Some(motions)) =
            (Distribution::unweighted(off.iter().copied()), Distribution::unweighted(motions))
        else {
            return Ok(Measured::default());
        };
        let (p999, reach) = (r.percentile(0.999), motions.max());
        let mut statistics = Figures::default();
        statistics.set("p999", p999);
        statistics.set("mean", r.mean());
        statistics.set("max", r.max());
        statistics.set("lag", 100.0 * p999 / (reach + 1.0));
        if motions.mean() < STILL {
            statistics.set("still_excess", (r.max() - ALLOWED * moving.misfit * reach).max(0.0));
        }
        let stands_out = (
            standing_out(input.result.surface, &pair.target.positions, &moving.edges, of_target),
            standing_out(source, &pair.source.positions, &moving.poses.edges.corners, of_source),
        );
        statistics.set("spike", moving.spike(pair, &stands_out) / (1.0 + (reach / 10.0).powi(2)));
        statistics.set("reach", reach);
        statistics.set("source_mean", motions.mean());
        statistics.set("misfit", moving.misfit);
        let field = if input.wants_field { self.field(moving, &off) } else { vec![] };
        Ok(Measured { statistics, about: vec![], field, field_unit: "off the source, %", field_high: 15.0 })
    }
}

impl Bound<'_> {
    /// `off`, of the points of `moving`, at the vertices of the target's mesh.
    fn field(&self, moving: &Moving<'_>, off: &[f64]) -> Vec<f64> {
        let mut values = vec![f64::NAN; self.context.surface.vertex_count()];
        for ((point, _), off) in moving.points.iter().zip(off) {
            if let SurfacePoint::Vertex(v) = point {
                values[*v as usize] = *off;
            }
        }
        vertex_field::on_mesh(self.context.surface, &values)
    }
}

#[cfg(test)]
mod tests {
    use mimesh_core::{mesh::Mesh, stage::Marker, testkit::meshes};

    use super::*;
    use crate::testing::assert_statistic;

    /// A capsule at `result` where the source, the same capsule, is at `source`.
    fn measure(result: &[Point3<f64>], source: &[Point3<f64>], has_map: bool) -> Figures {
        let capsule = meshes::capsule(12, 6, 3.0);
        let count = capsule.triangle_count();
        let map = TriangleMap {
            source_triangle_count: count,
            triangles: (0..count as u32).map(Some).collect(),
            ..TriangleMap::default()
        };
        let mesh = Mesh::from_triangles(capsule.positions.clone(), &capsule.triangles);
        let marker = |v: u32| {
            let point = SurfacePoint::Vertex(v);
            Marker { name: v.to_string(), source: point, target: point }
        };
        let markers: Vec<_> = (0..capsule.vertex_count() as u32).step_by(5).map(marker).collect();
        let pair = TransferPair { source: &capsule, target: &capsule, markers: &markers, proximity: None };
        let map = has_map.then_some(&map);
        let context = MetricContext { pair: Some(pair), map, ..MetricContext::alone(&mesh, &capsule) };
        let posed = mimesh_core::stage::Posed::without_seams(result);
        let input = MetricInput { source: Some(source), ..MetricInput::alone(posed) };
        SourceMotion {}.bind(context).unwrap().measure(input).unwrap().statistics
    }

    fn bent() -> Vec<Point3<f64>> {
        let rest = meshes::capsule(12, 6, 3.0).positions;
        rest.iter().map(|p| Point3::new(p.x + 0.1 * p.y * p.y, p.y, p.z)).collect()
    }

    #[test]
    fn the_same_motion_is_not_off_and_a_target_at_rest_lacks_all_of_it() {
        let capsule = meshes::capsule(12, 6, 3.0);
        let rest = &capsule.positions;
        // Half of it moves, so that most edges keep their length and the scale is 1.
        let middle = rest.iter().map(|p| p.y).sum::<f64>() / rest.len() as f64;
        let half = |p: &Point3<f64>| if p.y > middle { p + Vector3::x() * 0.3 } else { *p };
        let parted: Vec<_> = rest.iter().map(half).collect();
        for (has_map, step) in [(true, 1), (false, 5)] {
            // Some roundings of percents.
            assert_statistic(&measure(&parted, &parted, has_map), "max", 0.0, 1e-10);
            let motion: Vec<_> = parted.iter().zip(rest).step_by(step).map(|(p, q)| p - q).collect();
            let mean = motion.iter().sum::<Vector3<f64>>() / motion.len() as f64;
            let largest = motion.iter().map(|d| (d - mean).norm()).fold(0.0, f64::max);
            let statistics = measure(rest, &parted, has_map);
            assert_statistic(&statistics, "max", 100.0 * largest / capsule.diagonal(), 1e-9);
            assert_statistic(&statistics, "misfit", 0.0, 1e-10);
        }
    }

    #[test]
    fn a_pose_that_the_source_scales_evenly_too_is_not_off() {
        let large: Vec<_> = bent().iter().map(|p| p * 10.0).collect();
        // The median stretch of a bent capsule is 1 to a hundredth, and the capsule reaches 50 %.
        assert_statistic(&measure(&large, &large, true), "max", 0.0, 1e-9);
        assert!(measure(&large, &bent(), true).number("mean").unwrap() > 100.0);
    }
}
