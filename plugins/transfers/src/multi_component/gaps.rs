//! E3: what becomes of the gaps between components.

use std::{collections::HashMap, ops::Range};

use mimesh_core::{
    Result,
    mesh::{Components, Surface, SurfacePoint},
    operators::Turn,
    spatial::{Nearest, Similarity},
    stage::{TransferPair, TriangleMap},
};
use nalgebra::{Matrix3, Point3, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::joints::{Joint, Offsets, on_target};

/// The property that a gap between two components keeps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Gaps {
    /// It does what the gap between the two source points does, about a joint that lies where the target's proportions have it, so
    /// that teeth part when the jaw opens: t = s R (ũᵢ − ũⱼ) + Fᵢ (cᵢ − c) − Fⱼ (cⱼ − c), with the offset cᵢ = xᵢ − s R uᵢ, and c at the joint.
    /// Its length where an end has no source point.
    #[default]
    Follow,
    /// It turns and stretches with the deformation of both ends: t = F e. Its length where an end has none.
    Turn,
    /// Its length, as in the paper (eq. 8): ‖t‖ = ‖e‖.
    Length,
    /// Nothing. Tetrahedra across the gap are to deform alike instead, those of E_R (eq. 4), and orphans keep no details: the
    /// linear method that the paper compares with (figure 7 d). It distorts parts that turn apart.
    Tetrahedra,
}

/// The gaps of a target.
#[derive(Debug)]
pub struct AllGaps {
    /// One for each pair of vertices.
    pub gaps: Vec<Gap>,
    /// The gaps of each link.
    links: Vec<Range<usize>>,
    /// The joint of each link where that is known.
    joints: Vec<Option<Joint>>,
    /// For each vertex at an end the triangles whose deformation turns the gap.
    rings: Vec<Vec<u32>>,
}

/// A pair of vertices of two components.
#[derive(Debug)]
pub struct Gap {
    pub ends: [u32; 2],
    /// κ, without unit.
    pub weight: f64,
    /// e = xᵢ − xⱼ at rest.
    pub rest: Vector3<f64>,
    /// The ends among the rings, and the share of the second in the mean deformation.
    rings: [u32; 2],
    share: f64,
    /// Where both ends have source points.
    source: Option<Ends>,
    /// Whether both ends belong to components that correspond.
    known: bool,
}

/// The source points of both ends of a gap.
#[derive(Clone, Copy, Debug)]
struct Ends {
    points: [SurfacePoint; 2],
    /// s R u at rest.
    at: [Vector3<f64>; 2],
    /// c = x − s R u at rest.
    offsets: [Vector3<f64>; 2],
}

/// How the ends of a gap have deformed.
#[derive(Clone, Copy, Debug)]
pub struct Deformation {
    /// With rotations apart, so that nothing shrinks where the ends turn apart.
    pub turned: Matrix3<f64>,
    /// What the gap differs by from the source's, for gaps that follow it.
    difference: Option<Vector3<f64>>,
}

impl Deformation {
    fn of_one(f: Matrix3<f64>) -> Self {
        Self { turned: f, difference: None }
    }
}

impl AllGaps {
    /// No gaps.
    pub fn none() -> Self {
        Self { gaps: vec![], links: vec![], joints: vec![], rings: vec![] }
    }

    /// The gaps of all links; `is_orphan` says which triangles correspond to nothing.
    ///
    /// # Errors
    ///
    /// If a position is not finite.
    pub fn new(
        pair: TransferPair<'_>,
        map: &TriangleMap,
        weight: f64,
        is_orphan: impl Fn(usize) -> bool,
        target_from_source: &Similarity,
    ) -> Result<Self> {
        let Some(graph) = pair.proximity else { return Ok(Self::none()) };
        let (source, target) = (pair.source, pair.target);
        let knowledge = Knowledge::new(pair, map, is_orphan, &graph.components)?;
        let at = |p: SurfacePoint| on_target(target_from_source, &p.position(source, &source.positions));
        let point = |v| knowledge.point(v).filter(|_| knowledge.knows(v));
        let offsets = Offsets::new(pair, &graph.components, point, target_from_source);
        let (mut gaps, mut links, mut joints, mut rings) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let mut ring_of = HashMap::new();
        for link in graph.links() {
            let first = gaps.len();
            for &ends in &link.pairs {
                let told = ends.map(|v| knowledge.of(v));
                let points = told[0].and_then(|v| knowledge.point(v)).zip(told[1].and_then(|v| knowledge.point(v)));
                // An end of which nothing is known turns as orphans continue their neighbours.
                let turning = [told[0].unwrap_or(ends[0]), told[1].unwrap_or(ends[1])];
                let rings_of_gap = turning.map(|v| {
                    *ring_of.entry(v).or_insert_with(|| {
                        rings.push(knowledge.ring(v));
                        rings.len() as u32 - 1
                    })
                });
                let counts = rings_of_gap.map(|ring| rings[ring as usize].len() as f64);
                gaps.push(Gap {
                    ends,
                    weight: weight * link.stiffness,
                    rest: target.positions[ends[0] as usize] - target.positions[ends[1] as usize],
                    rings: rings_of_gap,
                    share: counts[1] / (counts[0] + counts[1]).max(1.0),
                    source: points.map(|(a, b)| {
                        let on_source = [a, b].map(at);
                        let offsets = [0, 1].map(|k| target.positions[ends[k] as usize].coords - on_source[k]);
                        Ends { points: [a, b], at: on_source, offsets }
                    }),
                    known: told.iter().all(Option::is_some),
                });
            }
            let of_link: Vec<Ends> = gaps[first..].iter().filter_map(|gap: &Gap| gap.source).collect();
            let joint = || {
                let ends = [0, 1].map(|k| mean(of_link.iter().map(|ends| ends.at[k])));
                let of_ends = mean(of_link.iter().flat_map(|ends| ends.offsets))?;
                offsets.joint(link.components, [ends[0]?, ends[1]?], of_ends)
            };
            joints.push(joint());
            links.push(first..gaps.len());
        }
        Ok(Self { gaps, links, joints, rings })
    }

    /// For each gap how its ends have deformed, when target triangles take the gradients of `field` and the source is at `posed`.
    ///
    /// With R_a, R_b the rotations of the two sides of a link and R_s the one between them,
    /// `turned` is R_s ((1 − s) R_aᵀ F_a + s R_bᵀ F_b), so that gaps keep their length where the sides turn apart; a mean of F_a and F_b
    /// shrinks. Sides rather than single ends give the rotations, because the few triangles at an end may be noise.
    pub fn deformations(
        &self,
        gaps: Gaps,
        field: &[Matrix3<f64>],
        source: &Surface,
        posed: &[Point3<f64>],
        target_from_source: &Similarity,
    ) -> Vec<Deformation> {
        let of_ring = |ring: &Vec<u32>| {
            let sum: Matrix3<f64> = ring.iter().map(|&t| field[t as usize]).sum();
            (!ring.is_empty()).then(|| sum / ring.len() as f64)
        };
        let means: Vec<Option<Matrix3<f64>>> = self.rings.iter().map(of_ring).collect();
        let of_link = |(range, joint): (&Range<usize>, &Option<Joint>)| {
            let of_link = &self.gaps[range.clone()];
            let turns = [0, 1].map(|side| {
                let sum = of_link.iter().filter_map(|gap| means[gap.rings[side] as usize]).sum();
                Turn { stretch: Matrix3::identity(), ..Turn::of(&sum) }
            });
            let rotations = turns.map(|turn| turn.gradient());
            let back = rotations.map(|rotation| rotation.transpose());
            let offset = joint.filter(|_| gaps == Gaps::Follow).and_then(|joint| {
                let ends = of_link.iter().filter_map(|gap| gap.source).map(|ends| ends.points);
                let at = |p: SurfacePoint| on_target(target_from_source, &p.position(source, posed));
                let means = [0, 1].map(|k| mean(ends.clone().map(|points| at(points[k]))));
                Some(joint.offset(rotations, [means[0]?, means[1]?]))
            });
            let deformation = |gap: &Gap| match gap.rings.map(|ring| means[ring as usize]) {
                [Some(a), Some(b)] => {
                    let between = turns[0].towards(&turns[1], gap.share).gradient();
                    let difference = gap.source.filter(|_| gap.known && gaps == Gaps::Follow).map(|ends| {
                        let [c_a, c_b] = ends.offsets;
                        match offset {
                            Some(c) => a * (c_a - c) - b * (c_b - c),
                            None => (a * (1.0 - gap.share) + b * gap.share) * (c_a - c_b),
                        }
                    });
                    let turned = between * (back[0] * a * (1.0 - gap.share) + back[1] * b * gap.share);
                    Deformation { turned, difference }
                }
                [Some(one), None] | [None, Some(one)] => Deformation::of_one(one),
                [None, None] => Deformation::of_one(Matrix3::identity()),
            };
            of_link.iter().map(deformation).collect::<Vec<_>>()
        };
        self.links.iter().zip(&self.joints).flat_map(of_link).collect()
    }
}

impl Gap {
    /// Whether only its length is known, because a component at its end corresponds to nothing.
    pub fn is_loose(&self) -> bool {
        !self.known
    }

    /// The vector with the direction at `positions` and the length at rest; `before` if it has no direction.
    pub fn with_length(&self, positions: &[Point3<f64>], before: Vector3<f64>) -> Vector3<f64> {
        let now = positions[self.ends[0] as usize] - positions[self.ends[1] as usize];
        now.try_normalize(1e-300).map_or(before, |direction| direction * self.rest.norm())
    }

    /// The gap's vector when the source is at `posed` and its ends have deformed by `f`; `None` where only its length is known.
    ///
    /// With `follow`, F carries only what the gap differs by from the source's, e − s R (uᵢ − uⱼ), in which errors of the
    /// correspondence are.
    pub fn vector(
        &self,
        gaps: Gaps,
        source: &Surface,
        posed: &[Point3<f64>],
        f: &Deformation,
        target_from_source: &Similarity,
    ) -> Option<Vector3<f64>> {
        if gaps == Gaps::Length || !self.known {
            return None;
        }
        match (&self.source, gaps) {
            (Some(Ends { points, offsets, .. }), Gaps::Follow) => {
                let [a, b] = points.map(|p| on_target(target_from_source, &p.position(source, posed)));
                Some(a - b + f.difference.unwrap_or_else(|| f.turned * (offsets[0] - offsets[1])))
            }
            _ => Some(f.turned * self.rest),
        }
    }
}

/// The mean of the points; `None` if there is none.
fn mean(points: impl Iterator<Item = Vector3<f64>>) -> Option<Vector3<f64>> {
    let (mut sum, mut count) = (Vector3::zeros(), 0.0);
    points.for_each(|p| {
        sum += p;
        count += 1.0;
    });
    (count > 0.0).then(|| sum / count)
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

    /// The triangles around `v` that correspond; all of them where none does.
    fn ring(&self, v: u32) -> Vec<u32> {
        let around = &self.around[v as usize];
        let known: Vec<u32> = around.iter().copied().filter(|&t| self.corresponds[t as usize]).collect();
        if known.is_empty() { around.clone() } else { known }
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
