//! Handles on a surface at rest, as every deformer here needs them: from a pose to a goal, from maps to a fit.

use std::sync::Arc;

use mimesh_core::{
    Error, Figures, Result,
    mesh::check_finite,
    stage::{Fit, HandleWeights},
};
use nalgebra::{DMatrix, DVector, Matrix3x4, Point3};

use crate::{
    alternation::Goal,
    handle_space::HandleSpace,
    reference::{HandleShapes, RestShape, Seen},
};

/// The least share of the closeness to the pose that a handle is taken to have, relative to the mean of handles, so that one
/// that moves nothing has a map as well.
const MIN_SHARE: f64 = 1e-6;

/// Handles on a surface at rest.
#[derive(Clone, Debug)]
pub(crate) struct Handles {
    pub rest: Arc<RestShape>,
    pub space: HandleSpace,
    shapes: HandleShapes,
    /// The diagonal of D, #V: how strongly each vertex is drawn to the pose.
    pub closeness: Vec<f64>,
    /// ρ, 4h: how strongly maps are drawn to rigid motions.
    pub ridge: DVector<f64>,
}

impl Handles {
    /// # Errors
    ///
    /// The errors of [`HandleSpace::new`].
    pub(crate) fn new(
        rest: &Arc<RestShape>,
        weights: &HandleWeights,
        closeness: Vec<f64>,
        regularisation: f64,
    ) -> Result<Self> {
        let space = HandleSpace::new(&rest.positions, weights)?;
        let shapes = HandleShapes::new(&space, &closeness, &weights.matrix, &rest.positions);
        let square = |column: &[f64]| column.iter().zip(&closeness).map(|(w, d)| d * w * w).sum::<f64>();
        let shares: Vec<f64> = weights.matrix.as_slice().chunks_exact(rest.positions.len()).map(square).collect();
        let least = MIN_SHARE * shares.iter().sum::<f64>() / shares.len() as f64;
        let ridge = DVector::from_fn(space.size(), |i, _| regularisation * shares[i / 4].max(least));
        Ok(Self { rest: rest.clone(), space, shapes, closeness, ridge })
    }

    /// The pose without the rigid motion of the whole, and what maps should come near.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] if `posed` is not #V long, [`Error::Data`] if it is not finite.
    pub(crate) fn see(&self, posed: &[Point3<f64>]) -> Result<(Seen, Goal)> {
        Error::check_shape("posed vertices (#V)", self.closeness.len(), posed.len())?;
        check_finite(posed)?;
        let seen = self.rest.see(posed);
        let projected = self.space.project(&self.closeness, &seen.displacements);
        let constant = self.closeness.iter().zip(&seen.displacements).map(|(d, x)| d * x.norm_squared()).sum();
        let reference = self.shapes.rigid(&self.space, &projected);
        Ok((seen, Goal { projected, constant, reference }))
    }

    /// The fit with maps X, with the mean and largest distance to the pose in percent of the rest diagonal.
    pub(crate) fn fit(&self, seen: &Seen, maps: &DMatrix<f64>) -> Fit {
        let displacements = self.space.displacements(maps);
        let (mut sum, mut largest) = (0.0, 0f64);
        for (found, wanted) in displacements.iter().zip(&seen.displacements) {
            let distance = (found - wanted).norm();
            sum += distance;
            largest = largest.max(distance);
        }
        let positions = self.rest.positions.iter().zip(&displacements).map(|(p, d)| seen.forth(&(p + d))).collect();
        let transforms = (0..self.space.centres.len()).map(|k| {
            let (linear, shift) = seen.after(self.space.map(maps, k));
            Matrix3x4::from_columns(&[linear.column(0), linear.column(1), linear.column(2), shift.column(0)])
        });
        let mut figures = Figures::default();
        let percent = 100.0 / self.rest.diagonal.max(f64::MIN_POSITIVE);
        figures.set("mean_distance_percent", percent * sum / displacements.len().max(1) as f64);
        figures.set("largest_distance_percent", percent * largest);
        Fit { transforms: transforms.collect(), positions, figures }
    }
}
