//! k-means: divides points into k clusters about their means, least squares.
//!
//! Lloyd's iteration from given clusters or a k-means++ start (Arthur and Vassilvitskii 2007), with the bounds of Hamerly (2010): a point whose
//! distance to its own centre is surely below that to any other is passed over, which changes nothing in the result. A cluster
//! that runs empty takes the point farthest from its centre. A point leaves its cluster only for a centre that is strictly
//! nearer, and everything is summed in the order of points, so equal inputs give equal clusters.

use mimesh_core::{Figures, random::Random, stage::Regions};
use pulp::{Arch, NullaryFnOnce};

use crate::{
    points::{Points, square_distance},
    start::{Nearest, given, plus_plus},
};

/// How to divide.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Kmeans {
    /// k; fewer clusters come out where there are fewer distinct points.
    pub clusters: usize,
    pub restarts: usize,
    pub max_iterations: usize,
    pub seed: u64,
}

/// Points divided.
#[derive(Clone, Debug)]
pub(crate) struct Clustering {
    pub of_point: Vec<u32>,
    /// Σ of squared distances to the mean of the own cluster.
    pub inertia: f64,
    pub iterations: usize,
    pub converged: bool,
}

impl Kmeans {
    /// The best of all starts as regions, numbered by their first vertex; `first` as in [`run`](Self::run).
    pub(crate) fn regions(&self, points: &Points, first: Option<Vec<u32>>) -> Regions {
        let best = self.run(points, first);
        let mut numbers = vec![None; self.clusters];
        let mut count = 0;
        let of_vertex = best.of_point.iter().map(|&cluster| {
            *numbers[cluster as usize].get_or_insert_with(|| {
                count += 1;
                count - 1
            })
        });
        let of_vertex: Vec<u32> = of_vertex.collect();
        let mut figures = Figures::default();
        figures.set("regions", count);
        figures.set("inertia", best.inertia);
        figures.set("iterations", best.iterations);
        figures.set("converged", best.converged);
        Regions { of_vertex, count: count as usize, figures }
    }

    /// The clustering of least inertia among all starts: one from the clusters `first` if given, others from random centres.
    pub(crate) fn run(&self, points: &Points, first: Option<Vec<u32>>) -> Clustering {
        let mut random = Random::new(self.seed);
        let mut best = match first {
            Some(clusters) => self.from(points, given(points, self.clusters, &clusters)),
            None => self.from(points, plus_plus(points, self.clusters, &mut random)),
        };
        for _ in 1..self.restarts {
            let next = self.from(points, plus_plus(points, self.clusters, &mut random));
            if next.inertia < best.inertia {
                best = next;
            }
        }
        best
    }

    fn from(&self, points: &Points, (centres, nearest): (Points, Vec<Nearest>)) -> Clustering {
        Arch::new().dispatch(Iteration { points, centres, nearest, max_iterations: self.max_iterations })
    }
}

/// Lloyd's iteration.
struct Iteration<'a> {
    points: &'a Points,
    centres: Points,
    nearest: Vec<Nearest>,
    max_iterations: usize,
}

// Inlined, with all that takes time, into the function that the processor's instructions are chosen for.
impl NullaryFnOnce for Iteration<'_> {
    type Output = Clustering;

    #[inline(always)]
    fn call(self) -> Clustering {
        let Self { points, mut centres, mut nearest, max_iterations } = self;
        let mut iterations = 0;
        let mut converged = false;
        while !converged && iterations < max_iterations {
            iterations += 1;
            let moves = update(points, &mut centres, &mut nearest);
            converged = !assign(points, &centres, &mut nearest, &moves);
        }
        update(points, &mut centres, &mut nearest);
        let own = points.rows().zip(&nearest).map(|(x, n)| square_distance(x, centres.row(n.cluster as usize)));
        let inertia = own.sum();
        Clustering { of_point: nearest.iter().map(|n| n.cluster).collect(), inertia, iterations, converged }
    }
}

/// Moves each centre to the mean of its cluster and returns how far.
#[inline(always)]
fn update(points: &Points, centres: &mut Points, nearest: &mut [Nearest]) -> Vec<f64> {
    let mut means = means(points, centres, nearest);
    while let Some(empty) = means.counts.iter().position(|&count| count == 0) {
        let Some(farthest) = farthest(points, &means, nearest) else { break };
        // Nothing is known of the point's other distances.
        nearest[farthest] = Nearest { cluster: empty as u32, upper: f64::INFINITY, lower: 0.0 };
        means = self::means(points, centres, nearest);
    }
    let distance = |c: usize| square_distance(means.centres.row(c), centres.row(c)).sqrt();
    let moves = (0..centres.len()).map(distance).collect();
    *centres = means.centres;
    moves
}

struct Means {
    /// The mean of each cluster; of an empty one the centre it had.
    centres: Points,
    counts: Vec<usize>,
}

#[inline(always)]
fn means(points: &Points, before: &Points, nearest: &[Nearest]) -> Means {
    let mut centres = before.like(before.len());
    let mut counts = vec![0; before.len()];
    for (x, n) in points.rows().zip(nearest) {
        counts[n.cluster as usize] += 1;
        centres.row_mut(n.cluster as usize).iter_mut().zip(x).for_each(|(sum, x)| *sum += x);
    }
    for (c, &count) in counts.iter().enumerate() {
        if count == 0 {
            centres.row_mut(c).copy_from_slice(before.row(c));
        } else {
            centres.row_mut(c).iter_mut().for_each(|x| *x /= count as f64);
        }
    }
    Means { centres, counts }
}

/// The point farthest from its centre among clusters of more than one point; `None` if all are on their centres.
fn farthest(points: &Points, means: &Means, nearest: &[Nearest]) -> Option<usize> {
    let mut best = (0.0, None);
    for (i, (x, n)) in points.rows().zip(nearest).enumerate() {
        let cluster = n.cluster as usize;
        let distance = square_distance(x, means.centres.row(cluster));
        if means.counts[cluster] > 1 && distance > best.0 {
            best = (distance, Some(i));
        }
    }
    best.1
}

/// Gives each point to its nearest centre, after the centres have moved by `moves`; whether any point changed its cluster.
#[inline(always)]
fn assign(points: &Points, centres: &Points, nearest: &mut [Nearest], moves: &[f64]) -> bool {
    let gaps = half_gaps(centres);
    let largest = (0..moves.len()).max_by(|&a, &b| moves[a].total_cmp(&moves[b]).then(b.cmp(&a))).unwrap_or(0);
    let second = moves.iter().enumerate().filter(|(c, _)| *c != largest).map(|(_, m)| *m).fold(0.0, f64::max);
    let mut changed = false;
    for (x, n) in points.rows().zip(nearest) {
        let own = n.cluster as usize;
        n.upper += moves[own];
        n.lower -= if own == largest { second } else { moves[largest] };
        let others = n.lower.max(gaps[own]);
        if surely_less(n.upper, others) {
            continue;
        }
        let square = square_distance(x, centres.row(own));
        n.upper = square.sqrt();
        if surely_less(n.upper, others) {
            continue;
        }
        *n = Nearest::among(x, centres, n.cluster);
        changed |= n.cluster as usize != own;
    }
    changed
}

/// Bounds carry the rounding of many additions.
fn surely_less(a: f64, b: f64) -> bool {
    a < b * (1.0 - 1e-12)
}

/// For each centre half the distance to the nearest other: a point closer than that is nearest to it.
fn half_gaps(centres: &Points) -> Vec<f64> {
    let mut squares = vec![f64::INFINITY; centres.len()];
    for a in 0..centres.len() {
        for b in 0..a {
            let square = square_distance(centres.row(a), centres.row(b));
            squares[a] = squares[a].min(square);
            squares[b] = squares[b].min(square);
        }
    }
    squares.into_iter().map(|square| 0.5 * square.sqrt()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points about a few places, of which some overlap.
    fn cloud(seed: u64, count: usize, dimensions: usize, places: usize) -> Points {
        let mut random = Random::new(seed);
        let about: Vec<Vec<f64>> =
            (0..places).map(|_| (0..dimensions).map(|_| random.between(-2.0, 2.0)).collect()).collect();
        let mut points = Points::zeros(count, dimensions);
        for i in 0..count {
            let place = &about[random.index(places)];
            for (x, middle) in points.row_mut(i).iter_mut().zip(place) {
                *x = middle + random.between(-1.0, 1.0);
            }
        }
        points
    }

    /// The same iteration with every distance computed.
    fn plain(points: &Points, settings: Kmeans) -> Vec<u32> {
        let (mut centres, mut nearest) = plus_plus(points, settings.clusters, &mut Random::new(settings.seed));
        for _ in 0..settings.max_iterations {
            update(points, &mut centres, &mut nearest);
            let next: Vec<_> =
                points.rows().zip(&nearest).map(|(x, n)| Nearest::among(x, &centres, n.cluster)).collect();
            let same = next.iter().zip(&nearest).all(|(a, b)| a.cluster == b.cluster);
            nearest = next;
            if same {
                break;
            }
        }
        nearest.iter().map(|n| n.cluster).collect()
    }

    #[test]
    fn passing_over_points_changes_nothing() {
        for seed in 0..40 {
            let points = cloud(seed, 300, 1 + seed as usize % 20, 5);
            let settings = Kmeans { clusters: 2 + seed as usize % 11, restarts: 1, max_iterations: 100, seed };
            assert_eq!(settings.run(&points, None).of_point, plain(&points, settings), "seed {seed}");
        }
    }

    #[test]
    fn more_restarts_are_never_worse() {
        let points = cloud(3, 200, 4, 9);
        let inertia =
            |restarts| Kmeans { clusters: 9, restarts, max_iterations: 100, seed: 1 }.run(&points, None).inertia;
        let found: Vec<_> = [1, 2, 4, 8, 16].map(inertia).to_vec();
        assert!(found.is_sorted_by(|a, b| a >= b), "{found:?}");
    }

    #[test]
    fn fewer_distinct_points_than_clusters_leave_no_region_empty() {
        let mut points = Points::zeros(10, 2);
        (0..10).for_each(|i| points.row_mut(i)[0] = (i % 3) as f64);
        let regions = Kmeans { clusters: 7, restarts: 3, max_iterations: 10, seed: 0 }.regions(&points, None);
        assert_eq!(regions.count, 3);
        assert_eq!(regions.of_vertex, [0, 1, 2, 0, 1, 2, 0, 1, 2, 0]);
    }

    #[test]
    fn an_empty_cluster_takes_the_point_farthest_from_its_centre() {
        let mut points = Points::zeros(5, 1);
        [0.0, 1.0, 2.0, 9.0, 10.0].iter().enumerate().for_each(|(i, &x)| points.row_mut(i)[0] = x);
        let mut centres = Points::zeros(3, 1);
        let mut nearest = vec![Nearest { cluster: 0, upper: 0.0, lower: 0.0 }; 5];
        nearest[4].cluster = 2;
        update(&points, &mut centres, &mut nearest);
        assert_eq!(nearest[3].cluster, 1, "9 is farthest from the mean of 0, 1, 2 and 9");
        assert_eq!((centres.row(0)[0], centres.row(1)[0], centres.row(2)[0]), (1.0, 9.0, 10.0));
    }
}
