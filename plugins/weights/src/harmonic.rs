//! Harmonic weights, in closed form.
//!
//! They minimise the Dirichlet energy ½ wᵀ L w with w = 1 at the own handle and 0 at the others. They lie within 0 to 1 where
//! the triangulation is Delaunay and a little outside elsewhere; rows sum to 1. Around a handle they fall off like a logarithm,
//! so that its influence shrinks to its vertex as the mesh gets finer: a baseline rather than a choice. What is asked of
//! handles, components and vertices without area is as in [`bounded_biharmonic`](crate::bounded_biharmonic).

use mimesh_core::{
    Figures, Result,
    mesh::{Surface, SurfacePoint},
    plugin::check_ranges,
    register,
    stage::{BoundWeights, HandlePoints, HandleWeights, ProximityGraph, Weights},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{
    domain::{Domain, Group},
    greens::Greens,
};

register!(Weights: Harmonic);

/// Harmonic weights: spread like heat between handles, with a spike at each.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Harmonic {
    /// Strength of the bridges that `proximity` makes between components, relative to the edges of the surface (to the median
    /// cotangent weight); 0 for none.
    #[schemars(range(min = 0.0))]
    pub bridge: f64,
}

impl Default for Harmonic {
    fn default() -> Self {
        Self { bridge: 0.5 }
    }
}

#[typetag::serde(name = "harmonic")]
impl Weights for Harmonic {
    fn bind(
        &self,
        surface: &Surface,
        points: &[SurfacePoint],
        proximity: Option<&ProximityGraph>,
    ) -> Result<Box<dyn BoundWeights>> {
        check_ranges(self)?;
        let points = HandlePoints::new(surface, points)?;
        let domain = Domain::new(surface, proximity, self.bridge)?;
        let energy = |group: &Group| group.laplacian.clone();
        Ok(Box::new(Bound(Greens::new(domain, points, energy, "the energy of harmonic weights", false)?)))
    }
}

/// Weights bound to a surface.
#[derive(Debug)]
struct Bound(Greens);

impl BoundWeights for Bound {
    fn solve(&self, handles: &[usize]) -> Result<HandleWeights> {
        self.0.solve(handles, |_| 1.0)
    }

    fn figures(&self) -> Figures {
        self.0.figures()
    }
}
