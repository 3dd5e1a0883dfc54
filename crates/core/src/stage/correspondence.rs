use std::{fmt::Debug, path::PathBuf};

use super::{TransferPair, TriangleMap};
use crate::Result;

/// Finds for each target triangle the source triangle that it moves like.
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

    /// Looks for what [`correspond`](Self::correspond) would refuse, as far as that takes little time, so that a pipeline can be
    /// checked without computing.
    ///
    /// # Errors
    ///
    /// As [`correspond`](Self::correspond).
    fn check(&self, _pair: TransferPair<'_>) -> Result<()> {
        Ok(())
    }

    /// How many markers this method needs, so that a pipeline can be checked without computing.
    fn markers_needed(&self) -> usize {
        0
    }

    /// Files among the settings; the pipeline makes their paths absolute before use.
    fn files(&mut self) -> Vec<&mut PathBuf> {
        vec![]
    }
}

crate::stage_kind!(Correspondence, "correspondence");
