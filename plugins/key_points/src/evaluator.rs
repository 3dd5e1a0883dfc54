//! How far the poses are missed.

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

/// Tells how far the poses are missed with a set of candidates as handles.
pub struct Evaluator<'a> {
    pub weights: Box<dyn BoundWeights>,
    pub regions: &'a dyn BoundClusterer,
    pub deformer: &'a dyn BoundDeformer,
    pub poses: &'a [Vec<Point3<f64>>],
    pub measure: Measure,
    pub unit: f64,
}

impl Evaluator<'_> {
    pub fn error(&self, handles: &[usize]) -> Result<f64> {
        self.error_of(&self.weights.solve(handles)?)
    }

    /// The error with weights that are known.
    pub fn error_of(&self, weights: &HandleWeights) -> Result<f64> {
        let regions = self.regions.cluster(&weights.matrix)?;
        let skin = self.deformer.skin(weights, &regions)?;
        let mut total = 0.0;
        for pose in self.poses {
            let fit = skin.fit(pose)?;
            let distances = fit.positions.iter().zip(pose).map(|(q, p)| (q - p).norm());
            let count = pose.len() as f64;
            total += match self.measure {
                Measure::Mean => distances.sum::<f64>() / count,
                Measure::Frobenius => distances.map(|d| d * d).sum::<f64>().sqrt() / count,
            };
        }
        let error = total / self.poses.len() as f64 / self.unit;
        if error.is_finite() {
            Ok(error)
        } else {
            Err(Error::data("the poses give no finite error", "look for vertices that are not finite in the poses"))
        }
    }
}
