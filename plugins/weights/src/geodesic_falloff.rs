//! Weights that fall off with the distance along the surface.
//!
//! w ∝ d⁻ᵖ with d the distance to the handle [Shepard 1968], divided by the sum over handles. Distances are those of
//! [`EdgePaths`]: shortest paths along edges and across pairs of triangles, some percent too long. Cheap, always within 0 to 1,
//! and as smooth as paths are; a baseline. Bridged components are as far apart as the ends of their bridges.

use mimesh_core::{
    Figures, Result,
    mesh::{Surface, SurfacePoint},
    plugin::check_ranges,
    register,
    spatial::EdgePaths,
    stage::{BoundWeights, HandlePoints, HandleWeights, ProximityGraph, Weights},
};
use nalgebra::DMatrix;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::domain::Domain;

register!(Weights: GeodesicFalloff);

/// Weights by inverse distance along the surface: cheap, a baseline.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct GeodesicFalloff {
    /// p: how fast weights fall off; the greater, the sharper is the border between two handles.
    #[schemars(range(min = 1.0, max = 16.0))]
    pub power: f64,
}

impl Default for GeodesicFalloff {
    fn default() -> Self {
        Self { power: 2.0 }
    }
}

#[typetag::serde(name = "geodesic_falloff")]
impl Weights for GeodesicFalloff {
    fn bind(
        &self,
        surface: &Surface,
        points: &[SurfacePoint],
        proximity: Option<&ProximityGraph>,
    ) -> Result<Box<dyn BoundWeights>> {
        check_ranges(self)?;
        let points = HandlePoints::new(surface, points)?;
        // The strength of bridges does not matter here, only that there are some.
        let domain = Domain::new(surface, proximity, 1.0)?;
        let paths = EdgePaths::new(&surface.positions, &surface.triangles, &domain.bridges);
        let distances = points.all().par_iter().map(|&v| paths.distances(&[v])).collect();
        Ok(Box::new(Bound { power: self.power, domain, points, distances }))
    }
}

/// Weights bound to a surface.
#[derive(Debug)]
struct Bound {
    power: f64,
    domain: Domain,
    points: HandlePoints,
    /// From each point to each vertex.
    distances: Vec<Vec<f64>>,
}

impl BoundWeights for Bound {
    fn solve(&self, handles: &[usize]) -> Result<HandleWeights> {
        let vertices = self.points.choose(handles)?;
        let by_group = self.domain.by_group(&vertices)?;
        let mut matrix = DMatrix::zeros(self.domain.place.len(), handles.len());
        for (group, own) in self.domain.groups.iter().zip(&by_group).filter(|(_, own)| !own.is_empty()) {
            for v in group.vertices.iter().map(|&v| v as usize) {
                let distance = |&h: &usize| self.distances[handles[h]][v];
                let nearest = own.iter().map(distance).fold(f64::INFINITY, f64::min);
                // Relative to the nearest, so that no power overflows; at distance 0 only handles at 0 count.
                let share = |h: &usize| match (distance(h), nearest) {
                    (d, nearest) if d == nearest => 1.0,
                    (d, nearest) => (nearest / d).powf(self.power),
                };
                let sum: f64 = own.iter().map(share).sum();
                own.iter().for_each(|h| matrix[(v, *h)] = share(h) / sum);
            }
            for (&h, v) in own.iter().map(|h| (h, vertices[*h] as usize)) {
                own.iter().for_each(|&other| matrix[(v, other)] = f64::from(u8::from(other == h)));
            }
        }
        for [v, by] in self.domain.unreached(&by_group)? {
            let row = matrix.row(by as usize).into_owned();
            matrix.set_row(v as usize, &row);
        }
        Ok(HandleWeights { matrix, figures: Figures::default() })
    }

    fn figures(&self) -> Figures {
        self.domain.figures()
    }
}
