//! Fits maps of handles to a pose by least squares.
//!
//! Minimises Σᵢ ‖qᵢ − q′ᵢ‖² over affine maps T of the handles, with q the linear blend of T: eq. 5 of Yang et al. 2018 with λ = 0.
//! It comes nearest to the pose, and overfits where handles are many; `arap_skinning` keeps regions rigid besides.
//!
//! Cost, for h handles: per set of handles O(#V h²) and one Cholesky factorisation of 4h × 4h; per pose O(#V h).

use std::sync::Arc;

use mimesh_core::{
    Error, Result,
    mesh::Surface,
    plugin::check_ranges,
    register,
    stage::{BoundDeformer, Deformer, Fit, HandleWeights, Regions, Skin},
};
use nalgebra::{DMatrix, Point3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{alternation::GlobalSystem, handles::Handles, reference::RestShape};

register!(Deformer: LinearBlend);

/// Fits affine maps of handles to a pose by least squares.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct LinearBlend {
    /// How strongly each handle is drawn to the best rigid motion of what it moves, relative to its share of the closeness to
    /// the pose: it decides what the pose leaves open, as across a flat region.
    #[schemars(range(min = 1e-12, max = 1.0))]
    pub regularisation: f64,
}

impl Default for LinearBlend {
    fn default() -> Self {
        Self { regularisation: 1e-3 }
    }
}

#[typetag::serde(name = "linear_blend")]
impl Deformer for LinearBlend {
    fn bind(&self, surface: &Surface) -> Result<Box<dyn BoundDeformer>> {
        self.bind_coarse(surface, &vec![1.0; surface.vertex_count()])
    }

    fn bind_coarse(&self, surface: &Surface, counts: &[f64]) -> Result<Box<dyn BoundDeformer>> {
        check_ranges(self)?;
        Error::check_shape("counts of vertices (#V)", surface.vertex_count(), counts.len())?;
        let rest = Arc::new(RestShape::new(&surface.positions));
        Ok(Box::new(Bound { regularisation: self.regularisation, rest, counts: counts.to_vec() }))
    }
}

#[derive(Clone, Debug)]
struct Bound {
    regularisation: f64,
    rest: Arc<RestShape>,
    /// How much each vertex counts.
    counts: Vec<f64>,
}

impl BoundDeformer for Bound {
    fn skin(&self, weights: &HandleWeights, regions: &Regions) -> Result<Box<dyn Skin>> {
        let count = self.rest.positions.len();
        regions.check(count)?;
        let handles = Handles::new(&self.rest, weights, self.counts.clone(), self.regularisation)?;
        let space = &handles.space;
        let matrix = space.symmetric_product(&space.scaled(&self.counts));
        let no_rotations = DMatrix::zeros(handles.space.size(), 0);
        let system = GlobalSystem::new(matrix, &handles.ridge, &no_rotations)?;
        Ok(Box::new(Skinned { handles, system }))
    }
}

#[derive(Clone, Debug)]
struct Skinned {
    handles: Handles,
    system: GlobalSystem,
}

impl Skin for Skinned {
    fn fit(&self, posed: &[Point3<f64>]) -> Result<Fit> {
        let (seen, goal) = self.handles.see(posed)?;
        let maps = self.system.solve(&(&goal.projected + &goal.ridge_rhs(&self.handles.ridge)));
        Ok(self.handles.fit(&seen, &maps))
    }
}
