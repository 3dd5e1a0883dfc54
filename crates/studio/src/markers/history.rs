//! The history of the document, for undo and redo.

use std::{collections::VecDeque, sync::Arc};

use super::pair::Pair;
use crate::order;

/// How many steps are kept.
const MAX_STEPS: usize = 2_000;

/// Steps that were done, and steps that were taken back.
#[derive(Clone, Debug, Default)]
pub struct History {
    steps: VecDeque<Step>,
    /// How many of the steps are done.
    done: usize,
}

/// A step: the pairs before and after it, which share all that did not change.
#[derive(Clone, Debug)]
pub struct Step {
    /// What was done, e.g. `move nose`.
    pub title: String,
    /// Where it stands among the steps of all histories.
    pub order: u64,
    /// The pairs before.
    pub before: Vec<Arc<Pair>>,
    /// The pairs after.
    pub after: Vec<Arc<Pair>>,
}

impl History {
    /// Adds a step; what was taken back before is forgotten.
    pub fn push(&mut self, title: String, before: Vec<Arc<Pair>>, after: Vec<Arc<Pair>>) {
        self.forget_redo();
        self.steps.push_back(Step { title, order: order::next(), before, after });
        if self.steps.len() > MAX_STEPS {
            self.steps.pop_front();
        }
        self.done = self.steps.len();
    }

    /// Forgets what was taken back; whether there was any.
    pub fn forget_redo(&mut self) -> bool {
        let had = self.steps.len() > self.done;
        self.steps.truncate(self.done);
        had
    }

    /// The step that undo takes back.
    pub fn last(&self) -> Option<&Step> {
        self.done.checked_sub(1).and_then(|i| self.steps.get(i))
    }

    /// The step that redo does again.
    pub fn next(&self) -> Option<&Step> {
        self.steps.get(self.done)
    }

    /// Goes back by a step, and gives it.
    pub fn back(&mut self) -> Option<Step> {
        let step = self.last()?.clone();
        self.done -= 1;
        Some(step)
    }

    /// Goes forward by a step, and gives it.
    pub fn forward(&mut self) -> Option<Step> {
        let step = self.next()?.clone();
        self.done += 1;
        Some(step)
    }
}
