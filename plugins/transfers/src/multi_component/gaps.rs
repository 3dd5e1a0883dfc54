//! E3: what becomes of the gaps between components.

use mimesh_core::{
    mesh::{Surface, SurfacePoint},
    spatial::Similarity,
    stage::{Pair, TriangleMap},
};
use nalgebra::{Matrix3, Point3, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What a gap between two components keeps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Gaps {
    /// It does what the gap between the two source points does: t = F e + s R ((ũᵢ − ũⱼ) − (F_s (uᵢ − uⱼ))), so that teeth
    /// part when the jaw opens. Its length where an end has no source point.
    #[default]
    Follow,
    /// It turns and stretches with the deformation of both ends: t = F e. Its length where an end has none.
    Turn,
    /// Its length, as in the paper (eq. 8): ‖t‖ = ‖e‖.
    Length,
}

/// A pair of vertices of two components.
#[derive(Debug)]
pub struct Gap {
    pub ends: [u32; 2],
    /// κ, without unit.
    pub weight: f64,
    /// e = xᵢ − xⱼ at rest.
    pub rest: Vector3<f64>,
    /// Triangles around the ends, whose mean deformation turns the gap.
    around: Vec<u32>,
    /// Source points of the ends, and uᵢ − uⱼ between them at rest.
    source: Option<([SurfacePoint; 2], Vector3<f64>)>,
    /// Whether both ends belong to triangles that correspond.
    known: bool,
}

impl Gap {
    /// The gaps of all links; `is_orphan` says which triangles correspond to nothing.
    pub fn all(pair: Pair<'_>, map: &TriangleMap, weight: f64, is_orphan: impl Fn(usize) -> bool) -> Vec<Self> {
        let Some(graph) = pair.proximity else { return vec![] };
        let (source, target) = (pair.source, pair.target);
        let around = target.triangles_around();
        let point =
            |v: u32| map.points.get(v as usize).copied().flatten().or_else(|| corner(map, &around, target, source, v));
        let knows = |v: u32| around[v as usize].iter().any(|&t| !is_orphan(t as usize));
        let gap = |ends: [u32; 2], stiffness: f64| {
            let at = |p: SurfacePoint| p.position(source, &source.positions);
            let points = point(ends[0]).zip(point(ends[1]));
            let known_around = ends.iter().flat_map(|&v| around[v as usize].iter().copied());
            Self {
                ends,
                weight: weight * stiffness,
                rest: target.positions[ends[0] as usize] - target.positions[ends[1] as usize],
                around: known_around.filter(|&t| !is_orphan(t as usize)).collect(),
                source: points.map(|(a, b)| ([a, b], at(a) - at(b))),
                known: ends.iter().all(|&v| knows(v)),
            }
        };
        let links = graph.links.iter();
        links
            .flat_map(|link| link.pairs.iter().map(move |&ends| (ends, link.stiffness)))
            .map(|(e, k)| gap(e, k))
            .collect()
    }

    /// The gap's vector when the source is at `posed` and target triangles take the gradients of `field`; `None` where only its
    /// length is known.
    pub fn vector(
        &self,
        gaps: Gaps,
        source: &Surface,
        posed: &[Point3<f64>],
        field: &[Matrix3<f64>],
        target_from_source: &Similarity,
    ) -> Option<Vector3<f64>> {
        if gaps == Gaps::Length || !self.known {
            return None;
        }
        let f = self.mean(field);
        let turned = f * self.rest;
        match (&self.source, gaps) {
            (Some(([a, b], rest)), Gaps::Follow) => {
                let to_target = target_from_source.rotation * target_from_source.scale;
                let now = a.position(source, posed) - b.position(source, posed);
                Some(turned + to_target * now - f * (to_target * rest))
            }
            _ => Some(turned),
        }
    }

    /// The direction in which to look for a gap of which only the length is known, before there is a solution.
    pub fn first_guess(&self, field: &[Matrix3<f64>]) -> Vector3<f64> {
        self.mean(field) * self.rest
    }

    fn mean(&self, field: &[Matrix3<f64>]) -> Matrix3<f64> {
        if self.around.is_empty() {
            return Matrix3::identity();
        }
        self.around.iter().map(|&t| field[t as usize]).sum::<Matrix3<f64>>() / self.around.len() as f64
    }
}

/// The source point of vertex `v` where triangles correspond as wholes.
fn corner(map: &TriangleMap, around: &[Vec<u32>], target: &Surface, source: &Surface, v: u32) -> Option<SurfacePoint> {
    if !map.points.is_empty() {
        return None;
    }
    around[v as usize].iter().find_map(|&t| {
        let partner = map.partners[t as usize]?;
        let k = target.triangles[t as usize].iter().position(|&w| w == v)?;
        Some(SurfacePoint::Vertex(source.triangles[partner as usize][k]))
    })
}
