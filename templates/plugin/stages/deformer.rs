//! The rigid motion of what each handle moves.
//!
//! The map of handle k is the rotation and translation that bring the surface nearest to the pose in the mean of squares, each
//! vertex counting by its weight Wᵢₖ, and all of them a little besides: that settles what a handle of few vertices leaves open.

use mimesh_core::{
    Error, Figures, Result,
    mesh::{Surface, check_finite},
    operators::linear_blend,
    plugin::check_ranges,
    register,
    spatial::{Orientation, Similarity},
    stage::{BoundDeformer, Deformer, Fit, HandleWeights, Regions, Skin},
};
use nalgebra::{DMatrix, Matrix3x4, Point3, Vector3};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

register!(Deformer: MyStage);

/// Fits a rigid motion to what each handle moves.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct MyStage {
    /// How much all other vertices count for a handle together, relative to its own.
    #[schemars(range(min = 1e-6, max = 1.0))]
    pub whole: f64,
}

impl Default for MyStage {
    fn default() -> Self {
        Self { whole: 1e-3 }
    }
}

#[typetag::serde(name = "my_stage")]
impl Deformer for MyStage {
    // What depends on the surface alone is done here, once: for this method that is nothing.
    fn bind(&self, surface: &Surface) -> Result<Box<dyn BoundDeformer>> {
        check_ranges(self)?;
        Ok(Box::new(Bound { whole: self.whole, rest: surface.positions.clone() }))
    }
}

#[derive(Debug)]
struct Bound {
    whole: f64,
    rest: Vec<Point3<f64>>,
}

impl BoundDeformer for Bound {
    // What depends on handles and regions is done here, once for all poses.
    fn skin(&self, weights: &HandleWeights, regions: &Regions) -> Result<Box<dyn Skin>> {
        let count = self.rest.len();
        regions.check(count)?;
        Error::check_shape("rows of W (#V)", count, weights.matrix.nrows())?;
        let counting = |column: nalgebra::DVectorView<'_, f64>| -> Vec<f64> {
            // Weights below 0 are of vertices that move the other way.
            let own: f64 = column.iter().map(|w| w.max(0.0)).sum();
            let others = if own > 0.0 { self.whole * own / count as f64 } else { 1.0 };
            column.iter().map(|w| w.max(0.0) + others).collect()
        };
        let counts = weights.matrix.column_iter().map(|column| counting(column.as_view())).collect();
        Ok(Box::new(Skinned { rest: self.rest.clone(), weights: weights.matrix.clone(), counts }))
    }
}

#[derive(Debug)]
struct Skinned {
    rest: Vec<Point3<f64>>,
    /// W, #V × #H.
    weights: DMatrix<f64>,
    /// How much each vertex counts for each handle, #H × #V.
    counts: Vec<Vec<f64>>,
}

impl Skin for Skinned {
    // Called for every pose, from many threads.
    fn fit(&self, posed: &[Point3<f64>]) -> Result<Fit> {
        Error::check_shape("posed vertices (#V)", self.rest.len(), posed.len())?;
        check_finite(posed)?;
        let map = |counts: &Vec<f64>| rigid_motion(&self.rest, posed, counts);
        let transforms: Vec<_> = self.counts.par_iter().map(map).collect();
        let positions = linear_blend(&self.weights, &transforms, &self.rest)?;
        Ok(Fit { transforms, positions, figures: Figures::default() })
    }
}

/// [R | t] that brings `from` nearest to `to`, each point counting by its weight.
fn rigid_motion(from: &[Point3<f64>], to: &[Point3<f64>], weights: &[f64]) -> Matrix3x4<f64> {
    let rotation = Similarity::fit(from, to, weights, Orientation::Fitted).rotation;
    let total: f64 = weights.iter().sum();
    let mean =
        |points: &[Point3<f64>]| points.iter().zip(weights).map(|(p, w)| p.coords * *w).sum::<Vector3<f64>>() / total;
    let translation = mean(to) - rotation * mean(from);
    let mut map = Matrix3x4::zeros();
    map.fixed_columns_mut::<3>(0).copy_from(&rotation);
    map.set_column(3, &translation);
    map
}

#[cfg(test)]
mod tests {
    use mimesh_core::testkit::meshes;

    use super::*;

    #[test]
    fn two_halves_that_part_are_two_motions() {
        let surface = meshes::two_components();
        let half = |v: usize| usize::from(v >= 42);
        let matrix = DMatrix::from_fn(84, 2, |v, k| f64::from(u8::from(half(v) == k)));
        let weights = HandleWeights { matrix, figures: Figures::default() };
        let of_vertex = (0..84).map(|v| half(v) as u32).collect();
        let regions = Regions { of_vertex, count: 2, figures: Figures::default() };
        let away = |v: usize| surface.positions[v] + Vector3::x() * if half(v) == 1 { 1.0 } else { 0.0 };
        let posed: Vec<_> = (0..84).map(away).collect();
        let skin = MyStage { whole: 1e-6 }.bind(&surface).unwrap().skin(&weights, &regions).unwrap();
        let fit = skin.fit(&posed).unwrap();
        // The other half counts a millionth.
        assert!(fit.positions.iter().zip(&posed).all(|(p, q)| (p - q).norm() < 1e-5));
    }
}
