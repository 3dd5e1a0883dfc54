//! Starts of k-means: from given clusters, or from centres spread by k-means++ (Arthur and Vassilvitskii 2007).

use mimesh_core::random::Random;
use nalgebra::DMatrix;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::points::{Points, square_distance, square_distance_below};

/// The clusters that the first start of a clusterer begins with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Start {
    /// Each vertex with the handle that moves it most, where there are as many regions as handles (else as `plus_plus`). On
    /// bodies it ends about where the best of 16 random starts does, and a handle more or less changes the regions near it only.
    #[default]
    Handles,
    /// Those nearest to random centres that are far from each other (k-means++).
    PlusPlus,
}

impl Start {
    /// The clusters of the first start; `None` if it is random.
    pub(crate) fn clusters(self, weights: &DMatrix<f64>, clusters: usize) -> Option<Vec<u32>> {
        // The first of the largest, where several are.
        let largest = |i: usize| {
            let row = weights.row(i);
            (1..row.len()).fold(0, |best, k| if row[k] > row[best] { k } else { best }) as u32
        };
        (self == Self::Handles && clusters == weights.ncols()).then(|| (0..weights.nrows()).map(largest).collect())
    }
}

/// A point's cluster, with bounds of its distances to centres.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Nearest {
    /// The cluster it belongs to.
    pub cluster: u32,
    /// An upper bound of the distance to the centre of that cluster.
    pub upper: f64,
    /// A lower bound of the distance to any other centre.
    pub lower: f64,
}

impl Nearest {
    /// The nearest of all centres: `own` unless another is strictly nearer to `x`, then the first of the nearest.
    #[inline(always)]
    pub(crate) fn among(x: &[f64], centres: &Points, own: u32) -> Self {
        let mut best = (own, square_distance_below(x, centres.row(own as usize), f64::INFINITY));
        let mut second = f64::INFINITY;
        for (c, centre) in centres.rows().enumerate() {
            if c as u32 != own {
                let square = square_distance_below(x, centre, second);
                if square < best.1 {
                    second = best.1;
                    best = (c as u32, square);
                } else {
                    second = second.min(square);
                }
            }
        }
        Self { cluster: best.0, upper: best.1.sqrt(), lower: second.sqrt() }
    }
}

/// `count` centres that are yet to be computed, and the points in the clusters `of_point`.
pub(crate) fn given(points: &Points, count: usize, of_point: &[u32]) -> (Points, Vec<Nearest>) {
    let unknown = |&cluster: &u32| Nearest { cluster, upper: f64::INFINITY, lower: 0.0 };
    (points.like(count), of_point.iter().map(unknown).collect())
}

/// At most `count` different points as centres, each drawn with a probability in proportion to its squared distance from those
/// before it, and the nearest of them to each point.
pub(crate) fn plus_plus(points: &Points, count: usize, random: &mut Random) -> (Points, Vec<Nearest>) {
    let mut chosen = vec![random.index(points.len())];
    let first = points.row(chosen[0]);
    let mut nearest: Vec<_> =
        points.rows().map(|x| Nearest { cluster: 0, upper: square_distance(x, first), lower: f64::INFINITY }).collect();
    while chosen.len() < count {
        let Some(next) = draw(&nearest, random) else { break };
        let centre = points.row(next);
        for (x, n) in points.rows().zip(&mut nearest) {
            let square = square_distance_below(x, centre, n.lower);
            if square < n.upper {
                *n = Nearest { cluster: chosen.len() as u32, upper: square, lower: n.upper };
            } else {
                n.lower = n.lower.min(square);
            }
        }
        chosen.push(next);
    }
    for n in &mut nearest {
        (n.upper, n.lower) = (n.upper.sqrt(), n.lower.sqrt());
    }
    let mut centres = points.like(chosen.len());
    chosen.iter().enumerate().for_each(|(c, &i)| centres.row_mut(c).copy_from_slice(points.row(i)));
    (centres, nearest)
}

/// A point by its squared distance `upper`; `None` if all are 0.
fn draw(nearest: &[Nearest], random: &mut Random) -> Option<usize> {
    let total: f64 = nearest.iter().map(|n| n.upper).sum();
    let mut left = random.unit() * total;
    let mut last = None;
    for (i, n) in nearest.iter().enumerate().filter(|(_, n)| n.upper > 0.0) {
        last = Some(i);
        left -= n.upper;
        if left < 0.0 {
            break;
        }
    }
    // Rounding may leave a little at the end.
    last
}
