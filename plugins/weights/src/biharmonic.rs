//! Biharmonic weights without bounds, in closed form.
//!
//! They minimise ½ wᵀ L M⁻¹ L w with w = 1 at the own handle and 0 at the others, as bounded biharmonic weights do, but may
//! leave 0 to 1: on bodies they reach −0.27 and 1.21 with 12 handles. Their rows sum to 1 by themselves. What is asked of handles,
//! components and vertices without area is as in [`bounded_biharmonic`](crate::bounded_biharmonic).
//!
//! After binding, any choice of handles among the points costs a dense system of their number and a product: thousands of
//! choices a second on 2,000 vertices, which makes them a stand-in for bounded ones in a search.

use mimesh_core::{
    Figures, Result,
    mesh::{Surface, SurfacePoint},
    plugin::check_ranges,
    register,
    stage::{BoundWeights, HandlePoints, HandleWeights, KeptWeights, ProximityGraph, Weights},
};
use nalgebra::DMatrix;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{
    bilaplacian::Bilaplacian,
    domain::{Domain, Group},
    greens::{Greens, KeptGreens},
};

register!(Weights: Biharmonic);

/// The smoothest weights, which may leave 0 to 1: unbounded biharmonic, fast for many choices of handles.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Biharmonic {
    /// Strength of the bridges that `proximity` makes between components, relative to the edges of the surface (to the median
    /// cotangent weight); 0 for none.
    #[schemars(range(min = 0.0))]
    pub bridge: f64,
    /// Sets negative weights to 0 and divides rows by their sums: bounds without a search for the smoothest weights within
    /// them.
    pub clamp: bool,
}

impl Default for Biharmonic {
    fn default() -> Self {
        Self { bridge: 0.5, clamp: false }
    }
}

#[typetag::serde(name = "biharmonic")]
impl Weights for Biharmonic {
    fn bind(
        &self,
        surface: &Surface,
        points: &[SurfacePoint],
        proximity: Option<&ProximityGraph>,
    ) -> Result<Box<dyn BoundWeights>> {
        check_ranges(self)?;
        let points = HandlePoints::new(surface, points)?;
        let domain = Domain::new(surface, proximity, self.bridge)?;
        let energy = |group: &Group| Bilaplacian::new(&group.laplacian, &group.mass).matrix;
        let greens = Greens::new(domain, points, energy, "the energy of biharmonic weights", true)?;
        Ok(Box::new(Bound { greens, clamp: self.clamp }))
    }

    fn keep(&self, surface: &Surface, proximity: Option<&ProximityGraph>) -> Result<Option<Box<dyn KeptWeights>>> {
        check_ranges(self)?;
        let domain = Domain::new(surface, proximity, self.bridge)?;
        let energy = |group: &Group| Bilaplacian::new(&group.laplacian, &group.mass).matrix;
        let greens = KeptGreens::new(domain, energy, "the energy of biharmonic weights", true)?;
        Ok(Some(Box::new(Kept { greens, clamp: self.clamp })))
    }
}

/// Weights of a surface whose handles come and go.
#[derive(Debug)]
struct Kept {
    greens: KeptGreens,
    clamp: bool,
}

impl KeptWeights for Kept {
    fn solve(&mut self, points: &[SurfacePoint]) -> Result<HandleWeights> {
        let mut weights = self.greens.solve(points, |group| group.mean_mass)?;
        if self.clamp {
            clamp(&mut weights.matrix);
        }
        Ok(weights)
    }
}

/// Weights bound to a surface.
#[derive(Debug)]
struct Bound {
    greens: Greens,
    clamp: bool,
}

impl BoundWeights for Bound {
    fn solve(&self, handles: &[usize]) -> Result<HandleWeights> {
        let mut weights = self.greens.solve(handles, |group| group.mean_mass)?;
        if self.clamp {
            clamp(&mut weights.matrix);
        }
        Ok(weights)
    }

    fn figures(&self) -> Figures {
        self.greens.figures()
    }
}

/// Rows without negative weights, of sum 1. As rows sum to 1 before, what is left of one sums to at least 1.
fn clamp(matrix: &mut DMatrix<f64>) {
    matrix.iter_mut().for_each(|w| *w = w.max(0.0));
    let sums = matrix.column_sum();
    for mut column in matrix.column_iter_mut() {
        column.component_div_assign(&sums);
    }
}
