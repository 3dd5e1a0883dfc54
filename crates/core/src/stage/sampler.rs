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
}

crate::stage_kind!(Sampler, "sampler");
