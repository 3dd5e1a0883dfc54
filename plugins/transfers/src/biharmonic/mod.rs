//! Moves the target by a few handles, whose maps are found on the source.
//!
//! Yang et al. 2018, sections 3.2 to 3.4 and 3.6. The markers are handles of both surfaces, with weights W on each. For a pose
//! of the source its deformer finds the affine maps T of the handles that bring it closest to the pose; the target takes
//! qᵢ = Σₖ Wᵢₖ Tₖ [xᵢ; 1] (eq. 2).
//!
//! Departures: T acts in the source's own frame, and so would move a target that is elsewhere, turned or of another size the
//! wrong distance. A similarity is fitted from the markers, the target brought into the source's frame by it, moved, and
//! brought back (`frame: source` for the paper, which moves the target where it is).
//!
//! A target of other proportions than the source has its joints elsewhere, and maps that turn about the source's joints tear
//! at them. So the blend is not taken at the target's vertices x but at y = x − Σₖ Wᵢₖ oₖ, where o are the ways from the source's
//! handles to the target's: at about the points of the source that correspond. The target takes the deformation gradients
//! from y to the blend, integrated over its own surface (`reconstruction: blend` for the paper). Where source and target have
//! the same shape, both are the same.
//!
//! The maps leave something of the source's pose: r(p) from where they bring its point p to where it is. The target takes that
//! too, from the source's points closest to y (`residual: false` for the paper).

mod integral;
mod kept;
mod residual;

use std::sync::Arc;

use mimesh_core::{
    Error, Figures, Result,
    mesh::{Surface, SurfacePoint, check_finite},
    operators::linear_blend,
    plugin::{check_ranges, instance, nested},
    register,
    spatial::{Orientation, Similarity},
    stage::{
        BindInput, BoundTransfer, Clusterer, Deformer, Fit, HandleWeights, KeptTransfer, Marker, Proximity, Skin,
        Transfer, TransferPair, Transferred, Weights, Work,
    },
};
use nalgebra::Point3;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use tracing::debug_span;

use integral::{Integral, Pose};
use kept::Kept;
use residual::{Residual, Search};

use crate::alignment::by_markers;

register!(Transfer: Biharmonic);

/// Fewer handles fix no place in space.
const MIN_MARKERS: usize = 3;

/// The part of weights that goes to binding.
const BINDING: f64 = 0.05;

/// What comes after weights costs, in weights of the source.
const REST: f64 = 0.2;

/// Moves the target by a few handles, whose maps are found on the source (Yang et al. 2018).
///
/// Needs a dozen markers or more, at key points; no correspondence.
#[derive(Debug, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Biharmonic {
    /// How the influence of handles spreads over both surfaces.
    pub weights: Option<Box<dyn Weights>>,
    /// Links between the components of a source of several, so that not each needs a marker; `null` for none. (The target's
    /// are linked by the `proximity` of the pipeline.)
    pub source_proximity: Option<Box<dyn Proximity>>,
    /// How the source is divided into regions that move about rigidly.
    pub clusterer: Option<Box<dyn Clusterer>>,
    /// How the maps of the handles are found.
    pub deformer: Option<Box<dyn Deformer>>,
    /// The place at which the maps act.
    pub frame: Frame,
    /// How source and target are turned to each other at rest.
    pub orientation: Orientation,
    /// How the maps become positions.
    pub reconstruction: Reconstruction,
    /// Whether the target also takes what the maps leave of the source's pose, at the corresponding places; not in the paper.
    pub residual: bool,
    /// Most poses that the regions are learned from; they are held in memory together.
    #[schemars(range(min = 1))]
    pub learn_from: usize,
}

/// The place at which the maps that were found on the source act on the target.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Frame {
    /// The place to which a similarity that fits the markers brings it.
    #[default]
    Fitted,
    /// The target's own place, as in the paper: for targets that lie on the source.
    Source,
}

/// How the maps of the handles become positions of the target.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Reconstruction {
    /// The gradients of the blend at corresponding places of the source, integrated over the target: limbs turn about the
    /// target's own joints.
    #[default]
    Gradients,
    /// The blend at the target's own vertices, as in the paper (eq. 2): limbs turn about the source's joints.
    Blend,
}

impl Default for Biharmonic {
    fn default() -> Self {
        Self {
            weights: instance("bounded_biharmonic"),
            source_proximity: instance("spanning_tree"),
            clusterer: instance("rotation_kmeans"),
            deformer: instance("arap_skinning"),
            frame: Frame::Fitted,
            orientation: Orientation::Auto,
            reconstruction: Reconstruction::Gradients,
            residual: true,
            learn_from: 32,
        }
    }
}

#[typetag::serde(name = "biharmonic")]
impl Transfer for Biharmonic {
    fn needs_correspondence(&self) -> bool {
        false
    }

    fn markers_needed(&self) -> usize {
        MIN_MARKERS
    }

    fn poses_wanted(&self) -> usize {
        self.learn_from
    }

    fn bind(&self, input: BindInput<'_>) -> Result<Box<dyn BoundTransfer>> {
        let pair = input.pair;
        self.check(pair)?;
        let (weights, clusterer, deformer) = self.stages()?;
        let handles: Vec<usize> = (0..pair.markers.len()).collect();
        // Weights take nearly all of the time, and about as long a vertex on either surface.
        let cost = |surface: &Surface| surface.vertex_count() as f64;
        let [on_source, on_target, rest] =
            input.work.parts([cost(pair.source), cost(pair.target), REST * cost(pair.source)]);
        let solve = |side: &str, work: Work<'_>, surface: &Surface, points: Vec<SurfacePoint>, proximity| {
            let named = |error: Error| match error {
                Error::Data { message, hint } => {
                    let which = if message.starts_with("point") { " (markers, counted from 0)" } else { "" };
                    Error::Data { message: format!("handles on the {side}{which}: {message}"), hint }
                }
                other => other,
            };
            let span = debug_span!("weights", "type" = weights.typetag_name(), side);
            span.in_scope(|| {
                let bound = weights.bind(surface, &points, proximity)?;
                work.done(BINDING);
                bound.solve_watched(&handles, work.part(BINDING, 1.0))
            })
            .map_err(named)
        };
        let links = match &self.source_proximity {
            Some(proximity) if pair.source.components().count() > 1 => Some(proximity.proximity(pair.source)?),
            _ => None,
        };
        let points = pair.markers.iter().map(|m| m.source).collect();
        let of_source = solve("source", on_source, pair.source, points, links.as_ref())?;
        let points = pair.markers.iter().map(|m| m.target).collect();
        let of_target = solve("target", on_target, pair.target, points, pair.proximity)?;
        let regions = debug_span!("clusterer", "type" = clusterer.typetag_name())
            .in_scope(|| clusterer.bind(pair.source, input.poses)?.cluster(&of_source.matrix))?;
        rest.done(0.5);
        let skin = debug_span!("deformer", "type" = deformer.typetag_name())
            .in_scope(|| deformer.bind(pair.source)?.skin(&of_source, &regions))?;

        let target_from_source = match self.frame {
            Frame::Source => Similarity::IDENTITY,
            Frame::Fitted => Self::similarity(pair, self.orientation),
        };
        let mut figures = Figures::default();
        figures.set("handles", handles.len());
        figures.set("regions", regions.count);
        if self.frame == Frame::Fitted {
            figures.set("size_ratio", target_from_source.scale);
            if let Some(oriented) = by_markers(pair, self.orientation) {
                figures.set("orientation", oriented.taken.name());
                figures.set("fitted_degrees_from_axes", oriented.degrees_from_axes);
            }
        }
        for (side, found) in [("source", &of_source.figures), ("target", &of_target.figures)] {
            found.values.iter().for_each(|(name, value)| figures.set(&format!("{side}_{name}"), value.clone()));
            figures.warnings.extend(found.warnings.iter().map(|warning| format!("{side}: {warning}")));
        }
        let in_source = target_from_source.inverse();
        let rest = pair.target.positions.iter().map(|x| in_source.apply(x)).collect();
        let target = Surface { positions: rest, ..pair.target.clone() };
        let places = places(pair, &of_target, &target.positions, &in_source);
        let search = self.residual.then(|| Search::new(pair.source)).transpose()?;
        let residual = search.map(|search| Arc::new(Residual::new(&search, &target, &places)));
        let (places, integral) = match self.reconstruction {
            Reconstruction::Blend => (target.positions, None),
            Reconstruction::Gradients => (places.clone(), Some(Integral::new(target, places)?)),
        };
        Ok(Box::new(Bound { skin, weights: of_target, places, residual, integral, target_from_source, figures }))
    }

    fn keep(&self, input: BindInput<'_>) -> Result<Option<Box<dyn KeptTransfer>>> {
        Ok(Kept::new(self, input)?.map(|kept| Box::new(kept) as Box<dyn KeptTransfer>))
    }

    fn check(&self, pair: TransferPair<'_>) -> Result<()> {
        check_ranges(self)?;
        self.stages()?;
        if pair.markers.len() < MIN_MARKERS {
            return Err(Error::data(
                format!("biharmonic transfer needs at least {MIN_MARKERS} markers, there are {}", pair.markers.len()),
                "`mimesh keypoints PIPELINE` chooses points on the source; find their partners on the target",
            ));
        }
        pair.check_markers()
    }
}

impl Biharmonic {
    fn stages(&self) -> Result<(&dyn Weights, &dyn Clusterer, &dyn Deformer)> {
        Ok((
            nested("weights", &self.weights, "bounded_biharmonic")?,
            nested("clusterer", &self.clusterer, "rotation_kmeans")?,
            nested("deformer", &self.deformer, "arap_skinning")?,
        ))
    }

    /// The similarity that brings the source's markers closest to the target's, turned as `orientation` says.
    fn similarity(pair: TransferPair<'_>, orientation: Orientation) -> Similarity {
        let source: Vec<_> =
            pair.markers.iter().map(|m| m.source.position(pair.source, &pair.source.positions)).collect();
        let target: Vec<_> =
            pair.markers.iter().map(|m| m.target.position(pair.target, &pair.target.positions)).collect();
        Similarity::fit(&source, &target, &vec![1.0; source.len()], orientation)
    }
}

/// y: the target's vertices, at `rest` in the source's frame, less the ways from the source's handles to the target's.
fn places(
    pair: TransferPair<'_>,
    weights: &HandleWeights,
    rest: &[Point3<f64>],
    in_source: &Similarity,
) -> Vec<Point3<f64>> {
    let offset = |marker: &Marker| {
        let on_target = in_source.apply(&marker.target.position(pair.target, &pair.target.positions));
        on_target - marker.source.position(pair.source, &pair.source.positions)
    };
    let mut places = rest.to_vec();
    for (column, marker) in weights.matrix.column_iter().zip(pair.markers) {
        let offset = offset(marker);
        places.iter_mut().zip(column.iter()).for_each(|(y, w)| *y -= offset * *w);
    }
    places
}

#[derive(Debug)]
struct Bound {
    skin: Box<dyn Skin>,
    /// W of the target.
    weights: HandleWeights,
    /// Where the maps act on the target's vertices, in the source's frame: y, or the vertices themselves.
    places: Vec<Point3<f64>>,
    residual: Option<Arc<Residual>>,
    integral: Option<Integral>,
    target_from_source: Similarity,
    figures: Figures,
}

impl BoundTransfer for Bound {
    fn transfer(&self, posed: &[Point3<f64>]) -> Result<Transferred> {
        self.transfer_all(&[posed]).pop().expect("one pose has one result")
    }

    fn at_once(&self) -> usize {
        self.integral.as_ref().map_or(1, Integral::at_once)
    }

    fn transfer_all(&self, poses: &[&[Point3<f64>]]) -> Vec<Result<Transferred>> {
        let blends: Vec<Result<(Fit, Vec<Point3<f64>>)>> = poses.par_iter().map(|posed| self.blend(posed)).collect();
        let Some(integral) = &self.integral else {
            return blends.into_iter().map(|blend| blend.and_then(|(fit, moved)| self.placed(fit, &moved))).collect();
        };
        let sound: Vec<Pose<'_>> =
            blends.iter().flatten().map(|(fit, blend)| Pose { transforms: &fit.transforms, blend }).collect();
        let mut moved = integral.positions(&self.weights.matrix, &sound).into_iter();
        let transferred = |blend: Result<(Fit, Vec<Point3<f64>>)>| {
            let (fit, _) = blend?;
            self.placed(fit, &moved.next().expect("each pose has positions")?)
        };
        blends.into_iter().map(transferred).collect()
    }

    fn figures(&self) -> Figures {
        self.figures.clone()
    }
}

impl Bound {
    /// The maps of the handles for a pose of the source, and where they bring the target's places, with the residual.
    fn blend(&self, posed: &[Point3<f64>]) -> Result<(Fit, Vec<Point3<f64>>)> {
        let fit = self.skin.fit(posed)?;
        let mut moved = linear_blend(&self.weights.matrix, &fit.transforms, &self.places)?;
        if let Some(residual) = &self.residual {
            residual.add(posed, &fit.positions, &mut moved);
        }
        Ok((fit, moved))
    }

    /// The target where `moved` has it in the source's frame.
    fn placed(&self, fit: Fit, moved: &[Point3<f64>]) -> Result<Transferred> {
        let positions: Vec<_> = moved.iter().map(|q| self.target_from_source.apply(q)).collect();
        check_finite(&positions)?;
        Ok(Transferred { positions, figures: fit.figures })
    }
}
