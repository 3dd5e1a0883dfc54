//! Points at vertices, each the farthest from those before [Gonzalez 1985].
//!
//! The first is drawn at random among the vertices. As long as some component with area has no point, the next is taken on such
//! components; if there are more components than points, the others stay without. Vertices of triangles without area only are
//! left out. The first k points are those that a `count` of k gives.

use mimesh_core::{
    Result,
    mesh::{Surface, SurfacePoint},
    plugin::check_ranges,
    random::Random,
    register,
    spatial::EdgePaths,
    stage::{AvailablePoints, Sampler},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::ground::{Ground, too_few};

register!(Sampler: FarthestPoint);

/// Vertices spread evenly over a surface, each the farthest from those before.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct FarthestPoint {
    /// Number of points.
    #[schemars(range(min = 1))]
    pub count: usize,
    /// Chooses the first point.
    pub seed: u64,
    /// The measure of distance.
    pub metric: Metric,
}

/// The measure of distance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Metric {
    /// Along the surface, so that both of two limbs that lie side by side get points.
    #[default]
    Geodesic,
    /// Straight through space.
    Euclidean,
}

impl Default for FarthestPoint {
    fn default() -> Self {
        Self { count: 100, seed: 0, metric: Metric::Geodesic }
    }
}

#[typetag::serde(name = "farthest_point")]
impl Sampler for FarthestPoint {
    fn sample(&self, surface: &Surface) -> Result<Vec<SurfacePoint>> {
        check_ranges(self)?;
        let ground = Ground::new(surface)?;
        ground.check(self.count)?;
        let chosen = self.spread(surface, &ground);
        if chosen.len() < self.count { Err(too_few(self.count, chosen.len())) } else { Ok(chosen) }
    }

    fn sample_available(&self, surface: &Surface) -> Result<AvailablePoints> {
        check_ranges(self)?;
        Ok(AvailablePoints { points: self.spread(surface, &Ground::new(surface)?), asked: self.count })
    }
}

impl FarthestPoint {
    /// `count` vertices, or fewer if no more lie at different places.
    fn spread(&self, surface: &Surface, ground: &Ground) -> Vec<SurfacePoint> {
        let paths = match self.metric {
            Metric::Geodesic => Some(EdgePaths::new(&surface.positions, &surface.triangles, &[])),
            Metric::Euclidean => None,
        };
        let mut chosen = vec![ground.vertices[Random::new(self.seed).index(ground.vertices.len())]];
        let mut has_point = vec![false; ground.all_components()];
        let mut without = ground.component_count;
        let mut straight = vec![f64::INFINITY; surface.vertex_count()];
        let mut along = straight.clone();
        loop {
            let last = chosen[chosen.len() - 1];
            if !std::mem::replace(&mut has_point[ground.component(last)], true) {
                without -= 1;
            }
            if chosen.len() == self.count {
                break;
            }
            let from = surface.positions[last as usize];
            straight.iter_mut().zip(&surface.positions).for_each(|(d, p)| *d = d.min((p - from).norm()));
            if let Some(paths) = &paths {
                paths.shorten(&mut along, last);
            }
            // No path leads to a component without a point: there the straight distance decides.
            let distances = if paths.is_some() && without == 0 { &along } else { &straight };
            let distance = |v: u32| distances[v as usize];
            let is_open = |v: &u32| without == 0 || !has_point[ground.component(*v)];
            let farthest = ground
                .vertices
                .iter()
                .copied()
                .filter(is_open)
                .reduce(|best, v| if distance(v) > distance(best) { v } else { best });
            // A component may coincide with another; a vertex of one that has a point must lie elsewhere.
            match farthest.filter(|&v| without > 0 || distance(v) > 0.0) {
                Some(v) => chosen.push(v),
                None => break,
            }
        }
        chosen.into_iter().map(SurfacePoint::Vertex).collect()
    }
}
