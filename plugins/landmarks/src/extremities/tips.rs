//! Points of two limbs that correspond, found in the boxes of the limbs themselves.
//!
//! The farthest point of a limb is not the same on every shape: a cat's is the tip of an ear, a lion's the nose. Laid into one box the
//! outer halves of two limbs show which points are the same. Where one hangs and the other is stretched out, as arms at rest do, it is
//! turned along the other first.

use nalgebra::{Matrix3, Point3, Rotation3, SVector, Vector3};

use super::{
    matching::LimbPair,
    shape::Shape,
    turn::{Frames, in_box},
};

/// Limbs with fewer points are too small to be laid on each other.
const MIN_POINTS: usize = 8;

/// An extent of a limb counts as at least this share of the longest.
const LEAST_EXTENT: f64 = 0.25;

/// How normals, and how mean distances between those of the limb's end and its tip, compare to places in the box.
const NORMALS: f64 = 0.2;
const FAR: f64 = 0.3;

/// Limbs whose directions differ by more than this, in degrees, stand in different poses.
const BENT: f64 = 30.0;

/// Two tips of one limb are at least this far apart, in sides of its box.
const APART: f64 = 0.5;

/// A further tip may be this much worth less than the first.
const LESS_WORTH: f64 = 0.5;

/// What lying apart costs a pair of points, in terms of lying far out.
const DISTANCE_COST: f64 = 2.0;

/// Two points of the clouds that correspond.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tip {
    /// The point of the source's cloud.
    pub source: usize,
    /// The point of the target's cloud.
    pub target: usize,
    /// How far they lie apart in the boxes of their limbs, with normals and mean distances.
    pub distance: f64,
}

/// At most `most` points of the limbs in `pair` that correspond, the farthest out first, when the shapes are turned by `frames`.
///
/// Points are mutually nearest in the boxes of their limbs, within `max_distance`.
pub fn tips(
    source: &Shape,
    target: &Shape,
    pair: LimbPair,
    frames: &Frames,
    most: usize,
    max_distance: f64,
) -> Vec<Tip> {
    let own = [&source.limbs[pair.source].outer, &target.limbs[pair.target].outer];
    if own.iter().any(|points| points.len() < MIN_POINTS) {
        let tip = Tip { source: source.limbs[pair.source].tip, target: target.limbs[pair.target].tip, distance: 0.0 };
        // On one surface a thin limb follows what it grows from, better than its tips are known. Loose pieces follow nothing.
        return if target.cloud.is_parted() { vec![tip] } else { vec![] };
    }
    let bend = bend(along(source, own[0], &frames.source), along(target, own[1], &frames.target));
    let a = Outer::new(source, own[0], &(bend * frames.source));
    let b = Outer::new(target, own[1], &frames.target);
    let (to_b, to_a) = (nearest(&a.features, &b.features), nearest(&b.features, &a.features));
    let mutual = (0..own[0].len()).filter(|&i| to_a[to_b[i].0].0 == i && to_b[i].1 < max_distance);
    let worth = |i: usize| a.far[i] + b.far[to_b[i].0] - DISTANCE_COST * to_b[i].1;
    let mut candidates: Vec<usize> = mutual.collect();
    candidates.sort_by(|&i, &j| worth(j).total_cmp(&worth(i)).then(i.cmp(&j)));
    let mut chosen: Vec<usize> = Vec::new();
    for i in candidates {
        let is_apart = chosen.iter().all(|&c| (a.places[i] - a.places[c]).norm() > APART);
        let is_worth = chosen.first().is_none_or(|&first| worth(first) - worth(i) < LESS_WORTH);
        if chosen.len() < most && is_apart && is_worth {
            chosen.push(i);
        }
    }
    let tip = |i: usize| Tip { source: own[0][i], target: own[1][to_b[i].0], distance: to_b[i].1 };
    chosen.into_iter().map(tip).collect()
}

/// The direction of a limb, from its inner end outwards; not of unit length.
fn along(shape: &Shape, points: &[usize], turn: &Matrix3<f64>) -> Vector3<f64> {
    let count = points.len() as f64;
    let far = points.iter().map(|&p| shape.far[p]).sum::<f64>() / count;
    let ways = points.iter().map(|&p| shape.cloud.places[p].coords * (shape.far[p] - far));
    turn * ways.sum::<Vector3<f64>>()
}

/// The least turn that takes the direction `from` to `to`; none if they differ little, or are opposite.
fn bend(from: Vector3<f64>, to: Vector3<f64>) -> Matrix3<f64> {
    let is_bent = from.angle(&to) > BENT.to_radians();
    let turn = Rotation3::rotation_between(&from, &to).filter(|_| is_bent);
    turn.map_or_else(Matrix3::identity, Rotation3::into_inner)
}

/// The outer part of a limb in its own box.
struct Outer {
    places: Vec<Vector3<f64>>,
    /// From 0 at the inner end to 1 at the point farthest out.
    far: Vec<f64>,
    /// Places, normals and `far` as one vector a point.
    features: Vec<SVector<f64, 7>>,
}

impl Outer {
    fn new(shape: &Shape, points: &[usize], turn: &Matrix3<f64>) -> Self {
        let turned: Vec<Point3<f64>> = points.iter().map(|&p| turn * shape.cloud.places[p]).collect();
        let places = in_box(&turned, LEAST_EXTENT);
        let values = points.iter().map(|&p| shape.far[p]);
        let (low, high) = values.clone().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), f| (l.min(f), h.max(f)));
        let range = (high - low).max(f64::MIN_POSITIVE);
        let far: Vec<f64> = values.map(|f| (f - low) / range).collect();
        let features = (0..points.len()).map(|k| {
            let (p, n) = (places[k], turn * shape.cloud.normals[points[k]] * NORMALS);
            SVector::from([p.x, p.y, p.z, n.x, n.y, n.z, FAR * far[k]])
        });
        Self { features: features.collect(), places, far }
    }
}

/// For each of `from` the nearest of `to`, the first of equals, and its distance.
fn nearest(from: &[SVector<f64, 7>], to: &[SVector<f64, 7>]) -> Vec<(usize, f64)> {
    let of = |p: &SVector<f64, 7>| {
        let distances = to.iter().map(|q| (p - q).norm_squared()).enumerate();
        distances.fold((0, f64::INFINITY), |best, next| if next.1 < best.1 { next } else { best })
    };
    from.iter().map(of).map(|(k, squared)| (k, squared.sqrt())).collect()
}
