//! Whether neighbours on the target take their motion from neighbours on the source.

use mimesh_core::{
    Figures, Result,
    mesh::Surface,
    register,
    stage::{BoundMetric, Limit, Measured, Metric, MetricContext, MetricInput, TransferPair, TriangleMap},
};
use nalgebra::Point3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{elements, size, spread::Spread};

register!(Metric: MapTears);

/// Whether neighbours on the target take their motion from neighbours on the source, at rest.
///
/// Neighbours are, where the map knows a point of the source for vertices, the ends of edges with such points, else triangles with
/// partners that share an edge, at their barycentres. With d their distance, D and D′ the diagonals of target and source, they
/// should be e = d D′ / D apart on the source, and are e′. The gap is max(0, e′ − e − h), in percent of D′, h the mean length of the
/// source's edges, since a coarse source can do no better. Neighbours count by d. Figures:
/// - `share`: neighbours with a gap of more than 5 %, in percent;
/// - `orphans`: triangles without a partner, in percent;
/// - `p99`, `max` of the gaps; `stretch_p99` of e′ / (e + h).
///
/// Distances are straight, not along the surface. There are no figures without a map. They are the same for every pose. The field is
/// the largest gap at a vertex.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct MapTears {}

/// From where on a gap is a tear, in percent of the source's diagonal.
const TEAR: f64 = 5.0;

#[typetag::serde(name = "map_tears")]
impl Metric for MapTears {
    fn bind<'a>(&self, subject: MetricContext<'a>) -> Result<Box<dyn BoundMetric + 'a>> {
        let measured = match (subject.pair, subject.map) {
            (Some(pair), Some(map)) => tears(subject, pair, map)?,
            _ => Measured::default(),
        };
        Ok(Box::new(Bound { subject, measured }))
    }

    fn figures(&self) -> Vec<&'static str> {
        vec!["share", "orphans", "p99", "max", "stretch_p99"]
    }

    fn limits(&self) -> Vec<Limit> {
        vec![
            Limit { figure: "share", doubtful: 0.05, bad: 0.5 },
            Limit { figure: "orphans", doubtful: 25.0, bad: 75.0 },
            Limit { figure: "stretch_p99", doubtful: 1.4, bad: 2.5 },
        ]
    }

    fn by_default(&self) -> bool {
        true
    }
}

struct Bound<'a> {
    subject: MetricContext<'a>,
    measured: Measured,
}

impl BoundMetric for Bound<'_> {
    fn measure(&self, pose: MetricInput<'_>) -> Result<Measured> {
        self.subject.check(&pose)?;
        Ok(self.measured.clone())
    }
}

/// Two neighbours: distances on target and source, and the vertices that they have a say about.
struct Neighbours {
    target: f64,
    source: f64,
    vertices: Vec<u32>,
}

fn tears(subject: MetricContext<'_>, pair: TransferPair<'_>, map: &TriangleMap) -> Result<Measured> {
    map.check(pair)?;
    let (diagonal, source_diagonal) = (size::of_rest(subject.rest)?, size::of_source(pair.source)?);
    let neighbours = if map.points.iter().any(Option::is_some) { ends(pair, map) } else { triangles(pair, map) };
    let grain = mean_edge(pair.source);
    let expected = |n: &Neighbours| n.target * source_diagonal / diagonal + grain;
    let gap = |n: &Neighbours| 100.0 * (n.source - expected(n)).max(0.0) / source_diagonal;
    let Some(gaps) = Spread::new(neighbours.iter().map(|n| (gap(n), n.target))) else {
        return Ok(Measured::default());
    };
    let total: f64 = neighbours.iter().map(|n| n.target).sum();
    let torn: f64 = neighbours.iter().filter(|n| gap(n) > TEAR).fold(0.0, |sum, n| sum + n.target);
    let stretch = Spread::new(neighbours.iter().map(|n| (n.source / expected(n), n.target)));
    let mut figures = Figures::default();
    figures.set("share", 100.0 * torn / total);
    figures.set("orphans", 100.0 * map.orphan_count() as f64 / map.partners.len().max(1) as f64);
    figures.set("p99", gaps.percentile(0.99));
    figures.set("max", gaps.max());
    figures.set("stretch_p99", stretch.map_or(0.0, |stretch| stretch.percentile(0.99)));
    let mut values = vec![f64::NAN; subject.surface.vertex_count()];
    neighbours.iter().for_each(|n| size::raise(&mut values, &n.vertices, gap(n)));
    let field = size::field(subject.surface, &values);
    Ok(Measured { figures, about: vec![], field, field_unit: "map gap, %", field_high: 10.0 })
}

/// Ends of edges that lie at points of the source.
fn ends(pair: TransferPair<'_>, map: &TriangleMap) -> Vec<Neighbours> {
    let at = |point: &Option<_>| -> Option<Point3<f64>> {
        point.map(|p: mimesh_core::mesh::SurfacePoint| p.position(pair.source, &pair.source.positions))
    };
    let places: Vec<Option<Point3<f64>>> = map.points.iter().map(at).collect();
    let rest = &pair.target.positions;
    let neighbours = |[a, b]: [u32; 2]| {
        let (p, q) = (places[a as usize]?, places[b as usize]?);
        Some(Neighbours {
            target: (rest[b as usize] - rest[a as usize]).norm(),
            source: (q - p).norm(),
            vertices: vec![a, b],
        })
    };
    elements::ends(pair.target).into_iter().filter_map(neighbours).collect()
}

/// Adjacent triangles with partners.
fn triangles(pair: TransferPair<'_>, map: &TriangleMap) -> Vec<Neighbours> {
    let [target, source] = [pair.target, pair.source].map(|surface| surface.barycentres(&surface.positions));
    let neighbours = |[a, b]: [u32; 2]| {
        let (p, q) = (map.partners[a as usize]?, map.partners[b as usize]?);
        Some(Neighbours {
            target: (target[b as usize] - target[a as usize]).norm(),
            source: (source[q as usize] - source[p as usize]).norm(),
            vertices: [a, b].iter().flat_map(|&t| pair.target.triangles[t as usize]).collect(),
        })
    };
    pair.target.topology().adjacent.into_iter().filter_map(neighbours).collect()
}

fn mean_edge(surface: &Surface) -> f64 {
    let edges = elements::edges(surface);
    edges.rest.iter().sum::<f64>() / edges.rest.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use mimesh_core::{
        mesh::{Mesh, SurfacePoint},
        testkit::meshes,
    };

    use super::*;
    use crate::testing::assert_figure;

    fn measure(surface: &Surface, map: &TriangleMap) -> Measured {
        let mesh = Mesh::from_triangles(surface.positions.clone(), &surface.triangles);
        let pair = TransferPair { source: surface, target: surface, markers: &[], proximity: None };
        let subject = MetricContext { pair: Some(pair), map: Some(map), ..MetricContext::alone(&mesh, surface) };
        MapTears {}.bind(subject).unwrap().measure(MetricInput::alone(&surface.positions)).unwrap()
    }

    #[test]
    fn the_identity_is_whole_and_two_swapped_patches_tear_along_their_rims() {
        let grid = meshes::grid(16, 16);
        let count = grid.triangle_count() as u32;
        let mut map = TriangleMap {
            source_triangles: count as usize,
            partners: (0..count).map(Some).collect(),
            ..TriangleMap::default()
        };
        assert_figure(&measure(&grid, &map).figures, "max", 0.0, 0.0);
        // Two triangles at opposite corners.
        map.partners.swap(0, count as usize - 1);
        let measured = measure(&grid, &map);
        // A diagonal less a cell, a sixteenth, and the mean edge, about a twentieth.
        assert_figure(&measured.figures, "max", 89.0, 5.0);
        assert!(measured.figures.number("share").unwrap() > 0.0);
        assert_eq!(measured.field[8 * 17 + 8], 0.0, "the middle is whole");
        assert!(measured.field[0] > 80.0);
    }

    #[test]
    fn points_of_vertices_go_before_partners_and_orphans_have_no_neighbours() {
        let grid = meshes::grid(16, 16);
        let count = grid.triangle_count();
        let mut map = TriangleMap { source_triangles: count, partners: vec![None; count], ..TriangleMap::default() };
        map.partners[0] = Some(0);
        assert!(measure(&grid, &map).figures.values.is_empty());
        map.points = (0..grid.vertex_count() as u32).map(|v| Some(SurfacePoint::Vertex(v))).collect();
        assert_figure(&measure(&grid, &map).figures, "max", 0.0, 0.0);
        map.points[8 * 17 + 8] = Some(SurfacePoint::Vertex(0));
        // Half a diagonal, less the edge and the mean edge.
        assert_figure(&measure(&grid, &map).figures, "max", 45.0, 5.0);
    }
}
