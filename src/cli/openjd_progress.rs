//! Progress as engines of Open Job Description read it: lines on stdout that begin with `openjd_`.

use std::{
    sync::{Mutex, MutexGuard, PoisonError},
    time::{Duration, Instant},
};

use crate::cli::terminal;

/// The shortest time between two lines on the share of the work.
const INTERVAL: Duration = Duration::from_millis(500);

/// Prints what is under way, and how much of it is done in percent.
#[derive(Debug, Default)]
pub struct OpenJdProgress {
    state: Mutex<State>,
}

#[derive(Debug, Default)]
struct State {
    /// The number of poses; 0 before they begin.
    count: usize,
    done: usize,
    last_line: Option<Instant>,
}

impl OpenJdProgress {
    /// A stage begins.
    pub fn stage(&self, name: &str) {
        *self.state() = State::default();
        status(name);
    }

    /// This share of the stage is done, from 0 to 1.
    pub fn share(&self, share: f64) {
        let mut state = self.state();
        if state.last_line.is_none_or(|at| at.elapsed() >= INTERVAL) {
            state.last_line = Some(Instant::now());
            progress(share);
        }
    }

    /// The transfer of so many poses begins.
    pub fn poses(&self, count: usize) {
        *self.state() = State { count, ..State::default() };
        status(&format!("poses (0 of {count})"));
    }

    /// A pose is done.
    pub fn pose_done(&self) {
        let mut state = self.state();
        state.done += 1;
        let (done, count) = (state.done, state.count);
        drop(state);
        self.share(done as f64 / count.max(1) as f64);
    }

    /// Something looks wrong.
    pub fn warning(&self, text: &str) {
        status(&format!("warning: {text}"));
    }

    /// Nothing more will be done.
    pub fn finish(&self) {
        let state = self.state();
        if state.count > 0 && state.done == state.count {
            status(&format!("{0} of {0} poses", state.count));
            progress(1.0);
        }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn status(text: &str) {
    // A message is one line.
    let line: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    terminal::print(&format!("openjd_status: {line}\n"));
}

fn progress(share: f64) {
    terminal::print(&format!("openjd_progress: {:.1}\n", 100.0 * share));
}
