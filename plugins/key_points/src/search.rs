//! The greedy search itself.

use mimesh_core::{
    Error, Result,
    mesh::SurfacePoint,
    stage::{ChoiceStep, ChoiceWatch},
};

use crate::{
    candidates::{HandleRules, MIN_POINTS},
    course::Course,
    judge::{Judge, ROUNDING, Trial},
};

/// An error is less if it is so by more than this part: the rest is rounding, and exchanges could go round in circles.
const MIN_GAIN: f64 = 1e-9;

/// When the first stage ends.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    pub threshold: f64,
    pub min_count: usize,
    pub max_count: usize,
}

/// Why the first stage ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// The error is at most the threshold.
    Threshold,
    /// There are as many points as are allowed.
    MaxCount,
    /// Every candidate is chosen.
    Candidates,
    /// No other candidate can be judged.
    NotJudged,
    /// The user asked for it.
    Interrupted,
}

/// What the first stage did.
pub struct Added {
    pub ending: Ending,
    /// How many points there were before the best of these sets was kept.
    pub tried: usize,
}

/// What the second stage did.
pub struct Exchanged {
    /// Rounds that lowered the error.
    pub rounds: usize,
    /// Whether the limit of rounds ended it, though the last round helped.
    pub is_cut_short: bool,
}

/// A search on its way.
pub struct Search<'a> {
    points: &'a [SurfacePoint],
    rules: &'a HandleRules,
    watch: &'a dyn ChoiceWatch,
    course: Course<'a>,
    pub judge: Judge<'a>,
    /// The chosen candidates.
    pub chosen: Vec<usize>,
    /// Their error.
    pub error: f64,
    /// Every step that was kept.
    pub steps: Vec<ChoiceStep>,
}

impl<'a> Search<'a> {
    /// Begins with the candidates `first`.
    pub fn begin(
        points: &'a [SurfacePoint],
        rules: &'a HandleRules,
        mut judge: Judge<'a>,
        watch: &'a dyn ChoiceWatch,
        first: Vec<usize>,
    ) -> Result<Self> {
        let error = judge.error(&first)?;
        let course = Course::new(watch);
        let mut search = Self { points, rules, watch, course, judge, chosen: vec![], error, steps: vec![] };
        search.take(first, error, false);
        Ok(search)
    }

    /// The first stage: adds the best candidate, again and again, and keeps the best of the sets on the way.
    ///
    /// A point may raise the error where no other does better (algorithm 1, line 14), and a later one make up for it. Such sets
    /// wait until then, and are dropped if none does. Sets of too few points are kept in any case.
    ///
    /// At most `max_rounds` of exchanges are to follow.
    pub fn add(&mut self, limits: Limits, max_rounds: usize) -> Result<Added> {
        let (mut set, mut error) = (self.chosen.clone(), self.error);
        let mut waiting: Vec<(Vec<usize>, f64)> = Vec::new();
        let ending = loop {
            if self.watch.is_interrupted() {
                break Ending::Interrupted;
            }
            if error <= limits.threshold.max(ROUNDING) && self.is_enough(&set, limits) {
                break Ending::Threshold;
            }
            if set.len() >= limits.max_count {
                break Ending::MaxCount;
            }
            let trials = self.additions(&set);
            if trials.is_empty() {
                break Ending::Candidates;
            }
            let Some((trial, of_trial)) = self.judge.best_addition(trials, error) else {
                if self.watch.is_interrupted() {
                    break Ending::Interrupted;
                }
                if set.len() >= MIN_POINTS {
                    break Ending::NotJudged;
                }
                return Err(self.no_addition(set.len()));
            };
            (set, error) = (trial.handles, of_trial);
            self.course.added(set.len(), limits.max_count, max_rounds);
            let is_kept = !self.is_enough(&self.chosen, limits) || self.is_less(error);
            waiting.push((set.clone(), error));
            if is_kept {
                waiting.drain(..).for_each(|(set, error)| self.take(set, error, false));
            }
        };
        Ok(Added { ending, tried: set.len() })
    }

    /// The second stage: exchanges single points until no exchange helps.
    pub fn exchange(&mut self, max_rounds: usize) -> Exchanged {
        // Places tried since the last exchange.
        let mut unchanged = 0;
        for round in 0..max_rounds {
            let before = self.error;
            // The set as it is gives the measure of what ranks well enough to be judged.
            let mut worst = self.judge.worst_to_judge(&self.chosen);
            for place in 0..self.chosen.len() {
                if self.watch.is_interrupted() {
                    return Exchanged { rounds: round, is_cut_short: false };
                }
                // Every place was tried with this very set.
                if unchanged == self.chosen.len() {
                    return Exchanged { rounds: round, is_cut_short: false };
                }
                unchanged += 1;
                let trials = self.exchanges(place);
                if let Some((trial, error)) = self.judge.best_exchange(trials, worst)
                    && self.is_less(error)
                {
                    self.take(trial.handles, error, true);
                    unchanged = 0;
                    worst = self.judge.worst_to_judge(&self.chosen);
                }
                self.course.tried(self.chosen.len(), unchanged, max_rounds - round);
            }
            if self.error >= before {
                return Exchanged { rounds: round, is_cut_short: false };
            }
        }
        Exchanged { rounds: max_rounds, is_cut_short: max_rounds > 0 }
    }

    fn is_enough(&self, set: &[usize], limits: Limits) -> bool {
        set.len() >= limits.min_count && self.rules.span_enough(set)
    }

    fn is_less(&self, error: f64) -> bool {
        self.error > ROUNDING && error < self.error * (1.0 - MIN_GAIN)
    }

    /// The set with each other candidate.
    fn additions(&self, set: &[usize]) -> Vec<Trial> {
        let with = |candidate: usize| Trial { candidate, handles: [set, &[candidate]].concat() };
        (0..self.points.len()).filter(|k| !set.contains(k)).map(with).collect()
    }

    /// The chosen set with each other candidate at `place`, as far as it can serve.
    fn exchanges(&self, place: usize) -> Vec<Trial> {
        let with = |candidate: usize| {
            let mut handles = self.chosen.clone();
            handles[place] = candidate;
            Trial { candidate, handles }
        };
        let others = (0..self.points.len()).filter(|k| !self.chosen.contains(k));
        others.map(with).filter(|trial| self.rules.can_replace(&self.chosen, &trial.handles)).collect()
    }

    fn take(&mut self, set: Vec<usize>, error: f64, exchanged: bool) {
        self.chosen = set;
        self.error = error;
        let points = self.chosen.iter().map(|&k| self.points[k]).collect();
        let step = ChoiceStep { points, error, exchanged };
        self.watch.step(&step);
        self.steps.push(step);
    }

    /// The error of a choice that ends with too few points, since no candidate can be judged.
    fn no_addition(&mut self, count: usize) -> Error {
        let Some((candidate, failure)) = self.judge.not_judged.pop_first() else {
            return Error::data("no candidate can be judged", "look at the weights and the deformer of `key_points`");
        };
        let named = |message: String| {
            format!("no candidate can be added to {count} key points; {}: {message}", self.rules.name(candidate))
        };
        match failure.error {
            Error::Data { message, hint } => Error::Data { message: named(message), hint },
            other => Error::data(named(other.to_string()), "try another `sampler`, `weights` or `deformer`"),
        }
    }
}
