//! All long work that pages asked for.

use std::{
    collections::VecDeque,
    sync::{
        Arc, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicU64, Ordering},
    },
};

use crate::{
    error::{ApiError, Code},
    job::{Job, JobKind, JobView, Outcome, Tell},
};

/// How many jobs are remembered.
const REMEMBERED: usize = 20;

/// The jobs of a server.
#[derive(Debug)]
pub struct Jobs {
    list: Mutex<VecDeque<Arc<Job>>>,
    next: AtomicU64,
    tell: Tell,
}

impl Jobs {
    /// No jobs yet; what becomes of them is told to `tell`.
    pub fn new(tell: impl Fn(Arc<JobView>) + Send + Sync + 'static) -> Self {
        Self { list: Mutex::default(), next: AtomicU64::new(1), tell: Tell::new(tell) }
    }

    /// Begins a job about `project` on a thread of its own.
    ///
    /// # Errors
    ///
    /// If one of the kind is under way.
    pub fn start(
        &self,
        kind: JobKind,
        project: u64,
        work: impl FnOnce(&Job) -> Result<Outcome, ApiError> + Send + 'static,
    ) -> Result<Arc<JobView>, ApiError> {
        let mut list = self.lock();
        if list.iter().any(|job| job.kind() == kind && job.is_running()) {
            let message = match kind {
                JobKind::Run => "a run is under way",
                JobKind::Propose => "pairs are being proposed",
            };
            return Err(ApiError::new(Code::Busy, message).hint("wait until it ends, or cancel it"));
        }
        let id = self.next.fetch_add(1, Ordering::Relaxed);
        let job = Arc::new(Job::new(id, kind, project, self.tell.clone()));
        list.push_front(job.clone());
        list.truncate(REMEMBERED);
        let view = job.view();
        tokio::task::spawn_blocking(move || {
            let done = job.cancel.run(|| work(&job));
            job.finish(done);
        });
        Ok(view)
    }

    /// All jobs that are remembered, newest first.
    pub fn views(&self) -> Vec<Arc<JobView>> {
        self.lock().iter().map(|job| job.view()).collect()
    }

    /// The job `id`.
    ///
    /// # Errors
    ///
    /// If there is none.
    pub fn find(&self, id: u64) -> Result<Arc<Job>, ApiError> {
        let list = self.lock();
        let found = list.iter().find(|job| job.id() == id).cloned();
        found.ok_or_else(|| ApiError::not_found(format!("there is no job {id}")))
    }

    /// Stops all jobs.
    pub fn cancel_all(&self) {
        self.lock().iter().for_each(|job| job.cancel.cancel());
    }

    fn lock(&self) -> MutexGuard<'_, VecDeque<Arc<Job>>> {
        self.list.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
