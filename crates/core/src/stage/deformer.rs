use std::fmt::Debug;

use nalgebra::{Matrix3x4, Point3};

use super::{HandleWeights, Regions};
use crate::{Figures, Result, mesh::Surface};

/// Finds the affine maps of handles that bring a surface closest to a pose.
///
/// [`bind`](Self::bind) does once what depends on the surface, [`skin`](BoundDeformer::skin) what depends on handles, and the
/// [`Skin`] then serves every pose.
///
/// # Contract
///
/// `testkit::contracts` holds implementations to this:
/// - a pose that is one rigid motion is met, by maps that are that motion;
/// - maps are finite, one a handle;
/// - equal inputs give equal maps, on one thread or many.
#[typetag::serde(tag = "type")]
pub trait Deformer: Debug + Send + Sync {
    /// Prepares for handles on `surface`.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`](crate::Error::Setting) for settings out of range.
    fn bind(&self, surface: &Surface) -> Result<Box<dyn BoundDeformer>>;

    /// Prepares for handles on a surface that stands for a finer one: each vertex for as many of its vertices as `counts` (#V) says.
    ///
    /// # Errors
    ///
    /// Those of [`bind`](Self::bind), which it is unless the number of vertices matters to the deformer.
    fn bind_coarse(&self, surface: &Surface, _counts: &[f64]) -> Result<Box<dyn BoundDeformer>> {
        self.bind(surface)
    }
}

/// A deformer bound to a surface.
pub trait BoundDeformer: Debug + Send + Sync {
    /// Prepares for poses with these weights and regions.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`](crate::Error::Shape) if they belong to another surface.
    fn skin(&self, weights: &HandleWeights, regions: &Regions) -> Result<Box<dyn Skin>>;
}

/// A surface with handles.
pub trait Skin: Debug + Send + Sync {
    /// The maps that bring the surface closest to `posed` (#V).
    ///
    /// # Errors
    ///
    /// [`Error::Shape`](crate::Error::Shape) if `posed` has another length, [`Error::Data`](crate::Error::Data) if it is not
    /// finite.
    fn fit(&self, posed: &[Point3<f64>]) -> Result<Fit>;
}

crate::stage_kind!(Deformer, "deformer");

/// The maps of the handles for one pose.
#[derive(Clone, Debug)]
pub struct Fit {
    /// T, one 3 × 4 map a handle: position at rest (with a 1 below) to posed.
    pub transforms: Vec<Matrix3x4<f64>>,
    /// Where T brings the surface, #V.
    pub positions: Vec<Point3<f64>>,
    /// Energies, iterations and the like.
    pub figures: Figures,
}
