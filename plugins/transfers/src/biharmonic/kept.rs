//! The transfer while markers come and go: factors and the motion of the source are kept, and one marker that moves costs a solve on its
//! surface.
//!
//! It departs from binding anew in the regions of the source, which stay as long as the number of markers does. That shows in details
//! that a moving picture hides.

use std::sync::Arc;

use mimesh_core::{
    Result,
    mesh::{Surface, SurfacePoint},
    spatial::{Orientation, Similarity},
    stage::{
        BindInput, BoundClusterer, BoundDeformer, BoundTransfer, HandleWeights, KeptTransfer, KeptWeights, Regions,
        TransferPair,
    },
};

use super::{Biharmonic, Bound, Frame, Reconstruction, integral::Integral, places, residual::Residual};
use crate::poisson::Poisson;

/// What does not depend on markers.
#[derive(Debug)]
pub(super) struct Kept {
    weights: [Box<dyn KeptWeights>; 2],
    clusterer: Box<dyn BoundClusterer>,
    deformer: Box<dyn BoundDeformer>,
    /// The system of the target in its own frame; `None` where blends are taken as they are.
    poisson: Option<Arc<Poisson>>,
    frame: Frame,
    orientation: Orientation,
    residual: bool,
    /// The regions of the last markers, with their number.
    regions: Option<(usize, Regions)>,
}

impl Kept {
    /// What `settings` keep of the surfaces and poses of `input`; `None` where the weights keep nothing.
    pub(super) fn new(settings: &Biharmonic, input: BindInput<'_>) -> Result<Option<Self>> {
        let (weights, clusterer, deformer) = settings.stages()?;
        let TransferPair { source, target, proximity, .. } = input.pair;
        let links = match &settings.source_proximity {
            Some(proximity) if source.components().count() > 1 => Some(proximity.proximity(source)?),
            _ => None,
        };
        let (of_source, of_target) =
            rayon::join(|| weights.keep(source, links.as_ref()), || weights.keep(target, proximity));
        let (Some(of_source), Some(of_target)) = (of_source?, of_target?) else { return Ok(None) };
        let poisson = match settings.reconstruction {
            Reconstruction::Blend => None,
            Reconstruction::Gradients => Some(Arc::new(Poisson::new(target, |area| area)?)),
        };
        Ok(Some(Self {
            weights: [of_source, of_target],
            clusterer: clusterer.bind(source, input.poses)?,
            deformer: deformer.bind(source)?,
            poisson,
            frame: settings.frame,
            orientation: settings.orientation,
            residual: settings.residual,
            regions: None,
        }))
    }

    fn regions(&mut self, weights: &HandleWeights) -> Result<Regions> {
        let count = weights.matrix.ncols();
        if let Some((_, regions)) = self.regions.as_ref().filter(|(of, _)| *of == count) {
            return Ok(regions.clone());
        }
        let regions = self.clusterer.cluster(&weights.matrix)?;
        self.regions = Some((count, regions.clone()));
        Ok(regions)
    }
}

impl KeptTransfer for Kept {
    fn bind(&mut self, pair: TransferPair<'_>) -> Result<Box<dyn BoundTransfer>> {
        pair.check_markers()?;
        let points: [Vec<SurfacePoint>; 2] =
            [pair.markers.iter().map(|m| m.source).collect(), pair.markers.iter().map(|m| m.target).collect()];
        let [on_source, on_target] = &mut self.weights;
        let (of_source, of_target) = rayon::join(|| on_source.solve(&points[0]), || on_target.solve(&points[1]));
        let (of_source, of_target) = (of_source?, of_target?);
        let regions = self.regions(&of_source)?;
        let skin = self.deformer.skin(&of_source, &regions)?;
        let target_from_source = match self.frame {
            Frame::Source => Similarity::IDENTITY,
            Frame::Fitted => Biharmonic::similarity(pair, self.orientation),
        };
        let in_source = target_from_source.inverse();
        let rest = pair.target.positions.iter().map(|x| in_source.apply(x)).collect();
        let target = Surface { positions: rest, ..pair.target.clone() };
        let places = places(pair, &of_target, &target.positions, &in_source);
        let residual = self.residual.then(|| Residual::new(pair.source, &target, &places)).transpose()?;
        let (places, integral) = match &self.poisson {
            None => (target.positions, None),
            Some(poisson) => (places.clone(), Some(Integral::kept(poisson.clone(), in_source, target, places))),
        };
        let figures = of_target.figures.clone();
        Ok(Box::new(Bound { skin, weights: of_target, places, residual, integral, target_from_source, figures }))
    }
}
