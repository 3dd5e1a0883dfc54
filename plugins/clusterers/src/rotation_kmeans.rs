//! Regions of vertices that the same handles move and that turn alike in the poses: k-means on W′.
//!
//! Yang et al. 2018, section 3.3: W′ = [W, γ_logr log r / √m, γ_s s / √m] over m poses (eq. 15), where r and s are rotation and
//! stretch of the deformation gradient of each vertex's neighbours (eqs. 6 to 14).
//!
//! Departures: rotations count from the rigid motion of the whole, so that regions do not depend on where a pose stands and
//! which way it faces; their logarithms are continuous across half turns; where a ring of neighbours is flat its normal
//! decides, where it has no area it is taken not to turn.
//!
//! Cost: all of log r and s is computed once, O(m #V); for weights, as k-means.

use mimesh_core::{
    Error, Result,
    mesh::{Surface, check_finite},
    plugin::check_ranges,
    register,
    stage::{BoundClusterer, Clusterer, Regions},
};
use nalgebra::{DMatrix, Point3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{
    kmeans::Kmeans, pose_features::pose_features, principal::along_principal_axes, start::Start,
    weight_kmeans::rows_of_weights,
};

register!(Clusterer: RotationKmeans);

/// Regions of vertices that the same handles move and that turn alike in the poses: k-means on W′ (Yang et al. 2018).
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct RotationKmeans {
    /// γ_logr: how much rotations (in radians) count against weights.
    #[schemars(range(min = 0.0))]
    pub rotation_weight: f64,
    /// γ_s: how much stretch (1 is none) counts against weights.
    #[schemars(range(min = 0.0))]
    pub stretch_weight: f64,
    /// How many regions there are at most; as many as handles if not given.
    #[schemars(range(min = 1))]
    pub regions: Option<usize>,
    /// The clusters of the first start.
    pub start: Start,
    /// Number of starts, after the first from random centres; the best result is kept.
    #[schemars(range(min = 1))]
    pub restarts: usize,
    /// Most iterations a start.
    #[schemars(range(min = 1))]
    pub max_iterations: usize,
    /// Seed of the random starts; equal seeds give equal regions.
    pub seed: u64,
}

impl Default for RotationKmeans {
    fn default() -> Self {
        Self {
            rotation_weight: 1.0,
            stretch_weight: 0.1,
            regions: None,
            start: Start::Handles,
            restarts: 1,
            max_iterations: 100,
            seed: 0,
        }
    }
}

#[typetag::serde(name = "rotation_kmeans")]
impl Clusterer for RotationKmeans {
    fn bind(&self, surface: &Surface, poses: &[Vec<Point3<f64>>]) -> Result<Box<dyn BoundClusterer>> {
        check_ranges(self)?;
        for pose in poses {
            Error::check_shape("posed vertices (#V)", surface.vertex_count(), pose.len())?;
            check_finite(pose)?;
        }
        let features = pose_features(surface, poses, self.rotation_weight, self.stretch_weight);
        Ok(Box::new(Bound { settings: self.clone(), features: along_principal_axes(features) }))
    }
}

#[derive(Clone, Debug)]
struct Bound {
    settings: RotationKmeans,
    /// The columns that poses add to W, one a vertex, in directions that keep distances.
    features: DMatrix<f64>,
}

impl BoundClusterer for Bound {
    fn cluster(&self, weights: &DMatrix<f64>) -> Result<Regions> {
        let (dimensions, vertices) = self.features.shape();
        let mut points = rows_of_weights(vertices, weights, dimensions)?;
        for (i, features) in self.features.column_iter().enumerate() {
            let room = &mut points.row_mut(i)[weights.ncols()..][..dimensions];
            room.iter_mut().zip(&features).for_each(|(x, feature)| *x = *feature);
        }
        let RotationKmeans { regions, start, restarts, max_iterations, seed, .. } = self.settings;
        let clusters = regions.unwrap_or(weights.ncols());
        Ok(Kmeans { clusters, restarts, max_iterations, seed }.regions(&points, start.clusters(weights, clusters)))
    }
}
