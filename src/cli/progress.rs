//! The progress of a run on stderr: a bar on a terminal, plain lines elsewhere.

use std::{
    fmt,
    io::Write,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
    time::{Duration, Instant},
};

use clap::ValueEnum;
use indicatif::{ProgressBar, ProgressState, ProgressStyle};
use mimesh_pipeline::{Progress, progress::TimeLeft, text};

use crate::cli::{
    openjd_progress::OpenJdProgress,
    terminal::{self, is_interactive},
};

/// The shortest time between two plain lines on what is under way.
const PLAIN_INTERVAL: Duration = Duration::from_secs(10);

/// The length of a bar of shares.
const WHOLE: u64 = 1000;

/// The option that says who is told of progress.
#[derive(Clone, Copy, Debug, clap::Args)]
pub struct ProgressOptions {
    /// Who is told of progress: people on stderr, or an engine of Open Job Description on stdout [default: auto]
    #[arg(
        long,
        value_name = "READER",
        value_enum,
        default_value_t,
        hide_default_value = true,
        hide_possible_values = true
    )]
    progress: Told,
}

impl ProgressOptions {
    /// Begins to show progress.
    pub fn begin(self, quiet: bool) -> TerminalProgress {
        TerminalProgress::new(self.progress, quiet)
    }
}

/// Who is told of progress.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Told {
    /// People, on stderr
    #[default]
    Auto,
    /// An engine of Open Job Description, by lines on stdout
    #[value(name = "openjd")]
    OpenJd,
}

/// Shows the progress of a run.
pub struct TerminalProgress {
    style: Style,
    /// The warnings that were shown.
    warned: Mutex<Vec<String>>,
}

/// How progress is shown.
enum Style {
    /// Draws a bar, on a terminal.
    Bar(ShareBar),
    /// Prints lines, where there is no terminal.
    Plain(Mutex<Plain>),
    /// Prints lines for an engine that runs jobs.
    OpenJd(OpenJdProgress),
    /// Shows nothing, with `--quiet`.
    Silent,
}

/// The state of plain lines.
pub struct Plain {
    /// The stage under way.
    stage: String,
    /// The number of poses; 0 before they begin.
    count: usize,
    /// The number of poses that are done.
    done: usize,
    /// The time of the last line.
    last_line: Instant,
}

impl TerminalProgress {
    /// Creates the kind that is asked for.
    pub fn new(told: Told, quiet: bool) -> Self {
        let style = if told == Told::OpenJd {
            Style::OpenJd(OpenJdProgress::default())
        } else if quiet {
            Style::Silent
        } else if is_interactive() {
            Style::Bar(ShareBar::new())
        } else {
            Style::Plain(Mutex::new(Plain { stage: String::new(), count: 0, done: 0, last_line: Instant::now() }))
        };
        Self { style, warned: Mutex::default() }
    }

    /// The warnings that were shown so far.
    pub fn warned(&self) -> Vec<String> {
        self.warned.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Removes the bar from the terminal.
    pub fn finish(&self) {
        match &self.style {
            Style::Bar(bar) => bar.finish(),
            Style::OpenJd(lines) => lines.finish(),
            Style::Plain(_) | Style::Silent => {}
        }
    }
}

impl Progress for TerminalProgress {
    fn stage(&self, name: &str) {
        match &self.style {
            Style::Bar(bar) => bar.begin(name),
            Style::Plain(plain) => {
                print_line(name);
                if let Ok(mut plain) = plain.lock() {
                    *plain = Plain { stage: name.into(), count: 0, done: 0, last_line: Instant::now() };
                }
            }
            Style::OpenJd(lines) => lines.stage(name),
            Style::Silent => {}
        }
    }

    fn done(&self, share: f64) {
        match &self.style {
            Style::Bar(bar) => bar.done(share),
            Style::Plain(plain) => {
                if let Ok(mut plain) = plain.lock() {
                    plain.line(|plain| format!("{}: {:.0} %", plain.stage, 100.0 * share));
                }
            }
            Style::OpenJd(lines) => lines.share(share),
            Style::Silent => {}
        }
    }

    fn poses(&self, count: usize) {
        match &self.style {
            Style::Bar(bar) => bar.begin_items("poses", count),
            Style::Plain(plain) => {
                print_line(&format!("poses (0 of {count})"));
                if let Ok(mut plain) = plain.lock() {
                    *plain = Plain { stage: "poses".into(), count, done: 0, last_line: Instant::now() };
                }
            }
            Style::OpenJd(lines) => lines.poses(count),
            Style::Silent => {}
        }
    }

    fn pose_done(&self) {
        match &self.style {
            Style::Bar(bar) => bar.item_done(),
            Style::Plain(plain) => {
                if let Ok(mut plain) = plain.lock() {
                    plain.done += 1;
                    if plain.done < plain.count {
                        plain.line(|plain| format!("poses ({} of {})", plain.done, plain.count));
                    }
                }
            }
            Style::OpenJd(lines) => lines.pose_done(),
            Style::Silent => {}
        }
    }

    fn warning(&self, text: &str) {
        match &self.style {
            Style::Bar(bar) => bar.bar.suspend(|| terminal::warn(text)),
            Style::Plain(_) => terminal::warn(text),
            // What an engine shows of a job is for warnings too.
            Style::OpenJd(lines) => lines.warning(text),
            Style::Silent => return,
        }
        self.warned.lock().unwrap_or_else(PoisonError::into_inner).push(text.into());
    }
}

impl Plain {
    /// Prints a line, unless the last one was not long ago.
    fn line(&mut self, text: impl FnOnce(&Self) -> String) {
        if self.last_line.elapsed() >= PLAIN_INTERVAL {
            print_line(&text(self));
            self.last_line = Instant::now();
        }
    }
}

/// A bar that shows how much of the work under way is done, and the time that is left.
#[derive(Clone)]
pub struct ShareBar {
    bar: ProgressBar,
    state: Arc<Mutex<ShareState>>,
}

/// What a [`ShareBar`] knows of the work under way.
struct ShareState {
    begin: Instant,
    left: TimeLeft,
    /// Whether a share was told, so that there is a bar.
    is_told: bool,
    /// The number of things, and how many are done; 0 for work that is told in shares.
    items: [usize; 2],
}

impl ShareBar {
    /// A bar on the terminal.
    pub fn new() -> Self {
        let bar = ProgressBar::new_spinner();
        let state = ShareState { begin: Instant::now(), left: TimeLeft::default(), is_told: false, items: [0; 2] };
        Self { bar, state: Arc::new(Mutex::new(state)) }
    }

    /// Work begins of which it is not known whether shares will be told.
    pub fn begin(&self, name: &str) {
        self.restart([0; 2]);
        self.bar.set_message(name.to_owned());
        self.bar.set_style(style("{spinner} {msg}  {elapsed}"));
        self.bar.reset();
        self.bar.enable_steady_tick(Duration::from_millis(100));
    }

    /// Work on `count` things begins.
    pub fn begin_items(&self, name: &str, count: usize) {
        self.restart([count, 0]);
        self.bar.set_message(name.to_owned());
        self.bar.set_length(count as u64);
        self.bar.set_style(self.style_with_time("{msg}  {bar:30} {pos}/{len}  {elapsed}{left}"));
        self.bar.reset();
        self.bar.enable_steady_tick(Duration::from_millis(100));
    }

    /// This share of the work is done, from 0 to 1; less than before is nothing new.
    pub fn done(&self, share: f64) {
        let mut state = self.state();
        let time = state.begin.elapsed().as_secs_f64();
        state.left.report(time, share);
        let position = (state.left.share() * WHOLE as f64) as u64;
        let is_first = !std::mem::replace(&mut state.is_told, true);
        // The bar is drawn with the state, so that it must be free.
        drop(state);
        if is_first {
            self.bar.set_length(WHOLE);
            self.bar.set_style(self.style_with_time("{spinner} {msg}  {bar:24} {percent:>3} %  {elapsed}{left}"));
        }
        self.bar.set_position(position);
    }

    /// One of the things is done.
    pub fn item_done(&self) {
        let mut state = self.state();
        state.items[1] += 1;
        let [count, done] = state.items;
        let time = state.begin.elapsed().as_secs_f64();
        state.left.report(time, done as f64 / count.max(1) as f64);
        drop(state);
        self.bar.set_position(done as u64);
    }

    /// Changes the words before the bar.
    pub fn set_message(&self, text: String) {
        self.bar.set_message(text);
    }

    /// Removes the bar from the terminal.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }

    fn restart(&self, items: [usize; 2]) {
        *self.state() = ShareState { begin: Instant::now(), left: TimeLeft::default(), is_told: false, items };
    }

    fn state(&self) -> MutexGuard<'_, ShareState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A style whose key `left` is the time left.
    fn style_with_time(&self, template: &str) -> ProgressStyle {
        let state = self.state.clone();
        let left = move |_: &ProgressState, out: &mut dyn fmt::Write| {
            let state = state.lock().unwrap_or_else(PoisonError::into_inner);
            if let Some(seconds) = state.left.seconds(state.begin.elapsed().as_secs_f64()) {
                let _ = write!(out, ", {} left", text::time_left(seconds));
            }
        };
        style(template).with_key("left", left)
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
