//! Neighbours on the target that take their motion from distant places of the source.

use mimesh_core::{
    Figures, Result,
    mesh::{Surface, SurfacePoint},
    register,
    stage::{BoundMetric, Measured, Metric, MetricContext, Statistic, TransferPair, TriangleMap},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{
    at_rest::AtRest,
    component_pairs,
    component_tears::{self, Neighbours},
    diagonal,
    distribution::Distribution,
    elements, vertex_field,
};

register!(Metric: MapTears);

/// Neighbours on the target that take their motion from distant places of the source, at rest.
///
/// If the map knows points of the source for vertices, neighbours are the ends of edges that both have such a point. Otherwise they
/// are triangles that share an edge and both have a partner, at their barycentres. Two neighbours are d apart on the target, and
/// their places are e′ apart on the source. With the diagonals D of the target and D′ of the source they should be e = d D′ / D
/// apart.
///
/// The gap is max(0, e′ − e − h) in percent of D′. Here h is the mean length of the source's edges, since a coarse source can do no
/// better. Neighbours count by d. All poses have the same statistics; without a map there are none. The field is the largest gap at a
/// vertex.
///
/// These distances are straight. A component that lies on both lips, or on both thighs, shows along the source only. There two neighbours
/// are torn if the way along the source exceeds e by more than 5 % of D′ and the longest edge of the two source triangles. Gaps between
/// components of the source are bridged.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct MapTears {}

/// The smallest gap that is a tear, in percent of the source's diagonal.
const MIN_TEAR: f64 = 5.0;

#[typetag::serde(name = "map_tears")]
impl Metric for MapTears {
    fn bind<'a>(&self, context: MetricContext<'a>) -> Result<Box<dyn BoundMetric + 'a>> {
        match (context.pair, context.map) {
            (Some(pair), Some(map)) => tears(context, pair, map),
            _ => Ok(AtRest::boxed(context, Measured::default())),
        }
    }

    fn statistics(&self) -> Vec<Statistic> {
        vec![
            Statistic::new("share", "%", "Share of neighbours with a gap above 5 %.").with_title("neighbours that are torn apart on the source").with_limits(0.05, 0.5),
            Statistic::new("orphans", "%", "Share of triangles without a partner.").with_title("triangles without a partner").with_limits(25.0, 75.0),
            Statistic::new("p99", "%", "99th percentile of the gap."),
            Statistic::new("max", "%", "Largest gap."),
            Statistic::new("stretch_p99", "ratio", "How many times farther apart neighbours lie on the source than they should, near the worst place: 99th percentile of e′ / (e + h).").with_title("neighbours that are drawn apart on the source").with_limits(1.4, 2.5),
            Statistic::new(
                "worst_component",
                "%",
                "Largest share of neighbours in a component that are torn along the source.",
            )
            .with_title("neighbours that are torn apart in the worst part").with_limits(10.0, 100.0),
            Statistic::index("worst", "Component with the largest share, numbered by first vertex."),
        ]
    }

    fn fault(&self) -> &'static str {
        "neighbours on the target follow distant places of the source: look at the colours of the map, and give a marker \
         there"
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
fn tears<'a>(
    context: MetricContext<'a>,
    pair: TransferPair<'_>,
    map: &TriangleMap,
) -> Result<Box<dyn BoundMetric + 'a>> {
    map.check(pair)?;
    let (diagonal, source_diagonal) = (diagonal::of_target(context.surface)?, diagonal::of_source(pair.source)?);
    let neighbours = if map.points.iter().any(Option::is_some) { edge_ends(pair, map) } else { triangles(pair, map) };
    let source_edge = mean_edge(pair.source);
    let expected = move |n: &Neighbours| n.target * source_diagonal / diagonal + source_edge;
    let gap = move |n: &Neighbours| 100.0 * (n.source - expected(n)).max(0.0) / source_diagonal;
    let Some(gaps) = Distribution::weighted(neighbours.iter().map(|n| (gap(n), n.target))) else {
        return Ok(AtRest::boxed(context, Measured::default()));
    };
    let total: f64 = neighbours.iter().map(|n| n.target).sum();
    let torn: f64 = neighbours.iter().filter(|n| gap(n) > MIN_TEAR).fold(0.0, |sum, n| sum + n.target);
    let stretch = Distribution::weighted(neighbours.iter().map(|n| (n.source / expected(n), n.target)));
    let mut statistics = Figures::default();
    statistics.set("share", 100.0 * torn / total);
    statistics.set("orphans", 100.0 * map.orphan_count() as f64 / map.triangles.len().max(1) as f64);
    statistics.set("p99", gaps.percentile(0.99));
    statistics.set("max", gaps.max());
    statistics.set("stretch_p99", stretch.map_or(0.0, |stretch| stretch.percentile(0.99)));
    let mut about = vec![];
    let worst = component_tears::worst(pair, &neighbours, source_diagonal / diagonal, source_diagonal)?;
    if let Some((component, share)) = worst {
        statistics.set("worst_component", share);
        statistics.set("worst", component);
        about.push(("worst_component", component_pairs::describe(context.surface, component)));
    }
    let measured = Measured { statistics, about, field: vec![], field_unit: "map gap, %", field_high: 10.0 };
    let field = move || {
        let mut values = vec![f64::NAN; context.surface.vertex_count()];
        neighbours.iter().for_each(|n| vertex_field::raise(&mut values, &n.vertices, gap(n)));
        vertex_field::on_mesh(context.surface, &values)
    };
    Ok(AtRest::with_field(context, measured, Box::new(field)))
}

/// The ends of edges of the target that both have a point on the source.
fn edge_ends(pair: TransferPair<'_>, map: &TriangleMap) -> Vec<Neighbours> {
    let position = |point: SurfacePoint| point.position(pair.source, &pair.source.positions);
    let rest = &pair.target.positions;
    let neighbours = |[a, b]: [u32; 2]| {
        let (p, q) = (map.points[a as usize]?, map.points[b as usize]?);
        Some(Neighbours {
            target: (rest[b as usize] - rest[a as usize]).norm(),
            source: (position(q) - position(p)).norm(),
            places: [p, q],
            vertices: [a, b, a, b, a, b],
        })
    };
    pair.target.edges().into_iter().filter_map(neighbours).collect()
}

/// Adjacent triangles of the target that both have a partner.
fn triangles(pair: TransferPair<'_>, map: &TriangleMap) -> Vec<Neighbours> {
    let [target, source] = [pair.target, pair.source].map(|surface| surface.barycentres(&surface.positions));
    let neighbours = |[a, b]: [u32; 2]| {
        let (p, q) = (map.triangles[a as usize]?, map.triangles[b as usize]?);
        Some(Neighbours {
            target: (target[b as usize] - target[a as usize]).norm(),
            source: (source[q as usize] - source[p as usize]).norm(),
            places: [p, q].map(|t| SurfacePoint::Triangle(t, [1.0 / 3.0; 3])),
            vertices: std::array::from_fn(|i| pair.target.triangles[[a, b][i / 3] as usize][i % 3]),
        })
    };
    pair.target.topology().adjacent.into_iter().filter_map(neighbours).collect()
}

/// The mean length of the edges of a surface at rest.
fn mean_edge(surface: &Surface) -> f64 {
    let edges = elements::edges(surface);
    edges.rest.iter().sum::<f64>() / edges.rest.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use mimesh_core::{mesh::Mesh, stage::MetricInput, testkit::meshes};

    use super::*;
    use crate::testing::assert_statistic;

    fn measure(surface: &Surface, map: &TriangleMap) -> Measured {
        let mesh = Mesh::from_triangles(surface.positions.clone(), &surface.triangles);
        let pair = TransferPair { source: surface, target: surface, markers: &[], proximity: None };
        let context = MetricContext { pair: Some(pair), map: Some(map), ..MetricContext::alone(&mesh, surface) };
        MapTears {}.bind(context).unwrap().measure(MetricInput::alone(context.at_rest())).unwrap()
    }

    #[test]
    fn the_identity_is_whole_and_two_swapped_patches_tear_along_their_rims() {
        let grid = meshes::grid(16, 16);
        let count = grid.triangle_count() as u32;
        let mut map = TriangleMap {
            source_triangle_count: count as usize,
            triangles: (0..count).map(Some).collect(),
            ..TriangleMap::default()
        };
        assert_statistic(&measure(&grid, &map).statistics, "max", 0.0, 0.0);
        // Two triangles at opposite corners.
        map.triangles.swap(0, count as usize - 1);
        let measured = measure(&grid, &map);
        // A diagonal less a cell, a sixteenth, and the mean edge, about a twentieth.
        assert_statistic(&measured.statistics, "max", 89.0, 5.0);
        assert!(measured.statistics.number("share").unwrap() > 0.0);
        assert_eq!(measured.field[8 * 17 + 8], 0.0, "the middle is whole");
        assert!(measured.field[0] > 80.0);
    }

    #[test]
    fn points_of_vertices_go_before_partners_and_orphans_have_no_neighbours() {
        let grid = meshes::grid(16, 16);
        let count = grid.triangle_count();
        let mut map =
            TriangleMap { source_triangle_count: count, triangles: vec![None; count], ..TriangleMap::default() };
        map.triangles[0] = Some(0);
        assert!(measure(&grid, &map).statistics.values.is_empty());
        map.points = (0..grid.vertex_count() as u32).map(|v| Some(SurfacePoint::Vertex(v))).collect();
        assert_statistic(&measure(&grid, &map).statistics, "max", 0.0, 0.0);
        map.points[8 * 17 + 8] = Some(SurfacePoint::Vertex(0));
        // Half a diagonal, less the edge and the mean edge.
        assert_statistic(&measure(&grid, &map).statistics, "max", 45.0, 5.0);
    }
}
