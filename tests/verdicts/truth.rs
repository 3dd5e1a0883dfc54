//! What is truly good or bad, and how often verdicts agree.

use std::{collections::BTreeMap, fmt};

use mimesh_pipeline::metrics::Level;

use crate::JudgedPose;

/// How good a result is by its true error.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Truth {
    Good,
    /// A verdict may be anything.
    Either,
    Bad,
}

impl Truth {
    /// By the mean error, the largest offset of a component, the largest error of a vertex and the mean motion of the known pose, all
    /// in percent of the diagonal.
    pub fn new(mean: f64, component: f64, vertex: f64, motion: f64) -> Self {
        let is_small = motion < 5.0;
        if mean > 5.0 || component > 5.0 || vertex > if is_small { 1.5 } else { 15.0 } {
            Self::Bad
        } else if mean < 1.0 && component <= 2.0 && vertex <= if is_small { 1.0 } else { 5.0 } {
            Self::Good
        } else {
            Self::Either
        }
    }
}

/// Counts of poses by truth and verdict.
#[derive(Default)]
pub struct Table {
    counts: BTreeMap<(Truth, Level), usize>,
    /// The counts of wrong verdicts, by case and fault.
    wrong: BTreeMap<(Truth, String), usize>,
}

impl Table {
    /// Counts a pose.
    pub fn add(&mut self, pose: &JudgedPose) {
        *self.counts.entry((pose.truth, pose.verdict)).or_default() += 1;
        if matches!((pose.truth, pose.verdict), (Truth::Good, Level::Bad) | (Truth::Bad, Level::Good)) {
            *self.wrong.entry((pose.truth, pose.name.clone())).or_default() += 1;
        }
    }

    /// The number of poses with a truth and a verdict.
    pub fn count(&self, truth: Truth, verdict: Level) -> usize {
        self.counts.get(&(truth, verdict)).copied().unwrap_or(0)
    }

    /// The number of poses with a truth.
    pub fn of(&self, truth: Truth) -> usize {
        [Level::Good, Level::Doubtful, Level::Bad].into_iter().map(|verdict| self.count(truth, verdict)).sum()
    }
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "| truly | called good | doubtful | bad |\n|---|---|---|---|")?;
        for truth in [Truth::Good, Truth::Either, Truth::Bad] {
            let [good, doubtful, bad] =
                [Level::Good, Level::Doubtful, Level::Bad].map(|level| self.count(truth, level));
            writeln!(f, "| {} | {good} | {doubtful} | {bad} |", format!("{truth:?}").to_lowercase())?;
        }
        for ((truth, name), count) in &self.wrong {
            writeln!(f, "wrong: {name}: {count} truly {truth:?}")?;
        }
        Ok(())
    }
}
