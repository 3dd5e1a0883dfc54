use std::fmt::Debug;

use nalgebra::Point3;

use super::{TransferPair, TriangleMap, Work};
use crate::{Error, Figures, Result};

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
/// - without a map, `bind` succeeds or refuses as [`needs_correspondence`](Self::needs_correspondence) says;
/// - the bound transfer gives a motion if [`gives_motion`](Self::gives_motion) says so, and only then;
/// - equal inputs give equal results, on one thread or many, in any order of poses, alone or several at once.
#[typetag::serde(tag = "type")]
pub trait Transfer: Debug + Send + Sync {
    /// Prepares the transfer between the rest surfaces of the input's pair.
    ///
    /// # Errors
    ///
    /// If the map is missing where it is needed or does not belong to the surfaces, if a pose has another length than the source,
    /// or if the target is of a kind that this method cannot move.
    fn bind(&self, input: BindInput<'_>) -> Result<Box<dyn BoundTransfer>>;

    /// Prepares for markers that come and go, as while a person moves them: what depends on surfaces and poses alone is done once.
    ///
    /// The markers of the input do not matter. `None`, the default, for transfers that gain nothing by it; [`bind`](Self::bind) then does
    /// it anew each time.
    ///
    /// # Errors
    ///
    /// Those of [`bind`](Self::bind) that do not depend on markers.
    fn keep(&self, _input: BindInput<'_>) -> Result<Option<Box<dyn KeptTransfer>>> {
        Ok(None)
    }

    /// Looks for what [`bind`](Self::bind) would refuse, as far as that takes little time, so that a pipeline can be
    /// checked without computing.
    ///
    /// # Errors
    ///
    /// The errors of [`bind`](Self::bind).
    fn check(&self, _pair: TransferPair<'_>) -> Result<()> {
        Ok(())
    }

    /// Whether [`bind`](Self::bind) needs a map; where not, a pipeline may do without a correspondence.
    fn needs_correspondence(&self) -> bool {
        true
    }

    /// How many markers [`bind`](Self::bind) needs, so that a pipeline can be checked without computing.
    fn markers_needed(&self) -> usize {
        0
    }

    /// Whether the bound transfer gives a [`motion`](BoundTransfer::motion), so that a run can be split into frames, or refused,
    /// before anything is computed.
    fn gives_motion(&self) -> bool {
        false
    }

    /// How many poses of the source [`bind`](Self::bind) wants to see; they are held in memory together.
    fn poses_wanted(&self) -> usize {
        0
    }
}

/// The rest surfaces that a transfer is bound to, and what is known of them.
#[derive(Clone, Copy, Debug)]
pub struct BindInput<'a> {
    /// The rest surfaces with their markers and the proximity of the target's components.
    pub pair: TransferPair<'a>,
    /// Where on the source each triangle of the target takes its motion from; `None` if there is no correspondence.
    pub map: Option<&'a TriangleMap>,
    /// Poses of the source, #V of the source each: at most as many as [`poses_wanted`](Transfer::poses_wanted), evenly spread
    /// over all of them. Empty if there are none to see.
    pub poses: &'a [Vec<Point3<f64>>],
    /// Where a transfer that takes long to bind reports how much is done.
    pub work: Work<'a>,
}

impl<'a> BindInput<'a> {
    /// The input along `map`, without poses; nobody waits.
    pub fn new(pair: TransferPair<'a>, map: &'a TriangleMap) -> Self {
        Self { pair, map: Some(map), poses: &[], work: Work::UNWATCHED }
    }

    /// The map, for transfers that cannot do without one.
    ///
    /// # Errors
    ///
    /// [`Error::Data`] if there is none, and those of [`TriangleMap::check`].
    pub fn require_map(&self) -> Result<&'a TriangleMap> {
        let map = self.map.ok_or_else(|| {
            Error::data(
                "the transfer needs a `correspondence`, and there is none",
                "add e.g. `correspondence: { type: nonrigid_fit }` to the pipeline",
            )
        })?;
        map.check(self.pair)?;
        Ok(map)
    }
}

/// A transfer between two rest surfaces whose markers come and go.
pub trait KeptTransfer: Debug + Send {
    /// The transfer by the markers of `pair`, which has the surfaces that this was made with; about as [`Transfer::bind`] gives it.
    ///
    /// # Errors
    ///
    /// Those of [`Transfer::bind`].
    fn bind(&mut self, pair: TransferPair<'_>) -> Result<Box<dyn BoundTransfer>>;
}

/// A transfer bound to a pair of rest surfaces.
pub trait BoundTransfer: Debug + Send + Sync {
    /// The target when the source is at `posed` (#V of the source).
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] if `posed` has another length; [`Error::Data`] if it is not finite.
    fn transfer(&self, posed: &[Point3<f64>]) -> Result<Transferred>;

    /// How many poses [`transfer_all`](Self::transfer_all) takes best: 1, the default, for transfers that gain nothing by several.
    fn at_once(&self) -> usize {
        1
    }

    /// The memory in bytes that so many poses take at once while they are transferred, beside the source's and the target's vertices;
    /// 0, the default, where that is little.
    fn bytes(&self, _poses: usize) -> u64 {
        0
    }

    /// [`transfer`](Self::transfer) for each of `poses`, for transfers that do several in less time. No result depends on the other
    /// poses, not in its last bit.
    fn transfer_all(&self, poses: &[&[Point3<f64>]]) -> Vec<Result<Transferred>> {
        poses.iter().map(|posed| self.transfer(posed)).collect()
    }

    /// A fresh start of a motion, for transfers that take poses as frames of one motion, each found from those before; `None`,
    /// the default, for transfers whose poses stand alone.
    fn motion(&self) -> Option<Box<dyn Motion + '_>> {
        None
    }

    /// The report of binding.
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
    /// The errors of [`BoundTransfer::transfer`]; the motion can go on with the frame after.
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
