use std::fmt::Debug;

use super::{TransferPair, TriangleMap, Work};
use crate::Result;

/// Finds for each target triangle the source triangle that it moves like.
///
/// A setting that names a file carries `#[schemars(extend("x-file" = true))]`: the pipeline makes its path relative to the current
/// folder, checks that the file is there, and puts the hash of its contents into the keys of cached results. This holds for every kind
/// of stage.
///
/// # Contract
///
/// `testkit::contracts` holds implementations to this:
/// - the map has one entry a target triangle and names existing source triangles;
/// - a surface paired with itself (every tenth vertex a marker) gives each triangle itself, or one within an edge;
/// - equal inputs give equal maps, on one thread or many.
#[typetag::serde(tag = "type")]
pub trait Correspondence: Debug + Send + Sync {
    /// The map for the rest surfaces of `pair`.
    ///
    /// # Errors
    ///
    /// If the markers or the surfaces do not do for this method.
    fn correspond(&self, pair: TransferPair<'_>) -> Result<TriangleMap>;

    /// [`correspond`](Self::correspond), for methods that take long: they report to `work` how much is done.
    ///
    /// # Errors
    ///
    /// The errors of [`correspond`](Self::correspond).
    fn correspond_watched(&self, pair: TransferPair<'_>, _work: Work<'_>) -> Result<TriangleMap> {
        self.correspond(pair)
    }

    /// Looks for what [`correspond`](Self::correspond) would refuse, as far as that takes little time, so that a pipeline can be
    /// checked without computing.
    ///
    /// # Errors
    ///
    /// The errors of [`correspond`](Self::correspond).
    fn check(&self, _pair: TransferPair<'_>) -> Result<()> {
        Ok(())
    }

    /// How many markers this method needs, so that a pipeline can be checked without computing.
    fn markers_needed(&self) -> usize {
        0
    }
}

crate::stage_kind!(Correspondence, "correspondence");
