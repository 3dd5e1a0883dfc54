use std::fmt::Debug;

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::{ProximityGraph, Work};
use crate::{
    Figures, Result,
    mesh::{Surface, SurfacePoint},
};

/// Spreads the influence of handles over a surface.
///
/// [`bind`](Self::bind) does once what depends on the surface and on all points that may become handles; the
/// [`BoundWeights`] then serves any choice of them, as the search for key points needs.
///
/// # Contract
///
/// `testkit::contracts` holds implementations to this:
/// - W is finite and #V × #H, and its rows sum to 1;
/// - at its own point a handle has weight 1 and the others 0;
/// - another order of the handles gives the same columns in that order;
/// - equal inputs give equal weights, on one thread or many, for one choice of handles or several at once.
#[typetag::serde(tag = "type")]
pub trait Weights: Debug + Send + Sync {
    /// Prepares for handles among `points`; where `proximity` is given, influence passes between the components it links.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`](crate::Error::Setting) for settings out of range, [`Error::Data`](crate::Error::Data) for points that
    /// are not on the surface.
    fn bind(
        &self,
        surface: &Surface,
        points: &[SurfacePoint],
        proximity: Option<&ProximityGraph>,
    ) -> Result<Box<dyn BoundWeights>>;

    /// Prepares for handles that come and go, as while a person moves them: what depends on the surface alone is done once.
    ///
    /// `None`, the default, for weights that gain nothing by it; [`bind`](Self::bind) then does it anew each time.
    ///
    /// # Errors
    ///
    /// Those of [`bind`](Self::bind) that do not depend on points.
    fn keep(&self, _surface: &Surface, _proximity: Option<&ProximityGraph>) -> Result<Option<Box<dyn KeptWeights>>> {
        Ok(None)
    }
}

/// Weights of a surface whose handles come and go.
pub trait KeptWeights: Debug + Send {
    /// The weights of handles at `points`, as [`Weights::bind`] and [`BoundWeights::solve`] give them but for rounding.
    ///
    /// # Errors
    ///
    /// Theirs.
    fn solve(&mut self, points: &[SurfacePoint]) -> Result<HandleWeights>;
}

/// Weights bound to a surface and the points that may become handles.
pub trait BoundWeights: Debug + Send + Sync {
    /// The weights of the handles with these indices into the points of [`bind`](Weights::bind).
    ///
    /// # Errors
    ///
    /// [`Error::Data`](crate::Error::Data) if there is no handle, if two are the same or lie on the same vertex, or if a
    /// component is reached by none; it names them.
    fn solve(&self, handles: &[usize]) -> Result<HandleWeights>;

    /// [`solve`](Self::solve), for weights that take long: they report to `work` how much is done.
    ///
    /// # Errors
    ///
    /// The errors of [`solve`](Self::solve).
    fn solve_watched(&self, handles: &[usize], _work: Work<'_>) -> Result<HandleWeights> {
        self.solve(handles)
    }

    /// [`solve`](Self::solve) for each of `choices`, for weights that are cheaper for several at once. The weights of a choice do not
    /// depend on the others, not in their last bit.
    fn solve_all(&self, choices: &[&[usize]]) -> Vec<Result<HandleWeights>> {
        choices.par_iter().map(|handles| self.solve(handles)).collect()
    }

    /// The report of binding.
    fn figures(&self) -> Figures;
}

crate::stage_kind!(Weights, "weights");

/// How much each handle moves each vertex.
#[derive(Clone, Debug)]
pub struct HandleWeights {
    /// W, #V × #H.
    pub matrix: DMatrix<f64>,
    /// Energies, residuals and the like.
    pub figures: Figures,
}
