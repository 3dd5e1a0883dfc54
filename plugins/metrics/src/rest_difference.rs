//! Rests that stand in other poses.

use mimesh_core::{
    Figures, Result,
    mesh::Surface,
    operators::voronoi_mass,
    register,
    spatial::{Nearest, Orientation, Similarity, angle_between},
    stage::{BoundMetric, Measured, Metric, MetricContext, Statistic, TransferPair, TriangleMap},
};
use nalgebra::{Matrix3, Point3};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{at_rest::AtRest, diagonal, distribution::Distribution, vertex_field};

register!(Metric: RestDifference);

/// Rests that stand in other poses: arms stretched out on one and hanging on the other.
///
/// Poses are carried relative to the rests. Where a limb of the target rests in another direction than that of the source, it stays off
/// by as much in every pose, and no other metric sees it.
///
/// The vertices of the target within 0.1 diagonals of a place, whose source points lie within 0.15 diagonals of its own, are laid on
/// these by a rotation, and so are all vertices. The statistics are of the angle between the two rotations. Each place counts as the area
/// around its vertex.
///
/// At most 600 places and 3,000 vertices are looked at, spread evenly over the numbering. All poses have the same statistics; without a
/// map there are none. The field is the angle at the nearest place.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct RestDifference {}

/// Parts that are turned by more than this, in degrees, rest otherwise. Horse and camel differ by more in 0 to 2 % of their surface.
const TURNED: f64 = 40.0;

/// What lies this near on the target and on the source, in their diagonals, turns as one.
const AROUND: [f64; 2] = [0.1, 0.15];

/// Most places, and most vertices that are laid on their source points.
const MAX_PLACES: [usize; 2] = [600, 3_000];

#[typetag::serde(name = "rest_difference")]
impl Metric for RestDifference {
    fn bind<'a>(&self, context: MetricContext<'a>) -> Result<Box<dyn BoundMetric + 'a>> {
        match (context.pair, context.map) {
            (Some(pair), Some(map)) => difference(context, pair, map),
            _ => Ok(AtRest::boxed(context, Measured::default())),
        }
    }

    fn statistics(&self) -> Vec<Statistic> {
        vec![
            Statistic::new("share", "%", "Share of the area that is turned by more than 40° against the rest.")
                .with_title("area that rests turned against the source's")
                .with_limits(4.0, 100.0),
            Statistic::new("p50", "°", "Median angle."),
            Statistic::new("p95", "°", "95th percentile of the angle."),
            Statistic::index("worst", "Vertex of the file at the place that is turned most."),
        ]
    }

    fn fault(&self) -> &'static str {
        "limbs rest in other directions, as arms that hang and arms stretched out, and stay off by as much in every pose: let \
         one mesh rest as the other, by `rest: { file: FILE, pose: NAME }` or `rest: { file: FILE, clip: NAME, time: 0 }`"
    }

    fn needs_map(&self) -> bool {
        true
    }

    fn by_default(&self) -> bool {
        true
    }

    fn is_of_rest(&self) -> bool {
        true
    }
}

/// The statistics and the field of a map at rest.
///
/// # Errors
///
/// [`Error::Data`](mimesh_core::Error::Data) for a map that does not fit the pair, or meshes without a diagonal.
fn difference<'a>(
    context: MetricContext<'a>,
    pair: TransferPair<'_>,
    map: &TriangleMap,
) -> Result<Box<dyn BoundMetric + 'a>> {
    map.check(pair)?;
    let diagonals = [diagonal::of_target(context.surface)?, diagonal::of_source(pair.source)?];
    let places = Places::new(pair, map, diagonals)?;
    let all: Vec<usize> = (0..places.count()).collect();
    let nothing = || Ok(AtRest::boxed(context, Measured::default()));
    let Some(whole) = places.rotation(&all) else { return nothing() };
    let step = places.count().div_ceil(MAX_PLACES[0]).max(1);
    let angle = |k: usize| Some((k, angle_between(&whole, &places.rotation(&places.around(k))?)));
    let angles: Vec<(usize, f64)> = (0..places.count()).into_par_iter().step_by(step).filter_map(angle).collect();
    let weighted = angles.iter().map(|&(k, angle)| (angle, places.mass[k]));
    let Some(distribution) = Distribution::weighted(weighted) else { return nothing() };
    // Not by `sum`, which starts from -0.
    let area =
        |least: f64| angles.iter().filter(|(_, angle)| *angle > least).fold(0.0, |sum, &(k, _)| sum + places.mass[k]);
    let mut statistics = Figures::default();
    statistics.set("share", 100.0 * area(TURNED) / area(f64::NEG_INFINITY).max(f64::MIN_POSITIVE));
    statistics.set("p50", distribution.percentile(0.5));
    statistics.set("p95", distribution.percentile(0.95));
    let mut about = vec![];
    if let Some(&(worst, _)) = angles.iter().max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0))) {
        let vertex = context.surface.representative[places.vertex[worst] as usize];
        statistics.set("worst", vertex);
        about.push(("share", format!("around vertex {vertex}")));
    }
    let measured = Measured { statistics, about, field: vec![], field_unit: "turned, °", field_high: 90.0 };
    let nearest = Nearest::new(&angles.iter().map(|&(k, _)| places.target[k]).collect::<Vec<_>>())?;
    let field = move || field(context.surface, diagonals[0], &angles, &nearest);
    Ok(AtRest::with_field(context, measured, Box::new(field)))
}

/// Vertices of the target, evenly among all, with their source points, in diagonals.
struct Places {
    target: Vec<Point3<f64>>,
    source: Vec<Point3<f64>>,
    vertex: Vec<u32>,
    /// The area around each.
    mass: Vec<f64>,
}

impl Places {
    fn new(pair: TransferPair<'_>, map: &TriangleMap, [diagonal, source_diagonal]: [f64; 2]) -> Result<Self> {
        let surface = pair.target;
        let step = surface.vertex_count().div_ceil(MAX_PLACES[1]).max(1);
        let points = map.source_points(pair)?;
        let mass = voronoi_mass(&surface.positions, &surface.triangles);
        let vertex: Vec<u32> = (0..surface.vertex_count() as u32).step_by(step).collect();
        let source = |v: &u32| points[*v as usize].position(pair.source, &pair.source.positions) / source_diagonal;
        Ok(Self {
            target: vertex.iter().map(|&v| surface.positions[v as usize] / diagonal).collect(),
            source: vertex.iter().map(source).collect(),
            mass: vertex.iter().map(|&v| mass[v as usize]).collect(),
            vertex,
        })
    }

    fn count(&self) -> usize {
        self.vertex.len()
    }

    /// The places near place `k` on both sides.
    fn around(&self, k: usize) -> Vec<usize> {
        let is_near = |&j: &usize| {
            (self.target[j] - self.target[k]).norm() < AROUND[0] && (self.source[j] - self.source[k]).norm() < AROUND[1]
        };
        (0..self.count()).filter(is_near).collect()
    }

    /// The rotation that lays the source points of `places` on these; `None` if it is not determined.
    fn rotation(&self, places: &[usize]) -> Option<Matrix3<f64>> {
        let of = |points: &[Point3<f64>]| places.iter().map(|&k| points[k]).collect::<Vec<_>>();
        let weights = vec![1.0; places.len()];
        Some(Similarity::orient(&of(&self.source), &of(&self.target), &weights, Orientation::Fitted)?.rotation)
    }
}

/// The angle at the nearest place for each vertex of the target's mesh.
fn field(surface: &Surface, diagonal: f64, angles: &[(usize, f64)], nearest: &Nearest) -> Vec<f64> {
    let value = |p: &Point3<f64>| angles[nearest.find(&(p / diagonal)).0 as usize].1;
    let values: Vec<f64> = surface.positions.par_iter().map(value).collect();
    vertex_field::on_mesh(surface, &values)
}

#[cfg(test)]
mod tests {
    use mimesh_core::{mesh::Mesh, stage::MetricInput, testkit::meshes};
    use nalgebra::{Rotation3, Vector3};

    use super::*;
    use crate::testing::assert_statistic;

    /// The statistics of the identity from `source` to the same triangles at `positions`.
    fn measure(source: &Surface, positions: Vec<Point3<f64>>) -> Measured {
        let target = Surface { positions, ..source.clone() };
        let count = source.triangle_count();
        let triangles = (0..count as u32).map(Some).collect();
        let map = TriangleMap { source_triangle_count: count, triangles, ..TriangleMap::default() };
        let mesh = Mesh::from_triangles(target.positions.clone(), &target.triangles);
        let pair = TransferPair { source, target: &target, markers: &[], proximity: None };
        let context = MetricContext { pair: Some(pair), map: Some(&map), ..MetricContext::alone(&mesh, &target) };
        RestDifference {}.bind(context).unwrap().measure(MetricInput::alone(context.at_rest())).unwrap()
    }

    #[test]
    fn a_surface_that_is_turned_scaled_and_moved_as_a_whole_rests_alike() {
        let sphere = meshes::icosphere(3);
        let turn = Rotation3::from_euler_angles(0.4, 1.9, -2.5);
        let positions = sphere.positions.iter().map(|p| turn * p * 3.0 + Vector3::new(7.0, -2.0, 1.0)).collect();
        let measured = measure(&sphere, positions);
        assert_statistic(&measured.statistics, "share", 0.0, 0.0);
        // The cosine of a small angle is flat: 1e-16 of it are 1e-6 degrees.
        assert_statistic(&measured.statistics, "p95", 0.0, 1e-4);
    }

    #[test]
    fn the_part_beyond_a_bend_rests_otherwise() {
        // A long tube along x, 0 to 10, whose last 3 tenths hang.
        let grid = meshes::grid(60, 12);
        let (low, high) = mimesh_core::mesh::bounding_box(&grid.positions);
        let tube = |p: &Point3<f64>| {
            let along = 10.0 * (p.x - low.x) / (high.x - low.x);
            let around = std::f64::consts::TAU * (p.y - low.y) / (high.y - low.y);
            Point3::new(along, 0.4 * around.cos(), 0.4 * around.sin())
        };
        let source = Surface { positions: grid.positions.iter().map(tube).collect(), ..grid };
        let joint = Point3::new(7.0, 0.0, 0.0);
        let hang = Rotation3::from_euler_angles(0.0, 0.0, -1.2);
        let bent = |p: &Point3<f64>| if p.x > joint.x { joint + hang * (p - joint) } else { *p };
        let measured = measure(&source, source.positions.iter().map(bent).collect());
        // Three tenths of the area are turned by 69° against the rest; by some degrees less against the rotation of all. Around the
        // joint, a fifth of the tube, the angle grows.
        let share = measured.statistics.number("share").unwrap();
        assert!((20.0..40.0).contains(&share), "{share}");
        let worst = measured.statistics.number("worst").unwrap() as usize;
        assert!(source.positions[worst].x > joint.x && measured.field[worst] > 45.0, "{:?}", measured.statistics);
    }
}
