//! Places where the map takes much of the target to little of the source.

use mimesh_core::{
    Figures, Result,
    mesh::{Surface, SurfacePoint},
    register,
    spatial::Nearest,
    stage::{BoundMetric, Measured, Metric, MetricContext, Statistic, TransferPair, TriangleMap},
};
use nalgebra::Point3;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{at_rest::AtRest, diagonal, distribution::Distribution, vertex_field};

register!(Metric: MapCollapse);

/// Places where the map takes much of the target to little of the source, at rest.
///
/// A shank whose marker is on the knee has all of its motion from the knee. The map is smooth there, so nothing tears.
///
/// For a vertex v of the target at x_v, whose place on the source is q_v, the ratio to another one u is ‖q_u − q_v‖ D / (‖x_u − x_v‖ D′),
/// with the diagonals D of the target and D′ of the source. ρ_v is the 90th percentile over all u that are 0.064 to 0.096 D away. So
/// a limb may bend, and one side of it may shrink. ρ is about 1 where the map keeps sizes.
///
/// At most 1,500 vertices v and 6,000 vertices u are looked at, spread evenly over the numbering. If the map knows no points for
/// vertices, triangles with a partner and their barycentres stand in. All poses have the same statistics; without a map there are none.
/// The field is 100 (1 − ρ) of the nearest v, or 0 if that is below 0.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct MapCollapse {}

/// The smallest ρ that is no collapse.
const MIN_RATIO: f64 = 0.5;

/// Distances at which ratios are taken, in diagonals of the target.
const SHELL: [f64; 2] = [0.064, 0.096];

/// The share of ratios that ρ is not below.
const PERCENTILE: f64 = 0.9;

/// Vertices with fewer others in the shell are skipped.
const MIN_OTHERS: usize = 5;

/// Most places that ρ is measured at, and most others.
const MAX_PLACES: [usize; 2] = [1_500, 6_000];

#[typetag::serde(name = "map_collapse")]
impl Metric for MapCollapse {
    fn bind<'a>(&self, context: MetricContext<'a>) -> Result<Box<dyn BoundMetric + 'a>> {
        match (context.pair, context.map) {
            (Some(pair), Some(map)) => collapse(context, pair, map),
            _ => Ok(AtRest::boxed(context, Measured::default())),
        }
    }

    fn statistics(&self) -> Vec<Statistic> {
        vec![
            Statistic::new("share", "%", "Share of places whose surroundings take their motion from less than half of their size on the source: ρ below 0.5.").with_title("places that move by too small a patch of the source").with_limits(0.1, 1.0),
            Statistic::new("p1", "ratio", "1st percentile of ρ."),
            Statistic::new("p50", "ratio", "Median ρ."),
            Statistic::index("worst", "Vertex of the file at the place with the smallest ρ."),
        ]
    }

    fn fault(&self) -> &'static str {
        "much of the target follows one small place of the source, as a shank that follows the knee: give a marker there"
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

/// A place on the target with the place on the source that it takes its motion from, in diagonals.
#[derive(Clone, Copy)]
struct Place {
    target: Point3<f64>,
    source: Point3<f64>,
    /// The vertex there, or the first corner of the triangle.
    vertex: u32,
}

/// The statistics and the field of a map at rest.
///
/// # Errors
///
/// [`Error::Data`](mimesh_core::Error::Data) for a map that does not fit the pair, or meshes without a diagonal.
fn collapse<'a>(
    context: MetricContext<'a>,
    pair: TransferPair<'_>,
    map: &TriangleMap,
) -> Result<Box<dyn BoundMetric + 'a>> {
    map.check(pair)?;
    let diagonals = [diagonal::of_target(context.surface)?, diagonal::of_source(pair.source)?];
    let places = places(pair, map, diagonals);
    let [centres, others] = MAX_PLACES.map(|count| every_nth(&places, count));
    let ratios: Vec<Option<f64>> = centres.par_iter().map(|centre| ratio(centre, &others)).collect();
    let measured: Vec<(Place, f64)> = centres.iter().zip(ratios).filter_map(|(p, ratio)| Some((**p, ratio?))).collect();
    let Some(distribution) = Distribution::unweighted(measured.iter().map(|(_, ratio)| *ratio)) else {
        return Ok(AtRest::boxed(context, Measured::default()));
    };
    let below = measured.iter().filter(|(_, ratio)| *ratio < MIN_RATIO).count();
    let mut statistics = Figures::default();
    statistics.set("share", 100.0 * below as f64 / measured.len() as f64);
    statistics.set("p1", distribution.percentile(0.01));
    statistics.set("p50", distribution.percentile(0.5));
    let mut about = vec![];
    if let Some((worst, _)) = measured.iter().min_by(|a, b| a.1.total_cmp(&b.1)) {
        let vertex = context.surface.representative[worst.vertex as usize];
        statistics.set("worst", vertex);
        about.push(("share", format!("around vertex {vertex}")));
    }
    let measured_at_rest = Measured { statistics, about, field: vec![], field_unit: "collapse, %", field_high: 100.0 };
    let nearest = Nearest::new(&measured.iter().map(|(place, _)| place.target).collect::<Vec<_>>())?;
    let field = move || field(context.surface, diagonals[0], &measured, &nearest);
    Ok(AtRest::with_field(context, measured_at_rest, Box::new(field)))
}

/// Where vertices of the target have points on the source, or where triangles have partners.
fn places(pair: TransferPair<'_>, map: &TriangleMap, [diagonal, source_diagonal]: [f64; 2]) -> Vec<Place> {
    let place = |target: Point3<f64>, source: Point3<f64>, vertex: u32| Place {
        target: target / diagonal,
        source: source / source_diagonal,
        vertex,
    };
    if map.points.iter().any(Option::is_some) {
        let source = |point: &SurfacePoint| point.position(pair.source, &pair.source.positions);
        let known = map.points.iter().enumerate().filter_map(|(v, point)| Some((v, point.as_ref()?)));
        return known.map(|(v, point)| place(pair.target.positions[v], source(point), v as u32)).collect();
    }
    let [target, source] = [pair.target, pair.source].map(|surface| surface.barycentres(&surface.positions));
    let known = map.triangles.iter().enumerate().filter_map(|(t, partner)| Some((t, (*partner)? as usize)));
    known.map(|(t, partner)| place(target[t], source[partner], pair.target.triangles[t][0])).collect()
}

/// At most `count` places, spread evenly.
fn every_nth(places: &[Place], count: usize) -> Vec<&Place> {
    places.iter().step_by(places.len().div_ceil(count).max(1)).collect()
}

/// ρ; `None` if too few others are in the shell.
fn ratio(centre: &Place, others: &[&Place]) -> Option<f64> {
    let [near, far] = SHELL;
    let ratios = others.iter().filter_map(|other| {
        let distance = (other.target - centre.target).norm();
        (near..=far).contains(&distance).then(|| (other.source - centre.source).norm() / distance)
    });
    let ratios = Distribution::unweighted(ratios)?;
    (ratios.count() >= MIN_OTHERS).then(|| ratios.percentile(PERCENTILE))
}

/// The collapse at the nearest place for each vertex of the target's mesh.
fn field(surface: &Surface, diagonal: f64, measured: &[(Place, f64)], nearest: &Nearest) -> Vec<f64> {
    let value = |p: &Point3<f64>| 100.0 * (1.0 - measured[nearest.find(&(p / diagonal)).0 as usize].1).max(0.0);
    let values: Vec<f64> = surface.positions.par_iter().map(value).collect();
    vertex_field::on_mesh(surface, &values)
}

#[cfg(test)]
mod tests {
    use mimesh_core::{mesh::Mesh, stage::MetricInput, testkit::meshes};

    use super::*;
    use crate::testing::assert_statistic;

    fn measure(source: &Surface, target: &Surface, map: &TriangleMap) -> Measured {
        let mesh = Mesh::from_triangles(target.positions.clone(), &target.triangles);
        let pair = TransferPair { source, target, markers: &[], proximity: None };
        let context = MetricContext { pair: Some(pair), map: Some(map), ..MetricContext::alone(&mesh, target) };
        MapCollapse {}.bind(context).unwrap().measure(MetricInput::alone(context.at_rest())).unwrap()
    }

    /// The map of a surface to itself that takes vertex `v` to vertex `to(v)`.
    fn map(surface: &Surface, to: impl Fn(u32) -> u32) -> TriangleMap {
        let count = surface.triangle_count();
        TriangleMap {
            source_triangle_count: count,
            triangles: (0..count as u32).map(Some).collect(),
            points: (0..surface.vertex_count() as u32).map(|v| Some(SurfacePoint::Vertex(to(v)))).collect(),
            ..TriangleMap::default()
        }
    }

    #[test]
    fn a_map_that_keeps_sizes_has_a_ratio_of_one_in_any_unit() {
        let mut target = meshes::grid(30, 30);
        let source = target.clone();
        target.positions.iter_mut().for_each(|p| *p *= 25.0);
        let measured = measure(&source, &target, &map(&source, |v| v));
        for (statistic, expected) in [("share", 0.0), ("p1", 1.0), ("p50", 1.0)] {
            // Differences of coordinates, 1e-16 of them, over a fifteenth of the diagonal.
            assert_statistic(&measured.statistics, statistic, expected, 1e-13);
        }
        let triangles = TriangleMap { points: vec![], ..map(&source, |v| v) };
        assert_statistic(&measure(&source, &target, &triangles).statistics, "p1", 1.0, 1e-13);
    }

    #[test]
    fn a_strip_that_maps_to_its_rim_has_collapsed_and_one_that_halves_its_width_has_not() {
        let grid = meshes::grid(40, 40);
        // The last 12 of 40 columns all go to the one before them: the strip keeps its length along y but no width, so its middle,
        // which is as wide as the shell, keeps only what lies along it.
        let column = |v: u32, to: &dyn Fn(u32) -> u32| v / 41 * 41 + to(v % 41);
        let narrow = measure(&grid, &grid, &map(&grid, |v| column(v, &|x| if x > 28 { 28 + (x - 28) / 2 } else { x })));
        assert_statistic(&narrow.statistics, "share", 0.0, 0.0);
        // To a point, as a shank to a knee: the middle of the lost patch has nothing left.
        let point = measure(&grid, &grid, &map(&grid, |v| if v % 41 > 28 && v / 41 > 28 { 28 * 41 + 28 } else { v }));
        // The patch has (12 / 40)² of the places, of which those within a shell of the rim keep some distances.
        let share = point.statistics.number("share").unwrap();
        assert!((1.0..9.0).contains(&share), "{share}");
        assert_statistic(&point.statistics, "p1", 0.0, 0.5);
        let worst = point.statistics.number("worst").unwrap() as u32;
        assert!(worst % 41 > 28 && worst / 41 > 28, "{worst} lies in the patch");
        assert!(point.field[worst as usize] > 50.0 && point.field[0] < 1.0);
    }

    #[test]
    fn without_a_map_or_with_too_few_places_there_is_nothing_to_measure() {
        let sphere = meshes::icosphere(0);
        assert!(measure(&sphere, &sphere, &map(&sphere, |v| v)).statistics.values.is_empty());
    }
}
