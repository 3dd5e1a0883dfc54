use std::fmt::Debug;

use crate::{
    Result,
    mesh::{Surface, SurfacePoint},
};

/// Spreads points over a surface.
///
/// # Contract
///
/// `testkit::contracts` holds implementations to this:
/// - points exist on the surface, and no two are the same;
/// - every component with area has one, where the settings allow as many;
/// - equal inputs give equal points, on one thread or many.
#[typetag::serde(tag = "type")]
pub trait Sampler: Debug + Send + Sync {
    /// Points of `surface`.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`](crate::Error::Setting) for settings out of range, [`Error::Data`](crate::Error::Data) for a surface
    /// that has no such points.
    fn sample(&self, surface: &Surface) -> Result<Vec<SurfacePoint>>;

    /// As many points as the settings ask for, or all that `surface` offers where these are fewer.
    ///
    /// By default these are the points of [`sample`](Self::sample), which may refuse a surface that offers too few.
    ///
    /// # Errors
    ///
    /// Those of [`sample`](Self::sample).
    fn sample_available(&self, surface: &Surface) -> Result<AvailablePoints> {
        let points = self.sample(surface)?;
        Ok(AvailablePoints { asked: points.len(), points })
    }
}

/// The points that a surface offers to a [`Sampler`].
#[derive(Clone, Debug, PartialEq)]
pub struct AvailablePoints {
    /// The points, at most `asked`.
    pub points: Vec<SurfacePoint>,
    /// How many points the settings ask for.
    pub asked: usize,
}

crate::stage_kind!(Sampler, "sampler");
