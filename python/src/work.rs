//! Work that takes long: other threads of Python run meanwhile, its progress is told, and Ctrl-C ends it.
//!
//! The work is done on a thread of its own. The thread that waits for it tells the progress and looks for signals. Stages cannot be
//! interrupted: work that is to end unwinds from its next report, as in the studio. Where that takes too long, the caller goes on
//! without it. It then writes nothing any more, since it reports before it moves results to their places.

use std::{
    any::Any,
    panic::{AssertUnwindSafe, catch_unwind, resume_unwind},
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
        mpsc::{self, Receiver, RecvTimeoutError, Sender},
    },
    thread,
    time::{Duration, Instant},
};

use mimesh_document::{Diagnostic, Kind};
use mimesh_pipeline::{Progress, staging::discard_all_before_exit};
use pyo3::{exceptions::PyKeyboardInterrupt, prelude::*};

use crate::error::exception;

/// How often signals are looked for.
const TICK: Duration = Duration::from_millis(20);

/// How long a caller that was interrupted waits for the end of the work.
const PATIENCE: Duration = Duration::from_millis(800);

/// The stack of the thread, as large as that of a program's first.
const STACK: usize = 16 << 20;

/// What unwinds from work that is to end.
struct Unwinding;

/// What becomes of work.
enum Message<T> {
    Event(Event),
    Done(thread::Result<T>),
}

/// A report of work under way.
#[derive(Clone, Debug)]
pub enum Event {
    /// A stage begins.
    Stage(String),
    /// This share of it is done.
    Share(f64),
    /// The poses begin.
    Poses(usize),
    /// One of them is done.
    PoseDone,
    /// Something was done that the user has to know.
    Warning(String),
}

/// Takes the reports of work, and ends it if it is to end.
pub struct Watch {
    is_stopped: Arc<AtomicBool>,
    tell: Box<dyn Fn(Event) + Send + Sync>,
}

impl Watch {
    /// Does not return if the work is to end.
    pub fn check(&self) {
        if self.is_stopped.load(Ordering::Relaxed) {
            resume_unwind(Box::new(Unwinding));
        }
    }

    fn tell(&self, event: Event) {
        self.check();
        (self.tell)(event);
    }
}

impl Progress for Watch {
    fn stage(&self, name: &str) {
        self.tell(Event::Stage(name.into()));
    }

    fn done(&self, share: f64) {
        self.tell(Event::Share(share));
    }

    fn poses(&self, count: usize) {
        self.tell(Event::Poses(count));
    }

    fn pose_done(&self) {
        self.tell(Event::PoseDone);
    }

    fn warning(&self, text: &str) {
        self.tell(Event::Warning(text.into()));
    }
}

/// Does `work` while other threads of Python run, and calls `progress` on this thread with each event: its kind, a text and a number.
///
/// # Errors
///
/// `KeyboardInterrupt` and whatever else a handler of signals or `progress` raises; a fault of the work itself.
pub fn run<T: Send + 'static>(
    py: Python<'_>,
    progress: Option<&Py<PyAny>>,
    work: impl FnOnce(&Watch) -> T + Send + 'static,
) -> PyResult<T> {
    let is_stopped = Arc::new(AtomicBool::new(false));
    let (sender, mut receiver) = mpsc::channel();
    start(sender, progress.is_some(), is_stopped.clone(), work).map_err(|error| {
        exception(py, &Diagnostic::new(Kind::Internal, format!("cannot start a thread: {error}")).into())
    })?;
    loop {
        let received = wait(py, &mut receiver, TICK);
        let told = match received {
            Ok(Message::Done(Ok(result))) => return Ok(result),
            Ok(Message::Done(Err(cause))) => return Err(fault(py, cause.as_ref())),
            Ok(Message::Event(event)) => progress.map_or(Ok(()), |progress| tell(py, progress, event)),
            Err(RecvTimeoutError::Timeout) => Ok(()),
            Err(RecvTimeoutError::Disconnected) => return Err(fault(py, &"its thread ended without a word")),
        };
        if let Err(error) = told.and_then(|()| py.check_signals()) {
            is_stopped.store(true, Ordering::Relaxed);
            let end = Instant::now() + PATIENCE;
            while let Some(left) = end.checked_duration_since(Instant::now()) {
                if matches!(wait(py, &mut receiver, left), Ok(Message::Done(_)) | Err(_)) {
                    break;
                }
            }
            return Err(error);
        }
    }
}

/// Starts the thread of the work.
fn start<T: Send + 'static>(
    sender: Sender<Message<T>>,
    is_watched: bool,
    is_stopped: Arc<AtomicBool>,
    work: impl FnOnce(&Watch) -> T + Send + 'static,
) -> std::io::Result<()> {
    let events = sender.clone();
    let tell = move |event| {
        if is_watched {
            // Whoever does not listen any more has been interrupted.
            let _ = events.send(Message::Event(event));
        }
    };
    let watch = Watch { is_stopped, tell: Box::new(tell) };
    let body = move || {
        let result = catch_unwind(AssertUnwindSafe(|| work(&watch)));
        let _ = sender.send(Message::Done(result));
    };
    thread::Builder::new().name("mimesh".into()).stack_size(STACK).spawn(body)?;
    Ok(())
}

/// The next message, while other threads of Python run.
fn wait<T: Send>(
    py: Python<'_>,
    receiver: &mut Receiver<Message<T>>,
    time: Duration,
) -> Result<Message<T>, RecvTimeoutError> {
    py.detach(move || receiver.recv_timeout(time))
}

/// Calls `progress` with an event.
fn tell(py: Python<'_>, progress: &Py<PyAny>, event: Event) -> PyResult<()> {
    let (kind, text, number) = match event {
        Event::Stage(name) => ("stage", name, 0.0),
        Event::Share(share) => ("share", String::new(), share),
        Event::Poses(count) => ("poses", String::new(), count as f64),
        Event::PoseDone => ("pose_done", String::new(), 0.0),
        Event::Warning(text) => ("warning", text, 0.0),
    };
    progress.call1(py, (kind, text, number)).map(drop)
}

/// Removes the temporary files of work that nobody waited for, when the interpreter ends.
#[pyfunction]
pub fn discard_all(py: Python<'_>) {
    py.detach(discard_all_before_exit);
}

/// The exception of work that unwound.
fn fault(py: Python<'_>, cause: &(dyn Any + Send)) -> PyErr {
    if cause.is::<Unwinding>() {
        return PyKeyboardInterrupt::new_err(());
    }
    let words = cause.downcast_ref::<&str>().map(|words| (*words).to_owned());
    let words = words.or_else(|| cause.downcast_ref::<String>().cloned()).unwrap_or_default();
    let diagnostic = Diagnostic::new(Kind::Internal, format!("the program made a mistake: {words}"));
    exception(py, &diagnostic.hint("please report it, with what you did").into())
}
