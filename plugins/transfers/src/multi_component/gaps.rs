//! E3: what becomes of the gaps between components.

use mimesh_core::{
    Result,
    mesh::{Components, Surface, SurfacePoint},
    spatial::{Nearest, Similarity},
    stage::{TransferPair, TriangleMap},
};
use nalgebra::{Matrix3, Point3, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The property that a gap between two components keeps.
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
    /// Whether both ends belong to components that correspond.
    known: bool,
}

impl Gap {
    /// The gaps of all links; `is_orphan` says which triangles correspond to nothing.
    ///
    /// # Errors
    ///
    /// If a position is not finite.
    pub fn all(
        pair: TransferPair<'_>,
        map: &TriangleMap,
        weight: f64,
        is_orphan: impl Fn(usize) -> bool,
    ) -> Result<Vec<Self>> {
        let Some(graph) = pair.proximity else { return Ok(vec![]) };
        let (source, target) = (pair.source, pair.target);
        let knowledge = Knowledge::new(pair, map, is_orphan, &graph.components)?;
        let gap = |ends: [u32; 2], stiffness: f64| {
            let at = |p: SurfacePoint| p.position(source, &source.positions);
            let told = ends.map(|v| knowledge.of(v));
            let points = told[0].and_then(|v| knowledge.point(v)).zip(told[1].and_then(|v| knowledge.point(v)));
            let around = |v: &u32| knowledge.around[*v as usize].iter().copied();
            let known_around = told.iter().flatten().flat_map(around).filter(|&t| knowledge.corresponds[t as usize]);
            Self {
                ends,
                weight: weight * stiffness,
                rest: target.positions[ends[0] as usize] - target.positions[ends[1] as usize],
                around: known_around.collect(),
                source: points.map(|(a, b)| ([a, b], at(a) - at(b))),
                known: told.iter().all(Option::is_some),
            }
        };
        let links = graph.links();
        Ok(links
            .flat_map(|link| link.pairs.iter().map(move |&ends| (ends, link.stiffness)))
            .map(|(e, k)| gap(e, k))
            .collect())
    }

    /// Whether only its length is known, because a component at its end corresponds to nothing.
    pub fn is_loose(&self) -> bool {
        !self.known
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

/// The knowledge about the target's vertices.
///
/// An end of a gap that no triangle with a partner touches stands for the nearest vertex of its component that one does: a
/// component moves nearly as one, and its own known part tells more of the gap than a length does.
struct Knowledge<'a> {
    pair: TransferPair<'a>,
    map: &'a TriangleMap,
    /// Triangles around each target vertex.
    around: Vec<Vec<u32>>,
    /// Whether each target triangle has a partner.
    corresponds: Vec<bool>,
    /// The component of each target vertex.
    components: &'a Components,
    /// Known vertices of each component, with a search among them, where gaps of the component need it.
    known: Vec<Option<(Vec<u32>, Nearest)>>,
}

impl<'a> Knowledge<'a> {
    fn new(
        pair: TransferPair<'a>,
        map: &'a TriangleMap,
        is_orphan: impl Fn(usize) -> bool,
        components: &'a Components,
    ) -> Result<Self> {
        let target = pair.target;
        let around = target.triangles_around();
        let corresponds: Vec<bool> = (0..target.triangle_count()).map(|t| !is_orphan(t)).collect();
        let mut knowledge = Self { pair, map, around, corresponds, components, known: vec![] };
        let mut vertices = vec![(Vec::new(), false); components.count()];
        for v in 0..target.vertex_count() as u32 {
            let Some(c) = components.of_vertex[v as usize] else { continue };
            if knowledge.knows(v) {
                vertices[c as usize].0.push(v);
            }
        }
        for v in pair.proximity.iter().flat_map(|graph| graph.pairs()).flatten() {
            if let (Some(c), false) = (components.of_vertex[v as usize], knowledge.knows(v)) {
                vertices[c as usize].1 = true;
            }
        }
        let search = |(vertices, needed): (Vec<u32>, bool)| {
            if vertices.is_empty() || !needed {
                return Ok(None);
            }
            let positions: Vec<_> = vertices.iter().map(|&v| target.positions[v as usize]).collect();
            Ok(Some((vertices, Nearest::new(&positions)?)))
        };
        knowledge.known = vertices.into_iter().map(search).collect::<Result<_>>()?;
        Ok(knowledge)
    }

    /// Whether a triangle with a partner touches `v`, and its source point is known where any are.
    fn knows(&self, v: u32) -> bool {
        self.around[v as usize].iter().any(|&t| self.corresponds[t as usize])
            && (self.map.points.is_empty() || self.map.points[v as usize].is_some())
    }

    /// `v` if it is known, else the nearest vertex of its component that is; `None` if its component corresponds to nothing.
    fn of(&self, v: u32) -> Option<u32> {
        if self.knows(v) {
            return Some(v);
        }
        let (vertices, nearest) = self.known[self.components.of_vertex[v as usize]? as usize].as_ref()?;
        Some(vertices[nearest.find(&self.pair.target.positions[v as usize]).0 as usize])
    }

    /// The source point of `v`: the map's, or the partner's corner where triangles correspond as wholes.
    fn point(&self, v: u32) -> Option<SurfacePoint> {
        if !self.map.points.is_empty() {
            return self.map.points[v as usize];
        }
        self.around[v as usize].iter().find_map(|&t| {
            let partner = self.map.triangles[t as usize]?;
            let k = self.pair.target.triangles[t as usize].iter().position(|&w| w == v)?;
            Some(SurfacePoint::Vertex(self.pair.source.triangles[partner as usize][k]))
        })
    }
}
