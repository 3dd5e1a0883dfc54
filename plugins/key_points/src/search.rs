//! The greedy search itself.

use mimesh_core::{
    Error, Result,
    mesh::SurfacePoint,
    stage::{BoundClusterer, BoundDeformer, BoundWeights, ChoiceStep, ChoiceWatch},
};
use nalgebra::Point3;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::measure::Measure;

/// An exchange counts if it lowers the error by more than this part: less is rounding, and could go round in circles.
const MIN_GAIN: f64 = 1e-9;

/// An exchange that ranks worse than what is there by more than this part is not worth the cost of judging it.
const RANKING_SLACK: f64 = 0.02;

/// Half the longest way across the bounding box's centre: the radius that scales the source into the unit sphere.
pub fn unit_radius(positions: &[Point3<f64>]) -> f64 {
    let mut low = positions[0];
    let mut high = positions[0];
    for p in positions {
        low = low.inf(p);
        high = high.sup(p);
    }
    let centre = nalgebra::center(&low, &high);
    let radius = positions.iter().map(|p| (p - centre).norm()).fold(0.0, f64::max);
    if radius > 0.0 { radius } else { 1.0 }
}

/// Tells how far the poses are missed with a set of candidates as handles.
pub struct Evaluator<'a> {
    pub weights: Box<dyn BoundWeights>,
    pub regions: &'a dyn BoundClusterer,
    pub deformer: &'a dyn BoundDeformer,
    pub poses: &'a [Vec<Point3<f64>>],
    pub measure: Measure,
    pub unit: f64,
}

impl Evaluator<'_> {
    pub fn error(&self, handles: &[usize]) -> Result<f64> {
        let weights = self.weights.solve(handles)?;
        let regions = self.regions.cluster(&weights.matrix)?;
        let skin = self.deformer.skin(&weights, &regions)?;
        let mut total = 0.0;
        for pose in self.poses {
            let fit = skin.fit(pose)?;
            let distances = fit.positions.iter().zip(pose).map(|(q, p)| (q - p).norm());
            let count = pose.len() as f64;
            total += match self.measure {
                Measure::Mean => distances.sum::<f64>() / count,
                Measure::Frobenius => distances.map(|d| d * d).sum::<f64>().sqrt() / count,
            };
        }
        let error = total / self.poses.len() as f64 / self.unit;
        if error.is_finite() {
            Ok(error)
        } else {
            Err(Error::data("the poses give no finite error", "look for vertices that are not finite in the poses"))
        }
    }
}

/// A search on its way.
pub struct Search<'a> {
    points: &'a [SurfacePoint],
    exact: &'a Evaluator<'a>,
    ranking: Option<&'a Evaluator<'a>>,
    shortlist: usize,
    watch: &'a dyn ChoiceWatch,
    /// The chosen candidates.
    pub chosen: Vec<usize>,
    /// Their error.
    pub error: f64,
    /// Every step that was kept.
    pub steps: Vec<ChoiceStep>,
    /// How many sets were judged.
    pub judged: usize,
    /// How many sets were ranked.
    pub ranked: usize,
}

impl<'a> Search<'a> {
    pub fn new(
        points: &'a [SurfacePoint],
        exact: &'a Evaluator<'a>,
        ranking: Option<&'a Evaluator<'a>>,
        shortlist: usize,
        watch: &'a dyn ChoiceWatch,
    ) -> Self {
        let (chosen, steps) = (vec![], vec![]);
        Self { points, exact, ranking, shortlist, watch, chosen, error: f64::INFINITY, steps, judged: 0, ranked: 0 }
    }

    /// Begins with these candidates.
    pub fn begin(&mut self, first: Vec<usize>) -> Result<()> {
        let error = self.exact.error(&first)?;
        self.judged += 1;
        self.take(first, error, false);
        Ok(())
    }

    /// The first stage: adds candidates until the error is below `threshold` or there are `count`.
    pub fn add(&mut self, threshold: f64, count: usize) -> Result<()> {
        while self.error > threshold && self.chosen.len() < count.min(self.points.len()) && !self.watch.is_interrupted()
        {
            let sets: Vec<Vec<usize>> = self.others().map(|k| [&self.chosen[..], &[k]].concat()).collect();
            let Some((set, error)) = self.best(sets, f64::INFINITY)? else { break };
            // A point more can do harm to maps found with regions; the paper adds it all the same. Here it ends the stage.
            if error >= self.error {
                break;
            }
            self.take(set, error, false);
        }
        Ok(())
    }

    /// The second stage: exchanges single points until no exchange helps; returns the number of rounds.
    pub fn exchange(&mut self, max_rounds: usize) -> Result<usize> {
        for round in 0..max_rounds {
            let before = self.error;
            // The set as it is gives the measure of what ranks well enough to be judged.
            let mut worst = self.worst_to_judge();
            for place in 0..self.chosen.len() {
                if self.watch.is_interrupted() {
                    return Ok(round);
                }
                let with = |k: usize| {
                    let mut set = self.chosen.clone();
                    set[place] = k;
                    set
                };
                let sets: Vec<Vec<usize>> = self.others().map(with).collect();
                if let Some((set, error)) = self.best(sets, worst)?
                    && error < self.error * (1.0 - MIN_GAIN)
                {
                    self.take(set, error, true);
                    worst = self.worst_to_judge();
                }
            }
            if self.error >= before {
                return Ok(round);
            }
        }
        Ok(max_rounds)
    }

    /// The error by ranking up to which an exchange is judged.
    fn worst_to_judge(&self) -> f64 {
        let of_now = self.ranking.and_then(|ranking| ranking.error(&self.chosen).ok());
        of_now.map_or(f64::INFINITY, |error| error * (1.0 + RANKING_SLACK))
    }

    fn others(&self) -> impl Iterator<Item = usize> {
        (0..self.points.len()).filter(|k| !self.chosen.contains(k))
    }

    fn take(&mut self, set: Vec<usize>, error: f64, exchanged: bool) {
        self.chosen = set;
        self.error = error;
        let points = self.chosen.iter().map(|&k| self.points[k]).collect();
        let step = ChoiceStep { points, error, exchanged };
        self.watch.step(&step);
        self.steps.push(step);
    }

    /// The set of least error, and its error; `None` if none can be judged, as when a component is left without a handle, or
    /// none ranks better than `worst`.
    fn best(&mut self, sets: Vec<Vec<usize>>, worst: f64) -> Result<Option<(Vec<usize>, f64)>> {
        let mut short: Vec<Vec<usize>> = match self.ranking {
            None => sets,
            Some(ranking) => {
                self.ranked += sets.len();
                let mut ranked = self.errors(ranking, &sets);
                ranked.retain(|(_, error)| *error <= worst);
                ranked.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
                ranked.truncate(self.shortlist);
                ranked.into_iter().map(|(i, _)| sets[i].clone()).collect()
            }
        };
        self.judged += short.len();
        let errors = self.errors(self.exact, &short);
        // An interrupted step has seen some of the sets only, whose best may be another than that of all.
        if self.watch.is_interrupted() {
            return Ok(None);
        }
        let best = errors.into_iter().min_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
        Ok(best.map(|(i, error)| (short.swap_remove(i), error)))
    }

    /// The errors of the sets that can be judged, by their numbers.
    fn errors(&self, judge: &Evaluator<'_>, sets: &[Vec<usize>]) -> Vec<(usize, f64)> {
        let done = AtomicUsize::new(0);
        let error = |(i, set): (usize, &Vec<usize>)| {
            if self.watch.is_interrupted() {
                return None;
            }
            let error = judge.error(set).ok();
            self.watch.progress(done.fetch_add(1, Ordering::Relaxed) + 1, sets.len());
            Some((i, error?))
        };
        sets.par_iter().enumerate().filter_map(error).collect()
    }
}
