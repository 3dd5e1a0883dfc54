//! Moves the target by a few handles, whose maps are found on the source.
//!
//! Yang et al. 2018, sections 3.2 to 3.4 and 3.6. The markers are handles of both surfaces, with weights W on each. For a pose
//! of the source its deformer finds the affine maps T of the handles that bring it closest to the pose; the target takes
//! qᵢ = Σₖ Wᵢₖ Tₖ [xᵢ; 1] (eq. 2).
//!
//! Departures: T acts in the source's own frame, and so would move a target that is elsewhere, turned or of another size the
//! wrong distance. A similarity is fitted from the markers, the target brought into the source's frame by it, moved, and
//! brought back (`frame: source` for the paper, which moves the target where it is).

use mimesh_core::{
    Error, Figures, Result,
    mesh::{Surface, SurfacePoint, check_finite},
    operators::linear_blend,
    plugin::instance,
    register,
    spatial::{Orientation, Similarity},
    stage::{
        BoundTransfer, Clusterer, Deformer, HandleWeights, Pair, Skin, Transfer, Transferred, TriangleMap, Weights,
    },
};
use nalgebra::Point3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

register!(Transfer: Biharmonic);

/// Moves the target by a few handles, whose maps are found on the source (Yang et al. 2018).
///
/// Needs a dozen markers or more, at key points; no correspondence.
#[derive(Debug, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Biharmonic {
    /// How the influence of handles spreads over both surfaces.
    pub weights: Option<Box<dyn Weights>>,
    /// How the source is divided into regions that move about rigidly.
    pub clusterer: Option<Box<dyn Clusterer>>,
    /// How the maps of the handles are found.
    pub deformer: Option<Box<dyn Deformer>>,
    /// Where the maps act.
    pub frame: Frame,
    /// How source and target are turned to each other at rest.
    pub orientation: Orientation,
    /// Most poses that the regions are learned from; they are held in memory together.
    #[schemars(range(min = 1))]
    pub learn_from: usize,
}

/// Where the maps that were found on the source act on the target.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Frame {
    /// Where a similarity that fits the markers brings it.
    #[default]
    Fitted,
    /// Where it is, as in the paper: for targets that lie on the source.
    Source,
}

impl Default for Biharmonic {
    fn default() -> Self {
        Self {
            weights: instance("bounded_biharmonic"),
            clusterer: instance("rotation_kmeans"),
            deformer: instance("arap_skinning"),
            frame: Frame::Fitted,
            orientation: Orientation::Auto,
            learn_from: 32,
        }
    }
}

#[typetag::serde(name = "biharmonic")]
impl Transfer for Biharmonic {
    fn bind(&self, pair: Pair<'_>, map: &TriangleMap) -> Result<Box<dyn BoundTransfer>> {
        self.bind_to_poses(pair, map, &[])
    }

    fn needs_correspondence(&self) -> bool {
        false
    }

    fn poses_wanted(&self) -> usize {
        self.learn_from
    }

    fn bind_to_poses(
        &self,
        pair: Pair<'_>,
        _: &TriangleMap,
        poses: &[Vec<Point3<f64>>],
    ) -> Result<Box<dyn BoundTransfer>> {
        self.check(pair)?;
        let (Some(weights), Some(clusterer), Some(deformer)) = (&self.weights, &self.clusterer, &self.deformer) else {
            return Err(Error::data("a nested stage is missing", "name it"));
        };
        let handles: Vec<usize> = (0..pair.markers.len()).collect();
        let solve = |name: &str, surface: &Surface, points: Vec<SurfacePoint>, proximity| {
            let named = |error: Error| match error {
                Error::Data { message, hint } => Error::Data { message: format!("{name}: {message}"), hint },
                other => other,
            };
            weights.bind(surface, &points, proximity).and_then(|bound| bound.solve(&handles)).map_err(named)
        };
        let of_source = solve("source", pair.source, pair.markers.iter().map(|m| m.source).collect(), None)?;
        let of_target = solve("target", pair.target, pair.markers.iter().map(|m| m.target).collect(), pair.proximity)?;
        let regions = clusterer.bind(pair.source, poses)?.cluster(&of_source.matrix)?;
        let skin = deformer.bind(pair.source)?.skin(&of_source, &regions)?;

        let target_from_source = match self.frame {
            Frame::Source => Similarity::IDENTITY,
            Frame::Fitted => self.similarity(pair),
        };
        let mut figures = Figures::default();
        figures.set("handles", handles.len());
        figures.set("regions", regions.count);
        if self.frame == Frame::Fitted {
            figures.set("size_ratio", target_from_source.scale);
        }
        for (side, found) in [("source", &of_source.figures), ("target", &of_target.figures)] {
            found.values.iter().for_each(|(name, value)| figures.set(&format!("{side}_{name}"), value.clone()));
            figures.warnings.extend(found.warnings.iter().map(|warning| format!("{side}: {warning}")));
        }
        let in_source = target_from_source.inverse();
        let rest = pair.target.positions.iter().map(|x| in_source.apply(x)).collect();
        Ok(Box::new(Bound { skin, weights: of_target, rest, target_from_source, figures }))
    }

    fn check(&self, pair: Pair<'_>) -> Result<()> {
        Error::check_setting("learn_from", self.learn_from as f64, 1.0, f64::INFINITY)?;
        for (slot, is_there, example) in [
            ("weights", self.weights.is_some(), "bounded_biharmonic"),
            ("clusterer", self.clusterer.is_some(), "rotation_kmeans"),
            ("deformer", self.deformer.is_some(), "arap_skinning"),
        ] {
            if !is_there {
                return Err(Error::data(
                    format!("`{slot}` is left out, and its default `{example}` is not linked into this program"),
                    format!("say which, e.g. `{slot}: {{ type: … }}`, or link the crate with `{example}`"),
                ));
            }
        }
        if pair.markers.len() < 3 {
            return Err(Error::data(
                format!("biharmonic transfer needs at least 3 markers, there are {}", pair.markers.len()),
                "`mimesh keypoints PIPELINE` chooses points on the source; find their partners on the target",
            ));
        }
        pair.check_markers()
    }
}

impl Biharmonic {
    /// The similarity that brings the source's markers closest to the target's.
    fn similarity(&self, pair: Pair<'_>) -> Similarity {
        let source: Vec<_> =
            pair.markers.iter().map(|m| m.source.position(pair.source, &pair.source.positions)).collect();
        let target: Vec<_> =
            pair.markers.iter().map(|m| m.target.position(pair.target, &pair.target.positions)).collect();
        Similarity::fit(&source, &target, &vec![1.0; source.len()], self.orientation)
    }
}

#[derive(Debug)]
struct Bound {
    skin: Box<dyn Skin>,
    /// W of the target.
    weights: HandleWeights,
    /// The target at rest in the source's frame.
    rest: Vec<Point3<f64>>,
    target_from_source: Similarity,
    figures: Figures,
}

impl BoundTransfer for Bound {
    fn transfer(&self, posed: &[Point3<f64>]) -> Result<Transferred> {
        let fit = self.skin.fit(posed)?;
        let moved = linear_blend(&self.weights.matrix, &fit.transforms, &self.rest)?;
        let positions: Vec<_> = moved.iter().map(|q| self.target_from_source.apply(q)).collect();
        check_finite(&positions)?;
        Ok(Transferred { positions, figures: fit.figures })
    }

    fn figures(&self) -> Figures {
        self.figures.clone()
    }
}
