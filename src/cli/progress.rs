//! The progress of a run on stderr: a bar on a terminal, plain lines elsewhere.

use std::{
    io::Write,
    sync::Mutex,
    time::{Duration, Instant},
};

use indicatif::{ProgressBar, ProgressStyle};
use mimesh_pipeline::Progress;

use crate::cli::terminal::is_interactive;

/// The shortest time between two plain lines on poses.
const PLAIN_INTERVAL: Duration = Duration::from_secs(10);

/// Shows the progress of a run.
pub enum TerminalProgress {
    /// Draws a bar, on a terminal.
    Bar(ProgressBar),
    /// Prints lines, where there is no terminal.
    Plain(Mutex<Plain>),
    /// Shows nothing, with `--quiet`.
    Silent,
}

/// The state of plain lines.
pub struct Plain {
    /// The number of poses.
    count: usize,
    /// The number of poses that are done.
    done: usize,
    /// The time of the last line.
    last_line: Instant,
}

impl TerminalProgress {
    /// Creates the kind that fits stderr.
    pub fn new(quiet: bool) -> Self {
        if quiet {
            Self::Silent
        } else if is_interactive() {
            Self::Bar(ProgressBar::new_spinner())
        } else {
            Self::Plain(Mutex::new(Plain { count: 0, done: 0, last_line: Instant::now() }))
        }
    }

    /// Removes the bar from the terminal.
    pub fn finish(&self) {
        if let Self::Bar(bar) = self {
            bar.finish_and_clear();
        }
    }
}

impl Progress for TerminalProgress {
    fn stage(&self, name: &str) {
        match self {
            Self::Bar(bar) => {
                bar.set_style(style("{spinner} {msg}  {elapsed}"));
                bar.set_message(name.to_owned());
                bar.enable_steady_tick(Duration::from_millis(100));
            }
            Self::Plain(_) => print_line(name),
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
                print_line(&format!("poses (0 of {count})"));
                if let Ok(mut plain) = plain.lock() {
                    *plain = Plain { count, done: 0, last_line: Instant::now() };
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
                    if plain.last_line.elapsed() >= PLAIN_INTERVAL && plain.done < plain.count {
                        print_line(&format!("poses ({} of {})", plain.done, plain.count));
                        plain.last_line = Instant::now();
                    }
                }
            }
            Self::Silent => {}
        }
    }
}

/// The style of a bar.
fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar()).progress_chars("=> ")
}

/// Prints a line on stderr.
fn print_line(text: &str) {
    let _ = writeln!(std::io::stderr(), "{text}");
}
