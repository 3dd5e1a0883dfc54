//! Positions of the target from the gradients of the blend at corresponding places of the source.

use std::sync::Arc;

use mimesh_core::{
    Result,
    mesh::Surface,
    operators::{Gradient, blended_maps, gradients},
    spatial::Similarity,
};
use nalgebra::{DMatrix, Matrix3, Matrix3x4, Point3, Vector3};
use rayon::prelude::*;

use crate::poisson::{Fit, Poisson};

/// The components of a target, of which each lies where the maps bring its mean.
#[derive(Debug)]
pub(super) struct Parts {
    /// The vertices of each component with their shares of its area.
    components: Vec<Vec<(u32, f64)>>,
}

impl Parts {
    /// The same in any frame.
    pub(super) fn new(target: &Surface) -> Self {
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
        Self { components: members }
    }
}

/// The target at corresponding places of the source, and how gradients there become positions of the target.
#[derive(Debug)]
pub(super) struct Integral {
    /// The gradient operator of each triangle at y.
    gradients: Vec<Option<Gradient>>,
    /// The unit normal of each triangle at y.
    normals: Vec<Vector3<f64>>,
    /// y.
    places: Vec<Point3<f64>>,
    poisson: Arc<Poisson>,
    /// What brings the frame of `poisson` to that of the source; `None` where they are one.
    source_from_poisson: Option<Similarity>,
    triangles: Vec<[u32; 3]>,
    /// x: the target at rest in the source's frame.
    rest: Vec<Point3<f64>>,
    parts: Arc<Parts>,
}

/// As many triangles are worth the while of a thread.
const TRIANGLES: usize = 4096;

/// What the maps of the handles make of a pose.
pub(super) struct Pose<'a> {
    /// The maps.
    pub transforms: &'a [Matrix3x4<f64>],
    /// Where they bring y.
    pub blend: &'a [Point3<f64>],
}

impl Integral {
    /// `target` is at rest in the source's frame, `places` are y.
    pub(super) fn new(target: Surface, places: Vec<Point3<f64>>) -> Result<Self> {
        let poisson = Arc::new(Poisson::new(&target, |area| area)?);
        let parts = Arc::new(Parts::new(&target));
        Ok(Self::by(poisson, parts, None, target, places))
    }

    /// The same by a system that was factored for the target in its own frame, which `source_from_target` brings to the source's.
    pub(super) fn kept(
        poisson: Arc<Poisson>,
        parts: Arc<Parts>,
        source_from_target: Similarity,
        target: Surface,
        places: Vec<Point3<f64>>,
    ) -> Self {
        Self::by(poisson, parts, Some(source_from_target), target, places)
    }

    fn by(
        poisson: Arc<Poisson>,
        parts: Arc<Parts>,
        source_from_poisson: Option<Similarity>,
        target: Surface,
        places: Vec<Point3<f64>>,
    ) -> Self {
        let unit = |n: &Vector3<f64>| n.try_normalize(0.0).unwrap_or_default();
        let (gradients, normals) = rayon::join(
            || gradients(&places, &target.triangles),
            || target.area_normals(&places).iter().map(unit).collect(),
        );
        Self {
            gradients,
            normals,
            poisson,
            parts,
            source_from_poisson,
            triangles: target.triangles,
            rest: target.positions,
            places,
        }
    }

    /// How many poses are best taken together.
    pub(super) fn at_once(&self) -> usize {
        self.poisson.at_once()
    }

    /// The target in the source's frame, for each of several poses whose maps bring y to its `blend`.
    pub(super) fn positions(&self, weights: &DMatrix<f64>, poses: &[Pose<'_>]) -> Vec<Result<Vec<Point3<f64>>>> {
        let fields: Vec<Result<Vec<Matrix3<f64>>>> = poses.par_iter().map(|pose| self.field(weights, pose)).collect();
        let sound: Vec<&[Matrix3<f64>]> = fields.iter().flatten().map(Vec::as_slice).collect();
        let mut solutions = self.poisson.solve_all(&sound, Fit::LEAST_SQUARES).into_iter();
        let positions = |(field, pose): (Result<Vec<Matrix3<f64>>>, &Pose<'_>)| {
            field?;
            let mut positions = solutions.next().expect("each field has a solution")?.positions;
            if let Some(to_source) = &self.source_from_poisson {
                positions.iter_mut().for_each(|p| *p = to_source.apply(p));
            }
            self.place(pose.blend, &mut positions);
            Ok(positions)
        };
        fields.into_iter().zip(poses).map(positions).collect()
    }

    /// The gradients of the target's triangles.
    fn field(&self, weights: &DMatrix<f64>, pose: &Pose<'_>) -> Result<Vec<Matrix3<f64>>> {
        let maps = blended_maps(weights, pose.transforms)?;
        let gradient = |t: usize| {
            // Weights do not change along the normal, so that there the gradient is the maps' own.
            let corners = self.triangles[t];
            let of_maps = corners.iter().map(|&v| maps[v as usize]).sum::<Matrix3<f64>>() / 3.0;
            let Some(gradient) = &self.gradients[t] else { return of_maps };
            let normal = self.normals[t];
            gradient.of_posed(&corners.map(|v| pose.blend[v as usize])) + of_maps * normal * normal.transpose()
        };
        let gradients = (0..self.triangles.len()).into_par_iter().with_min_len(TRIANGLES).map(gradient);
        Ok(match &self.source_from_poisson {
            None => gradients.collect(),
            Some(to_source) => {
                let (turn, back) = (to_source.rotation, to_source.rotation.transpose());
                gradients.map(|gradient| back * gradient * turn).collect()
            }
        })
    }

    /// Moves each component by the mean motion that the maps give it.
    fn place(&self, blend: &[Point3<f64>], positions: &mut [Point3<f64>]) {
        for members in &self.parts.components {
            let mean = |points: &[Point3<f64>]| -> Vector3<f64> {
                members.iter().map(|&(v, share)| points[v as usize].coords * share).sum()
            };
            let goal = mean(&self.rest) + mean(blend) - mean(&self.places);
            let shift = goal - mean(positions);
            members.iter().for_each(|&(v, _)| positions[v as usize] += shift);
        }
    }
}
