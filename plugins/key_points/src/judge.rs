//! Judges sets of handles, and remembers which could not be judged.

use std::collections::{BTreeMap, HashMap};

use mimesh_core::{
    Error, Result,
    stage::{ChoiceWatch, HandleWeights},
};
use rayon::prelude::*;

use crate::evaluator::Evaluator;

/// An error up to this, with the source in the unit sphere, is rounding: no set is better than another.
pub const ROUNDING: f64 = 1e-12;

/// An exchange that ranks worse than the present set by more than this part is not worth the cost of judging it.
const RANKING_SLACK: f64 = 0.02;

/// Sets whose weights are solved for together: enough to fill the lanes of a factorisation, few enough for memory.
const TOGETHER: usize = 8;

/// A set of handles to judge.
#[derive(Clone)]
pub struct Trial {
    /// The candidate that is new in the set.
    pub candidate: usize,
    pub handles: Vec<usize>,
}

/// The sets with a candidate that could not be judged or ranked.
pub struct Failure {
    pub sets: usize,
    /// What the first of them said.
    pub error: Error,
}

/// Judges sets by the weights themselves, those first that rank best by weights that cost little.
pub struct Judge<'a> {
    exact: &'a Evaluator<'a>,
    /// Without it all sets are judged.
    ranking: Option<&'a Evaluator<'a>>,
    shortlist: usize,
    watch: &'a dyn ChoiceWatch,
    /// The errors of the sets judged so far, by their handles in order; `None` for those that could not be.
    known: HashMap<Vec<usize>, Option<f64>>,
    /// How many sets were judged.
    pub judged: usize,
    /// How many sets were ranked.
    pub ranked: usize,
    /// Sets that could not be judged, by candidate.
    pub not_judged: BTreeMap<usize, Failure>,
    /// Sets that could not be ranked, by candidate.
    pub not_ranked: BTreeMap<usize, Failure>,
}

impl<'a> Judge<'a> {
    pub fn new(
        exact: &'a Evaluator<'a>,
        ranking: Option<&'a Evaluator<'a>>,
        shortlist: usize,
        watch: &'a dyn ChoiceWatch,
    ) -> Self {
        let (not_judged, not_ranked) = (BTreeMap::new(), BTreeMap::new());
        Self { exact, ranking, shortlist, watch, known: HashMap::new(), judged: 0, ranked: 0, not_judged, not_ranked }
    }

    /// The error of one set.
    pub fn error(&mut self, handles: &[usize]) -> Result<f64> {
        self.judged += 1;
        self.exact.error(handles)
    }

    /// The trial of least error, and its error; `None` if interrupted, or if no trial can be judged.
    ///
    /// The best ranked trials are judged first, and all of them only if none before is below `error`.
    pub fn best_addition(&mut self, trials: Vec<Trial>, error: f64) -> Option<(Trial, f64)> {
        let ranked = self.rank(trials, f64::INFINITY);
        self.best_until(&ranked, error)
    }

    /// Judges a short list, then twice as many, and so on, as long as none is below `error`; without a ranking all at once.
    fn best_until(&mut self, ranked: &[Trial], error: f64) -> Option<(Trial, f64)> {
        let mut count = if self.ranking.is_some() { self.shortlist } else { ranked.len() };
        let mut left = ranked;
        let mut best: Option<(Trial, f64)> = None;
        while !left.is_empty() {
            let (group, others) = left.split_at(count.min(left.len()));
            best = best.into_iter().chain(self.judge(group)).reduce(better);
            // An interrupted step has seen some of the sets only, whose best may be another than that of all.
            if self.watch.is_interrupted() {
                return None;
            }
            if best.as_ref().is_some_and(|best| best.1 < error || error <= ROUNDING) {
                break;
            }
            left = others;
            count = count.saturating_mul(2);
        }
        best
    }

    /// The trial of least error among the short list of those that rank up to `worst`, and its error.
    pub fn best_exchange(&mut self, trials: Vec<Trial>, worst: f64) -> Option<(Trial, f64)> {
        let mut ranked = self.rank(trials, worst);
        if self.ranking.is_some() {
            ranked.truncate(self.shortlist);
        }
        let judged = self.judge(&ranked);
        if self.watch.is_interrupted() { None } else { judged.into_iter().reduce(better) }
    }

    /// The error by ranking up to which an exchange in this set is judged.
    pub fn worst_to_judge(&self, handles: &[usize]) -> f64 {
        // Where the set itself cannot be ranked, ranks exclude no exchange.
        let of_now = self.ranking.and_then(|ranking| ranking.error(handles).ok());
        of_now.map_or(f64::INFINITY, |error| error * (1.0 + RANKING_SLACK))
    }

    /// The trials that rank up to `worst`, the best first, then those that cannot be ranked; all as they are without a ranking.
    fn rank(&mut self, trials: Vec<Trial>, worst: f64) -> Vec<Trial> {
        let Some(ranking) = self.ranking else { return trials };
        self.ranked += trials.len();
        let mut ranked = Vec::with_capacity(trials.len());
        let mut unranked = Vec::new();
        for (trial, error) in self.errors(ranking, &trials) {
            match error {
                Ok(error) if error <= worst => ranked.push((trial, error)),
                Ok(_) => {}
                Err(error) => {
                    record(&mut self.not_ranked, trial.candidate, error);
                    unranked.push(trial);
                }
            }
        }
        // A stable sort: equal ranks stay in the order of the candidates.
        ranked.sort_by(|a, b| a.1.total_cmp(&b.1));
        ranked.into_iter().map(|(trial, _)| trial).chain(unranked).collect()
    }

    /// The trials that can be judged, with their errors. A set that was judged before is not judged again.
    fn judge(&mut self, trials: &[Trial]) -> Vec<(Trial, f64)> {
        let new: Vec<Trial> = trials.iter().filter(|trial| !self.known.contains_key(&trial.handles)).cloned().collect();
        self.judged += new.len();
        for (trial, error) in self.errors(self.exact, &new) {
            let error = error.map_err(|error| record(&mut self.not_judged, trial.candidate, error)).ok();
            self.known.insert(trial.handles, error);
        }
        let known = |trial: &Trial| Some((trial.clone(), (*self.known.get(&trial.handles)?)?));
        trials.iter().filter_map(known).collect()
    }

    /// The trials with their errors; without those that an interrupt leaves out.
    fn errors(&self, evaluator: &Evaluator<'_>, trials: &[Trial]) -> Vec<(Trial, Result<f64>)> {
        let error = |(trial, weights): (&Trial, Result<HandleWeights>)| {
            if self.watch.is_interrupted() {
                return None;
            }
            Some((trial.clone(), weights.and_then(|weights| evaluator.error_of(&weights))))
        };
        let of_some = |some: &[Trial]| -> Vec<(Trial, Result<f64>)> {
            if self.watch.is_interrupted() {
                return vec![];
            }
            let sets: Vec<&[usize]> = some.iter().map(|trial| &*trial.handles).collect();
            let weights = evaluator.weights.solve_all(&sets);
            some.par_iter().zip(weights).filter_map(error).collect()
        };
        trials.chunks(TOGETHER.max(rayon::current_num_threads())).flat_map(of_some).collect()
    }
}

/// The one of less error; of equals the first.
fn better(a: (Trial, f64), b: (Trial, f64)) -> (Trial, f64) {
    if b.1 < a.1 { b } else { a }
}

fn record(failures: &mut BTreeMap<usize, Failure>, candidate: usize, error: Error) {
    failures.entry(candidate).or_insert(Failure { sets: 0, error }).sets += 1;
}
