//! Which limb of one shape is which of another, under turns of their axes.

use mimesh_core::spatial::angle_between;
use nalgebra::{Matrix3, Vector3, Vector6};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{
    assignment::assign,
    shape::Shape,
    turn::{Frames, in_box, nearest_rotation, principal_axes, quarter_turns},
};

/// Fewer pairs say too little.
const MIN_PAIRS: usize = 3;

/// How a difference of mean distances compares to one of places in the bounding box.
const FAR: f64 = 0.5;

/// How normals compare to places in the bounding box, where shapes are laid on each other.
const NORMALS: f64 = 0.1;

/// What a limb without partner adds to a score.
const UNPAIRED: f64 = 0.05;

/// Two shapes that are turned against each other by less than this, in degrees, beside quarter turns, stand alike.
const MIN_ANGLE: f64 = 12.0;

/// How much worse a match in the axes of the source may be than one of the same limbs in other frames.
const OWN_AXES: f64 = 0.15;

/// So many of the best matches are looked at for a turn that is no quarter turn.
const REFINED: usize = 3;

/// Every so manieth point is laid on the other shape; more tell the same.
const STRIDE: usize = 4;

/// How much farther limbs may differ in other poses.
const OTHER_POSE: f64 = 1.5;

/// How far limbs may differ and still be the same.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Limits {
    /// The largest difference of two limbs that are the same: of their places in the bounding box, whose sides are 1, and half that
    /// of their mean distances.
    #[schemars(range(min = 0.0))]
    pub place: f64,
    /// The largest difference of a limb's distances to the others, on average and relative to the longest.
    #[schemars(range(min = 0.0))]
    pub distance: f64,
}

impl Default for Limits {
    fn default() -> Self {
        Self { place: 0.6, distance: 0.15 }
    }
}

impl Limits {
    /// The limits under which shapes in other poses are compared, as one with its arms stretched out and one with its arms down.
    pub fn of_other_poses(self) -> Self {
        Self { place: OTHER_POSE * self.place, distance: OTHER_POSE * self.distance }
    }
}

/// Limbs paired under one turn of the source.
#[derive(Clone, Debug)]
pub struct Match {
    /// The frames in which the shapes lie alike.
    pub frames: Frames,
    /// The limbs paired, ascending by that of the source.
    pub pairs: Vec<LimbPair>,
    /// The mean cost of the pairs.
    pub place: f64,
    /// The mean misfit of the pairs.
    pub distance: f64,
    /// How far the shapes lie from each other when they fill the same box.
    pub overlap: f64,
    /// Limbs of both shapes without partner.
    pub unpaired: usize,
}

/// A limb of the source and one of the target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimbPair {
    /// The limb of the source.
    pub source: usize,
    /// The limb of the target.
    pub target: usize,
    /// The mean difference of its distances to the others, relative to the longest.
    pub misfit: f64,
}

impl Match {
    /// Shapes that lie alike in `frames`, `overlap` apart, whatever limbs they have.
    pub fn alike(frames: Frames, overlap: f64) -> Self {
        Self { frames, pairs: vec![], place: 0.0, distance: 0.0, overlap, unpaired: 0 }
    }

    /// How badly the shapes fit; 0 is perfect.
    pub fn score(&self) -> f64 {
        self.place + self.distance + self.overlap + UNPAIRED * self.unpaired as f64
    }

    /// Whether one of two matches has all pairs of the other.
    fn agrees_with(&self, other: &Self) -> bool {
        let same = |a: &LimbPair| other.pairs.iter().any(|b| (a.source, a.target) == (b.source, b.target));
        self.pairs.iter().filter(|pair| same(pair)).count() == self.pairs.len().min(other.pairs.len())
    }
}

/// The matches of two shapes that pair limbs differently, best first.
///
/// The axes of the files turned by quarters come first, then principal axes. Where limbs so paired lie to each other as by another
/// turn, the target is turned back by that.
pub fn matches(source: &Shape, target: &Shape, limits: Limits) -> Vec<Match> {
    let own = [source, target].map(|shape| principal_axes(&shape.cloud.places));
    let quarters = quarter_turns();
    let frames = quarters.iter().map(|&turn| Frames { source: turn, target: Matrix3::identity() });
    let principal = quarters.iter().map(|turn| Frames { source: turn * own[0], target: own[1] });
    let frames: Vec<Frames> = frames.chain(principal).collect();
    let under = |frames: &Frames| match_under(source, target, *frames, limits);
    let mut all: Vec<Match> = frames.par_iter().filter_map(under).collect();
    let by_score = |a: &Match, b: &Match| a.score().total_cmp(&b.score());
    // The sort is stable: of equal ones the least turned comes first.
    all.sort_by(by_score);
    let turned: Vec<Frames> = all.iter().take(REFINED).filter_map(|found| fitted(source, target, found)).collect();
    all.extend(turned.par_iter().filter_map(under).collect::<Vec<_>>());
    all.sort_by(by_score);
    let mut distinct: Vec<Match> = Vec::new();
    for found in all {
        match distinct.iter_mut().find(|other| found.agrees_with(other)) {
            None => distinct.push(found),
            // Boxes along the axes of a file show best where limbs lie, as kinds of shapes share these.
            Some(other)
                if found.frames.keep_axes()
                    && !other.frames.keep_axes()
                    && found.score() < other.score() + OWN_AXES =>
            {
                *other = found;
            }
            Some(_) => {}
        }
    }
    distinct.sort_by(by_score);
    distinct
}

/// The frames in which the target is turned back to the axes of the source, as the limbs of a match say; `None` if these stand alike
/// but for quarter turns.
fn fitted(source: &Shape, target: &Shape, found: &Match) -> Option<Frames> {
    let tip = |shape: &Shape, limb: usize| shape.cloud.places[shape.limbs[limb].tip];
    let from: Vec<_> = found.pairs.iter().map(|pair| tip(source, pair.source)).collect();
    let to: Vec<_> = found.pairs.iter().map(|pair| tip(target, pair.target)).collect();
    let turn = nearest_rotation(&from, &to)?;
    let is_quarter = quarter_turns().iter().any(|quarter| angle_between(quarter, &turn) < MIN_ANGLE);
    (!is_quarter).then(|| Frames { source: Matrix3::identity(), target: turn.transpose() })
}

fn match_under(source: &Shape, target: &Shape, frames: Frames, limits: Limits) -> Option<Match> {
    let (a, b) = (in_box(&frames.source(source), 0.0), in_box(&frames.target(target), 0.0));
    let cost = |i: usize, j: usize| {
        let (i, j) = (source.limbs[i].tip, target.limbs[j].tip);
        (a[i] - b[j]).norm() + FAR * (source.far[i] - target.far[j]).abs()
    };
    let mut pairs = assign(source.limbs.len(), target.limbs.len(), limits.place, cost);
    let mut misfits = misfits(source, target, &pairs);
    while pairs.len() > MIN_PAIRS
        && let Some(worst) = (0..pairs.len()).reduce(|w, k| if misfits[k] > misfits[w] { k } else { w })
        && misfits[worst] >= limits.distance
    {
        pairs.remove(worst);
        misfits = self::misfits(source, target, &pairs);
    }
    if pairs.len() < MIN_PAIRS {
        return None;
    }
    let count = pairs.len() as f64;
    let (x, y) = with_normals(source, target, &frames);
    Some(Match {
        frames,
        place: pairs.iter().map(|&(i, j)| cost(i, j)).sum::<f64>() / count,
        distance: misfits.iter().sum::<f64>() / count,
        overlap: (mean_to_nearest(&x, &y) + mean_to_nearest(&y, &x)) / 2.0,
        unpaired: source.limbs.len() + target.limbs.len() - 2 * pairs.len(),
        pairs: pairs
            .into_iter()
            .zip(misfits)
            .map(|((source, target), misfit)| LimbPair { source, target, misfit })
            .collect(),
    })
}

/// For each pair the mean difference of its distances to the others, once those of the source are scaled to those of the target.
fn misfits(source: &Shape, target: &Shape, pairs: &[(usize, usize)]) -> Vec<f64> {
    let of = |(i, j): (usize, usize), (k, l): (usize, usize)| (source.between(i, k), target.between(j, l));
    let all = || pairs.iter().flat_map(|&p| pairs.iter().map(move |&q| of(p, q)));
    let squares: f64 = all().map(|(x, _)| x * x).sum();
    let scale = if squares > 0.0 { all().map(|(x, y)| x * y).sum::<f64>() / squares } else { 1.0 };
    let difference = |p, q| {
        let (x, y) = of(p, q);
        (scale * x - y).abs()
    };
    pairs.iter().map(|&p| pairs.iter().map(|&q| difference(p, q)).sum::<f64>() / pairs.len() as f64).collect()
}

/// Places in the common box and normals of both shapes, a vector a point.
pub fn with_normals(source: &Shape, target: &Shape, frames: &Frames) -> (Vec<Vector6<f64>>, Vec<Vector6<f64>>) {
    let joined = |places: Vec<Vector3<f64>>, turn: &Matrix3<f64>, shape: &Shape| {
        let normals = shape.cloud.normals.iter().map(|n| turn * n * NORMALS);
        places.into_iter().zip(normals).map(|(p, n)| Vector6::new(p.x, p.y, p.z, n.x, n.y, n.z)).collect()
    };
    (
        joined(in_box(&frames.source(source), 0.0), &frames.source, source),
        joined(in_box(&frames.target(target), 0.0), &frames.target, target),
    )
}

/// For each of `from` the nearest of `to`, the first of equals, and its distance.
pub fn distances(from: &[Vector6<f64>], to: &[Vector6<f64>]) -> Vec<(usize, f64)> {
    let of = |p: &Vector6<f64>| {
        let all = to.iter().map(|q| (p - q).norm_squared()).enumerate();
        all.fold((0, f64::INFINITY), |best, next| if next.1 < best.1 { next } else { best })
    };
    from.par_iter().map(of).map(|(k, squared)| (k, squared.sqrt())).collect()
}

/// The mean distance of points of `from` to the nearest of `to`.
fn mean_to_nearest(from: &[Vector6<f64>], to: &[Vector6<f64>]) -> f64 {
    let some: Vec<_> = from.iter().step_by(STRIDE).copied().collect();
    distances(&some, to).iter().map(|(_, distance)| distance).sum::<f64>() / some.len() as f64
}
