//! Which checks of the pipeline are under way.

use std::sync::atomic::{AtomicU64, AtomicUsize};

use tokio::sync::Notify;

/// How many checks may be under way; that of an older text ends unheard.
pub const MAX_CHECKS: usize = 2;

/// Checks under way.
#[derive(Debug)]
pub struct Checks {
    pub(crate) due: Notify,
    pub(crate) running: AtomicUsize,
    /// Counts checks that began.
    pub(crate) begun: AtomicU64,
    /// The latest check whose outcome was taken.
    pub(crate) taken: AtomicU64,
    pub(crate) pool: rayon::ThreadPool,
}

impl Checks {
    /// No checks yet.
    ///
    /// # Errors
    ///
    /// If the system gives no threads.
    pub fn new() -> Result<Self, rayon::ThreadPoolBuildError> {
        let pool = rayon::ThreadPoolBuilder::new().thread_name(|i| format!("check {}", i + 1)).build()?;
        let (running, begun, taken) = (AtomicUsize::new(0), AtomicU64::new(0), AtomicU64::new(0));
        Ok(Self { due: Notify::new(), running, begun, taken, pool })
    }

    /// Asks for a check.
    pub fn notify(&self) {
        self.due.notify_one();
    }
}
