//! Shapes without limbs, as faces: where they lie alike, points at the same place correspond.

use mimesh_core::spatial::angle_between;
use nalgebra::{Matrix3, Point3};
use rayon::prelude::*;

use super::{
    matching::{Match, distances, with_normals},
    shape::Shape,
    tips::Tip,
    turn::{Frames, in_box, principal_axes, quarter_turns},
};

/// Frames whose turns differ by less than this, in degrees, are one.
const SAME_TURN: f64 = 30.0;

/// Points farther from each other in the common box, with normals, do not correspond.
const MAX_DISTANCE: f64 = 0.1;

/// Shapes that lie farther from each other in the common box, with normals, do not lie alike.
pub const MAX_OVERLAP: f64 = 0.12;

/// The turns under which two shapes lie alike, best first, as matches without limbs.
pub fn alike(source: &Shape, target: &Shape) -> Vec<Match> {
    let own = [source, target].map(|shape| principal_axes(&shape.cloud.places));
    let quarters = quarter_turns();
    let frames = quarters.iter().map(|&turn| Frames { source: turn, target: Matrix3::identity() });
    let principal = quarters.iter().map(|turn| Frames { source: turn * own[0], target: own[1] });
    let frames: Vec<Frames> = frames.chain(principal).collect();
    let overlap = |frames: &Frames| {
        let (x, y) = with_normals(source, target, frames);
        let mean =
            |distances: Vec<(usize, f64)>| distances.iter().map(|(_, d)| d).sum::<f64>() / distances.len() as f64;
        (mean(distances(&x, &y)) + mean(distances(&y, &x))) / 2.0
    };
    let overlaps: Vec<f64> = frames.par_iter().map(overlap).collect();
    let mut all: Vec<Match> =
        frames.into_iter().zip(overlaps).map(|(frames, overlap)| Match::alike(frames, overlap)).collect();
    all.sort_by(|a, b| a.overlap.total_cmp(&b.overlap));
    let mut distinct: Vec<Match> = Vec::new();
    for found in all.into_iter().filter(|found| found.overlap <= MAX_OVERLAP) {
        if distinct.iter().all(|other| angle_between(&other.frames.turn(), &found.frames.turn()) > SAME_TURN) {
            distinct.push(found);
        }
    }
    distinct
}

/// At most `most` points that lie at the same place under `frames`, each as far as can be from those before.
pub fn spread(source: &Shape, target: &Shape, frames: &Frames, most: usize) -> Vec<Tip> {
    let (x, y) = with_normals(source, target, frames);
    let (to_target, to_source) = (distances(&x, &y), distances(&y, &x));
    let is_mutual = |&i: &usize| to_source[to_target[i].0].0 == i && to_target[i].1 < MAX_DISTANCE;
    let candidates: Vec<usize> = (0..x.len()).filter(is_mutual).collect();
    let places: Vec<Point3<f64>> = in_box(&frames.source(source), 0.0).into_iter().map(Point3::from).collect();
    // The first is the one that lies closest.
    let mut next = candidates.iter().copied().reduce(|a, b| if to_target[b].1 < to_target[a].1 { b } else { a });
    let mut near = vec![f64::INFINITY; candidates.len()];
    let mut chosen = Vec::new();
    while let Some(i) = next.filter(|_| chosen.len() < most) {
        chosen.push(Tip { source: i, target: to_target[i].0, distance: to_target[i].1 });
        candidates.iter().zip(&mut near).for_each(|(&c, d)| *d = d.min((places[c] - places[i]).norm()));
        let farthest = (0..candidates.len()).reduce(|a, b| if near[b] > near[a] { b } else { a });
        next = farthest.filter(|&k| near[k] > 0.0).map(|k| candidates[k]);
    }
    chosen
}
