//! Where two linked components turn against each other, and how far the target's joint lies from the source's.
//!
//! With c(x) = x − s R u the offset of a target point from its source point u, seen on the target at rest, a gap becomes
//! s R (ũᵢ − ũⱼ) + Fᵢ (cᵢ − c) − Fⱼ (cⱼ − c), c being the offset at the joint. A joint has no vertices, so that c is estimated:
//! each component continues its own offsets, linearly, up to the joint. Proportions differ between components, so that such an
//! estimate is off by as much as the joint lies away from the middle of the component. The estimates therefore count by the inverse
//! square of that distance: a ball in a socket has the joint at its middle, whatever the size of the body beside it.

use mimesh_core::{
    mesh::{Components, SurfacePoint},
    operators::voronoi_mass,
    spatial::Similarity,
    stage::TransferPair,
};
use nalgebra::{Matrix3, Point3, Vector3};

/// What the variance of the points along an axis competes with, over their mean variance: the correspondence gives offsets an
/// error, which a slope carries on.
const RIDGE: f64 = 10.0;

/// What the squared difference of two rotations competes with: where both sides turn alike, the joint is the middle of the gap.
const ROTATION_RIDGE: f64 = 0.01;

/// A joint this many radii of the smaller component away from its gap counts by half: two thighs turn about no joint of theirs.
const REACH: f64 = 2.0;

/// The least distance from the middle of a component, over the radius of the smaller one.
const MIN_DISTANCE: f64 = 0.1;

/// The joint of a link, at rest and seen on the target.
#[derive(Clone, Copy, Debug)]
pub struct Joint {
    sides: [Side; 2],
    /// The mean source point of the ends of its gaps, on either side.
    ends: [Vector3<f64>; 2],
    /// The mean offset of the ends.
    of_ends: Vector3<f64>,
    /// The radius of the smaller component.
    radius: f64,
}

/// How the offsets of a component run.
#[derive(Clone, Copy, Debug)]
struct Side {
    /// The mean of its source points.
    middle: Vector3<f64>,
    /// The mean offset.
    offset: Vector3<f64>,
    /// The change of the offset over a way from the middle.
    slope: Matrix3<f64>,
    /// The root mean square distance of its source points from the middle.
    radius: f64,
}

impl Joint {
    /// The offset c at the joint when the two sides are turned by `rotations` and the means of their ends are at `ends`.
    ///
    /// The joint is the point that both sides take to the same place, as nearly as there is one.
    pub fn offset(&self, rotations: [Matrix3<f64>; 2], ends: [Vector3<f64>; 2]) -> Vector3<f64> {
        let apart = rotations[0] - rotations[1];
        let middle = (self.ends[0] + self.ends[1]) / 2.0;
        let [a, b] = [0, 1].map(|k| ends[k] + rotations[k] * (middle - self.ends[k]));
        let normal = apart.transpose() * apart + Matrix3::identity() * ROTATION_RIDGE;
        let Some(inverse) = normal.try_inverse() else { return self.of_ends };
        let way = inverse * (apart.transpose() * (b - a));
        let joint = middle + way;
        let least = (MIN_DISTANCE * self.radius).powi(2);
        let weights = self.sides.map(|side| 1.0 / ((joint - side.middle).norm_squared() + least));
        let offsets = self.sides.map(|side| side.offset + side.slope * (joint - side.middle));
        let found = (offsets[0] * weights[0] + offsets[1] * weights[1]) / (weights[0] + weights[1]);
        let trust = 1.0 / (1.0 + way.norm_squared() / (REACH * self.radius).powi(2));
        self.of_ends.lerp(&found, trust)
    }
}

/// The offsets of all components of a target.
pub struct Offsets {
    sides: Vec<Option<Side>>,
}

impl Offsets {
    /// The offsets of each component that has source points; `point` gives that of a target vertex.
    pub fn new(
        pair: TransferPair<'_>,
        components: &Components,
        point: impl Fn(u32) -> Option<SurfacePoint>,
        target_from_source: &Similarity,
    ) -> Self {
        let (source, target) = (pair.source, pair.target);
        let mass = voronoi_mass(&target.positions, &target.triangles);
        let mut points = vec![Vec::new(); components.count()];
        for v in 0..target.vertex_count() as u32 {
            let Some((c, p)) = components.of_vertex[v as usize].zip(point(v)) else { continue };
            let at = on_target(target_from_source, &p.position(source, &source.positions));
            let offset = target.positions[v as usize].coords - at;
            points[c as usize].push(Known { at, offset, mass: mass[v as usize] });
        }
        Self { sides: points.iter().map(|points| Side::of(points)).collect() }
    }

    /// The joint between two components whose gaps have these mean source points and this mean offset at their ends; `None` if a
    /// component has no size or no source points.
    pub fn joint(&self, components: [u32; 2], ends: [Vector3<f64>; 2], of_ends: Vector3<f64>) -> Option<Joint> {
        let [a, b] = components.map(|c| self.sides[c as usize]);
        let sides = [a?, b?];
        let radius = sides[0].radius.min(sides[1].radius);
        (radius > 0.0).then_some(Joint { sides, ends, of_ends, radius })
    }
}

/// What is known of a vertex.
#[derive(Clone)]
struct Known {
    /// Its source point.
    at: Vector3<f64>,
    offset: Vector3<f64>,
    mass: f64,
}

impl Side {
    fn of(points: &[Known]) -> Option<Self> {
        let total: f64 = points.iter().map(|p| p.mass).sum();
        if total <= 0.0 {
            return None;
        }
        let middle = points.iter().map(|p| p.at * p.mass).sum::<Vector3<f64>>() / total;
        let offset = points.iter().map(|p| p.offset * p.mass).sum::<Vector3<f64>>() / total;
        let (mut spread, mut change) = (Matrix3::zeros(), Matrix3::zeros());
        for p in points {
            let way = (p.at - middle) * p.mass;
            spread += way * (p.at - middle).transpose();
            change += (p.offset - offset) * way.transpose();
        }
        let ridge = Matrix3::identity() * (spread.trace() / 3.0 * RIDGE);
        let slope = (spread + ridge).try_inverse().map_or_else(Matrix3::zeros, |inverse| change * inverse);
        Some(Self { middle, offset, slope, radius: (spread.trace() / total).sqrt() })
    }
}

/// A source point as a vector on the target, but for a translation that all have in common.
pub fn on_target(target_from_source: &Similarity, p: &Point3<f64>) -> Vector3<f64> {
    target_from_source.rotation * p.coords * target_from_source.scale
}
