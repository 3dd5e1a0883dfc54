//! How a run gets on: a bar on a terminal, plain lines elsewhere, on stderr.

use std::{
    io::Write,
    sync::Mutex,
    time::{Duration, Instant},
};

use indicatif::{ProgressBar, ProgressStyle};

use super::terminal::lively;
use crate::pipeline::Watch;

/// Without a terminal, poses are told at most this often.
const PLAIN_INTERVAL: Duration = Duration::from_secs(10);

/// Tells how a run gets on.
pub enum Progress {
    /// On a terminal.
    Bar(ProgressBar),
    /// Elsewhere.
    Plain(Mutex<Plain>),
    /// With `--quiet`.
    Silent,
}

/// What has been told in plain lines.
pub struct Plain {
    count: usize,
    done: usize,
    told: Instant,
}

impl Progress {
    /// The kind that fits stderr.
    pub fn new(quiet: bool) -> Self {
        if quiet {
            Self::Silent
        } else if lively() {
            Self::Bar(ProgressBar::new_spinner())
        } else {
            Self::Plain(Mutex::new(Plain { count: 0, done: 0, told: Instant::now() }))
        }
    }

    /// Leaves the terminal as it was.
    pub fn finish(&self) {
        if let Self::Bar(bar) = self {
            bar.finish_and_clear();
        }
    }
}

impl Watch for Progress {
    fn stage(&self, what: &str) {
        match self {
            Self::Bar(bar) => {
                bar.set_style(style("{spinner} {msg}  {elapsed}"));
                bar.set_message(what.to_owned());
                bar.enable_steady_tick(Duration::from_millis(100));
            }
            Self::Plain(_) => say(what),
            Self::Silent => {}
        }
    }

    fn poses(&self, count: usize) {
        match self {
            Self::Bar(bar) => {
                bar.reset();
                bar.set_length(count as u64);
                bar.set_style(style("poses  {bar:30} {pos}/{len}  {elapsed}, {eta} left"));
            }
            Self::Plain(plain) => {
                say(&format!("poses (0 of {count})"));
                if let Ok(mut plain) = plain.lock() {
                    *plain = Plain { count, done: 0, told: Instant::now() };
                }
            }
            Self::Silent => {}
        }
    }

    fn pose_done(&self) {
        match self {
            Self::Bar(bar) => bar.inc(1),
            Self::Plain(plain) => {
                if let Ok(mut plain) = plain.lock() {
                    plain.done += 1;
                    if plain.told.elapsed() >= PLAIN_INTERVAL && plain.done < plain.count {
                        say(&format!("poses ({} of {})", plain.done, plain.count));
                        plain.told = Instant::now();
                    }
                }
            }
            Self::Silent => {}
        }
    }
}

fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar()).progress_chars("=> ")
}

fn say(text: &str) {
    let _ = writeln!(std::io::stderr(), "{text}");
}
