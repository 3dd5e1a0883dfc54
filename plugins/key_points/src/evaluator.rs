//! How far the poses are missed.

use std::borrow::Cow;

use mimesh_core::{
    Error, Result,
    stage::{BoundClusterer, BoundDeformer, BoundWeights, HandleWeights},
};
use nalgebra::Point3;

use crate::measure::Measure;

/// Half the longest way across the bounding box's centre: the radius that scales the source into the unit sphere.
pub fn unit_radius(positions: &[Point3<f64>]) -> f64 {
    let mut low = positions[0];
    let mut high = positions[0];
    for p in positions {
        low = low.inf(p);
        high = high.sup(p);
    }
    let centre = nalgebra::center(&low, &high);
    let radius = positions.iter().map(|p| (p - centre).norm()).fold(0.0, f64::max);
    if radius > 0.0 { radius } else { 1.0 }
}

/// A surface with its poses, bound to what fits handles to them.
pub struct Ground<'a> {
    pub regions: Box<dyn BoundClusterer>,
    pub deformer: Box<dyn BoundDeformer>,
    pub poses: Cow<'a, [Vec<Point3<f64>>]>,
    /// How much each vertex counts, if not all alike.
    pub counts: Option<Vec<f64>>,
}

/// Tells how far the poses are missed with a set of candidates as handles.
pub struct Evaluator<'a> {
    pub weights: Box<dyn BoundWeights>,
    pub ground: &'a Ground<'a>,
    pub measure: Measure,
    pub unit: f64,
}

impl Evaluator<'_> {
    pub fn error(&self, handles: &[usize]) -> Result<f64> {
        self.error_of(&self.weights.solve(handles)?)
    }

    /// The error with weights that are known.
    pub fn error_of(&self, weights: &HandleWeights) -> Result<f64> {
        let Ground { regions, deformer, poses, counts } = self.ground;
        let skin = deformer.skin(weights, &regions.cluster(&weights.matrix)?)?;
        let total = poses.iter().map(|pose| Ok(self.measured(&skin.fit(pose)?.positions, pose, counts.as_deref())));
        let error = total.sum::<Result<f64>>()? / poses.len() as f64 / self.unit;
        if error.is_finite() {
            Ok(error)
        } else {
            Err(Error::data("the poses give no finite error", "look for vertices that are not finite in the poses"))
        }
    }

    /// How far `fit` misses `pose`.
    fn measured(&self, fit: &[Point3<f64>], pose: &[Point3<f64>], counts: Option<&[f64]>) -> f64 {
        let of_distance = |(q, p): (&Point3<f64>, &Point3<f64>)| match self.measure {
            Measure::Mean => (q - p).norm(),
            Measure::Frobenius => (q - p).norm_squared(),
        };
        let each = fit.iter().zip(pose).map(of_distance);
        let (sum, count) = match counts {
            None => (each.sum::<f64>(), pose.len() as f64),
            Some(counts) => (each.zip(counts).map(|(d, c)| c * d).sum(), counts.iter().sum()),
        };
        match self.measure {
            Measure::Mean => sum / count,
            Measure::Frobenius => sum.sqrt() / count,
        }
    }
}
