//! Stopping work that is under way.
//!
//! Stages report how much is done, and know nothing of being stopped. So work that nobody waits for any more unwinds from its next
//! report, and is caught where it began. Nothing is printed, nothing is kept of it, and no other work is touched.

use std::{
    any::Any,
    panic::{AssertUnwindSafe, catch_unwind, resume_unwind},
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
};

/// Says that work is to stop; clones are one.
#[derive(Clone, Debug, Default)]
pub struct Cancel(Arc<AtomicBool>);

/// Work was stopped, or failed in a way that it cannot say.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Stopped {
    /// It was asked to.
    Cancelled,
    /// A fault of the program, in its own words.
    Panicked(String),
}

/// What unwinds.
struct Unwinding;

impl Cancel {
    /// Asks the work to stop.
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether it is asked to stop.
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// Does not return if the work is to stop; only within [`run`](Self::run).
    pub fn check(&self) {
        if self.is_cancelled() {
            resume_unwind(Box::new(Unwinding));
        }
    }

    /// Does `work`, which calls [`check`](Self::check) now and then.
    ///
    /// # Errors
    ///
    /// If it was stopped.
    pub fn run<T>(&self, work: impl FnOnce() -> T) -> Result<T, Stopped> {
        catch_unwind(AssertUnwindSafe(work)).map_err(|cause| stopped(cause.as_ref()))
    }
}

fn stopped(cause: &(dyn Any + Send)) -> Stopped {
    if cause.is::<Unwinding>() {
        return Stopped::Cancelled;
    }
    let words = cause.downcast_ref::<&str>().map(|words| (*words).to_owned());
    Stopped::Panicked(words.or_else(|| cause.downcast_ref::<String>().cloned()).unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use rayon::prelude::*;

    use super::*;

    #[test]
    fn work_stops_at_its_next_report_on_any_thread() {
        let cancel = Cancel::default();
        assert_eq!(cancel.run(|| 7), Ok(7));
        let stopped = cancel.run(|| {
            (0..1000).into_par_iter().for_each(|i| {
                if i == 10 {
                    cancel.cancel();
                }
                cancel.check();
            });
        });
        assert_eq!(stopped, Err(Stopped::Cancelled));
    }
}
