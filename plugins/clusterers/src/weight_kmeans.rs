//! Regions of vertices that the same handles move: k-means on the rows of W.
//!
//! Jacobson et al. 2012, section 4; section 3.3 of Yang et al. 2018 without poses. The same regions serve every pose.

use mimesh_core::{
    Error, Result,
    mesh::Surface,
    plugin::check_ranges,
    register,
    stage::{BoundClusterer, Clusterer, Regions},
};
use nalgebra::{DMatrix, Point3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{kmeans::Kmeans, points::Points, start::Start};

register!(Clusterer: WeightKmeans);

/// Regions of vertices that the same handles move: k-means on the rows of W (Jacobson et al. 2012).
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct WeightKmeans {
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

impl Default for WeightKmeans {
    fn default() -> Self {
        Self { regions: None, start: Start::Handles, restarts: 1, max_iterations: 100, seed: 0 }
    }
}

#[typetag::serde(name = "weight_kmeans")]
impl Clusterer for WeightKmeans {
    fn bind(&self, surface: &Surface, poses: &[Vec<Point3<f64>>]) -> Result<Box<dyn BoundClusterer>> {
        check_ranges(self)?;
        let vertices = surface.vertex_count();
        poses.iter().try_for_each(|pose| Error::check_shape("posed vertices (#V)", vertices, pose.len()))?;
        Ok(Box::new(Bound { settings: self.clone(), vertices }))
    }
}

#[derive(Clone, Debug)]
struct Bound {
    settings: WeightKmeans,
    vertices: usize,
}

impl BoundClusterer for Bound {
    fn cluster(&self, weights: &DMatrix<f64>) -> Result<Regions> {
        let points = rows_of_weights(self.vertices, weights, 0)?;
        let WeightKmeans { regions, start, restarts, max_iterations, seed } = self.settings;
        let clusters = regions.unwrap_or(weights.ncols());
        Ok(Kmeans { clusters, restarts, max_iterations, seed }.regions(&points, start.clusters(weights, clusters)))
    }
}

/// The rows of W, with room for `more` dimensions after them.
///
/// # Errors
///
/// [`Error::Shape`] if W does not have `vertices` rows or has no column, [`Error::Data`] if it is not finite.
pub(crate) fn rows_of_weights(vertices: usize, weights: &DMatrix<f64>, more: usize) -> Result<Points> {
    Error::check_shape("rows of the weights (#V)", vertices, weights.nrows())?;
    if weights.ncols() == 0 {
        return Err(Error::Shape { what: "columns of the weights (#H)", expected: 1, found: 0 });
    }
    let mut points = Points::zeros(vertices, weights.ncols() + more);
    for (k, column) in weights.column_iter().enumerate() {
        for (i, &w) in column.iter().enumerate() {
            if !w.is_finite() {
                return Err(Error::data(
                    format!("the weight of vertex {i} for handle {k} (both from 0) is {w}: expected a finite number"),
                    "look at the stage that makes the weights",
                ));
            }
            points.row_mut(i)[k] = w;
        }
    }
    Ok(points)
}
