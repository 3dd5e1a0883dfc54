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

use mimesh_core::{
    Error, Figures, Result,
    mesh::{Surface, SurfacePoint, check_finite},
    operators::{DeformationGradients, linear_blend},
    plugin::{instance, nested},
    register,
    spatial::{Orientation, Similarity},
    stage::{
        BoundTransfer, Clusterer, Deformer, HandleWeights, Marker, Pair, Skin, Transfer, Transferred, TriangleMap,
        Weights,
    },
};
use nalgebra::{DMatrix, Matrix3, Matrix3x4, Point3, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{loose::Loose, poisson::Poisson};

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
    /// How the maps become positions.
    pub reconstruction: Reconstruction,
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
            clusterer: instance("rotation_kmeans"),
            deformer: instance("arap_skinning"),
            frame: Frame::Fitted,
            orientation: Orientation::Auto,
            reconstruction: Reconstruction::Gradients,
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
        let (weights, clusterer, deformer) = self.stages()?;
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
        let rest: Vec<_> = pair.target.positions.iter().map(|x| in_source.apply(x)).collect();
        let integral = match self.reconstruction {
            Reconstruction::Blend => None,
            Reconstruction::Gradients => Some(Integral::new(pair, &of_target, rest.clone(), &in_source)?),
        };
        Ok(Box::new(Bound { skin, weights: of_target, rest, integral, target_from_source, figures }))
    }

    fn check(&self, pair: Pair<'_>) -> Result<()> {
        Error::check_setting("learn_from", self.learn_from as f64, 1.0, f64::INFINITY)?;
        self.stages()?;
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
    fn stages(&self) -> Result<(&dyn Weights, &dyn Clusterer, &dyn Deformer)> {
        Ok((
            nested("weights", &self.weights, "bounded_biharmonic")?,
            nested("clusterer", &self.clusterer, "rotation_kmeans")?,
            nested("deformer", &self.deformer, "arap_skinning")?,
        ))
    }

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
    integral: Option<Integral>,
    target_from_source: Similarity,
    figures: Figures,
}

impl BoundTransfer for Bound {
    fn transfer(&self, posed: &[Point3<f64>]) -> Result<Transferred> {
        let fit = self.skin.fit(posed)?;
        let moved = match &self.integral {
            None => linear_blend(&self.weights.matrix, &fit.transforms, &self.rest)?,
            Some(integral) => integral.positions(&self.weights.matrix, &fit.transforms)?,
        };
        let positions: Vec<_> = moved.iter().map(|q| self.target_from_source.apply(q)).collect();
        check_finite(&positions)?;
        Ok(Transferred { positions, figures: fit.figures })
    }

    fn figures(&self) -> Figures {
        self.figures.clone()
    }
}

/// The target at corresponding places of the source, and how gradients there become positions of the target.
#[derive(Debug)]
struct Integral {
    /// y.
    places: Vec<Point3<f64>>,
    gradients: DeformationGradients,
    poisson: Poisson,
    loose: Loose,
    triangles: Vec<[u32; 3]>,
    /// x: the target at rest in the source's frame.
    rest: Vec<Point3<f64>>,
    /// The vertices of each component with their shares of its area.
    components: Vec<Vec<(u32, f64)>>,
}

impl Integral {
    fn new(pair: Pair<'_>, weights: &HandleWeights, rest: Vec<Point3<f64>>, in_source: &Similarity) -> Result<Self> {
        let target = Surface { positions: rest, ..pair.target.clone() };
        let offset = |marker: &Marker| {
            let on_target = in_source.apply(&marker.target.position(pair.target, &pair.target.positions));
            on_target - marker.source.position(pair.source, &pair.source.positions)
        };
        let mut places = target.positions.clone();
        for (column, marker) in weights.matrix.column_iter().zip(pair.markers) {
            let offset = offset(marker);
            places.iter_mut().zip(column.iter()).for_each(|(y, w)| *y -= offset * *w);
        }
        let areas = target.area_normals(&target.positions);
        let components = target.components();
        let mut shares = vec![0.0; target.vertex_count()];
        for (corners, area) in target.triangles.iter().zip(&areas) {
            corners.iter().for_each(|&v| shares[v as usize] += area.norm());
        }
        let mut members = vec![Vec::new(); components.count()];
        for (v, c) in components.of_vertex.iter().enumerate() {
            if let Some(c) = c {
                members[*c as usize].push((v as u32, shares[v]));
            }
        }
        for members in &mut members {
            let total: f64 = members.iter().map(|(_, share)| share).sum();
            let count = members.len() as f64;
            members.iter_mut().for_each(|(_, share)| *share = if total > 0.0 { *share / total } else { 1.0 / count });
        }
        Ok(Self {
            gradients: DeformationGradients::new(&places, &target.triangles),
            poisson: Poisson::new(&target, |area| area)?,
            loose: Loose::new(&target),
            triangles: target.triangles.clone(),
            rest: target.positions,
            places,
            components: members,
        })
    }

    /// The target in the source's frame for maps `transforms`.
    fn positions(&self, weights: &DMatrix<f64>, transforms: &[Matrix3x4<f64>]) -> Result<Vec<Point3<f64>>> {
        let blend = linear_blend(weights, transforms, &self.places)?;
        let gradient = |t: usize| {
            if self.gradients.is_defined(t) {
                return self.gradients.of_triangle(t, &blend);
            }
            // Without area at the source's place: as the maps have it.
            let corner = |v: u32| -> Matrix3<f64> {
                let row = weights.row(v as usize);
                row.iter().zip(transforms).map(|(w, t)| t.fixed_columns::<3>(0) * *w).sum()
            };
            self.triangles[t].iter().map(|&v| corner(v)).sum::<Matrix3<f64>>() / 3.0
        };
        let field: Vec<_> = (0..self.triangles.len()).map(gradient).collect();
        let mut positions = self.poisson.solve(&field, 0, 1.0)?.positions;
        for members in &self.components {
            let mean = |points: &[Point3<f64>]| -> Vector3<f64> {
                members.iter().map(|&(v, share)| points[v as usize].coords * share).sum()
            };
            let goal = mean(&self.rest) + mean(&blend) - mean(&self.places);
            let shift = goal - mean(&positions);
            members.iter().for_each(|&(v, _)| positions[v as usize] += shift);
        }
        self.loose.place(|t| field[t], &mut positions);
        Ok(positions)
    }
}
