//! The transfer while markers come and go: factors and the motion of the source are kept, and one marker that moves costs a solve on its
//! surface.
//!
//! It departs from binding anew in two ways, which show in details that a moving picture hides. The regions of the source stay as long as
//! the number of markers does. The residual is taken from the points that were found when places were last elsewhere.

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

use super::{
    Biharmonic, Bound, Frame, Reconstruction,
    integral::{Integral, Parts},
    places,
    residual::{Residual, Search},
};
use crate::poisson::Poisson;

/// How far a place moves until the point of its residual is looked for again, in diagonals of the source.
const SLACK: f64 = 5e-3;

/// What does not depend on markers.
#[derive(Debug)]
pub(super) struct Kept {
    weights: [Box<dyn KeptWeights>; 2],
    clusterer: Box<dyn BoundClusterer>,
    deformer: Box<dyn BoundDeformer>,
    /// The system of the target in its own frame, and its parts; `None` where blends are taken as they are.
    system: Option<(Arc<Poisson>, Arc<Parts>)>,
    frame: Frame,
    orientation: Orientation,
    /// `None` where the residual is left out.
    search: Option<Search>,
    /// The residual of the last markers.
    residual: Option<Arc<Residual>>,
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
        let system = match settings.reconstruction {
            Reconstruction::Blend => None,
            Reconstruction::Gradients => {
                Some((Arc::new(Poisson::new(target, |area| area)?), Arc::new(Parts::new(target))))
            }
        };
        Ok(Some(Self {
            weights: [of_source, of_target],
            clusterer: clusterer.bind(source, input.poses)?,
            deformer: deformer.bind(source)?,
            system,
            frame: settings.frame,
            orientation: settings.orientation,
            search: settings.residual.then(|| Search::new(source)).transpose()?,
            residual: None,
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
        if let Some(search) = &self.search {
            match self.residual.as_mut().map(Arc::make_mut) {
                Some(residual) => residual.follow(search, &target, &places, SLACK * pair.source.diagonal()),
                None => self.residual = Some(Arc::new(Residual::new(search, &target, &places))),
            }
        }
        let residual = self.residual.clone();
        let (places, integral) = match &self.system {
            None => (target.positions, None),
            Some((poisson, parts)) => {
                let integral = Integral::kept(poisson.clone(), parts.clone(), in_source, target, places.clone());
                (places, Some(integral))
            }
        };
        let figures = of_target.figures.clone();
        Ok(Box::new(Bound { skin, weights: of_target, places, residual, integral, target_from_source, figures }))
    }
}
