use std::fmt::Debug;

use nalgebra::Point3;

use super::{TransferPair, TriangleMap};
use crate::{Figures, Result};

/// Moves the target as the source moves.
///
/// [`bind`](Self::bind) does once what depends on the rest surfaces; the [`BoundTransfer`] then serves every pose.
///
/// # Contract
///
/// `testkit::contracts` holds implementations to this:
/// - the source at rest gives the target at rest;
/// - one rigid motion of the source moves a target of the same shape and place by it;
/// - results are finite and have #V of the target entries;
/// - equal inputs give equal results, on one thread or many, in any order of poses.
#[typetag::serde(tag = "type")]
pub trait Transfer: Debug + Send + Sync {
    /// Prepares the transfer between the rest surfaces of `pair` along `map`.
    ///
    /// # Errors
    ///
    /// If `map` does not belong to the surfaces, or the target is of a kind that this method cannot move.
    fn bind(&self, pair: TransferPair<'_>, map: &TriangleMap) -> Result<Box<dyn BoundTransfer>>;

    /// Looks for what [`bind`](Self::bind) would refuse, as far as that takes little time, so that a pipeline can be
    /// checked without computing.
    ///
    /// # Errors
    ///
    /// As [`bind`](Self::bind).
    fn check(&self, _pair: TransferPair<'_>) -> Result<()> {
        Ok(())
    }

    /// Whether [`bind`](Self::bind) looks at its map; where not, a pipeline may do without a correspondence.
    fn needs_correspondence(&self) -> bool {
        true
    }

    /// How many poses of the source [`bind_to_poses`](Self::bind_to_poses) wants to see; they are held in memory together.
    fn poses_wanted(&self) -> usize {
        0
    }

    /// As [`bind`](Self::bind), having seen `poses` of the source (each #V): at most as many as wanted, spread over all.
    ///
    /// # Errors
    ///
    /// As [`bind`](Self::bind), and if a pose has another length.
    fn bind_to_poses(
        &self,
        pair: TransferPair<'_>,
        map: &TriangleMap,
        _poses: &[Vec<Point3<f64>>],
    ) -> Result<Box<dyn BoundTransfer>> {
        self.bind(pair, map)
    }
}

/// A transfer bound to a pair of rest surfaces.
pub trait BoundTransfer: Debug + Send + Sync {
    /// The target when the source is at `posed` (#V of the source).
    ///
    /// # Errors
    ///
    /// [`Error::Shape`](crate::Error::Shape) if `posed` has another length; [`Error::Data`](crate::Error::Data) if it is
    /// not finite.
    fn transfer(&self, posed: &[Point3<f64>]) -> Result<Transferred>;

    /// A fresh start of a motion, for transfers that take poses as frames of one motion, each found from those before; `None`,
    /// the default, for transfers whose poses stand alone.
    fn motion(&self) -> Option<Box<dyn Motion + '_>> {
        None
    }

    /// What was found while binding.
    fn figures(&self) -> Figures;
}

/// A motion under way.
pub trait Motion: Send {
    /// The target at frame `frame` (from 0), when the source is at `posed` (#V of the source).
    ///
    /// Frames are asked for in order, each once; one that could not be read is left out.
    ///
    /// # Errors
    ///
    /// As [`BoundTransfer::transfer`]; the motion can go on with the frame after.
    fn frame(&mut self, frame: usize, posed: &[Point3<f64>]) -> Result<Transferred>;
}

/// A posed target.
#[derive(Clone, Debug, Default)]
pub struct Transferred {
    /// Posed V of the target, #V × 3, in its own unit and place.
    pub positions: Vec<Point3<f64>>,
    /// Energies, residuals and the like of this pose.
    pub figures: Figures,
}

crate::stage_kind!(Transfer, "transfer");
