//! The state of a server: what is open, and what all pages share.

use std::{
    collections::HashSet,
    path::{Path, PathBuf},
    sync::{Arc, PoisonError, RwLock},
};

use mimesh_pipeline::{Formats, Reach};
use thread_priority::ThreadPriority;
use tokio::sync::broadcast;

use crate::{
    checks::Checks,
    error::{ApiError, Result},
    events::{Cause, Event},
    folders::Folders,
    jobs::Jobs,
    live::{
        preview::{self, Preview},
        result::ResultEngine,
    },
    project::{Context, Opening, Project, SessionView},
};

/// How many events a slow page may be behind, before it is told all anew.
const MAX_EVENTS: usize = 256;

/// The state of a server.
#[derive(Debug)]
pub struct Studio {
    /// What all projects have in common.
    pub context: Context,
    /// The folders that may be looked at.
    pub folders: Folders,
    /// The folder of uploads, one of them.
    pub uploads: PathBuf,
    /// What all pages hear of.
    pub events: broadcast::Sender<Event>,
    /// Long work under way.
    pub jobs: Jobs,
    /// The fast preview.
    pub preview: Preview,
    /// Threads of the fast preview, so that it does not wait for what takes long.
    pub fast_pool: rayon::ThreadPool,
    /// Threads of what nobody waits for; the preview goes before them.
    pub calm_pool: rayon::ThreadPool,
    /// The pipeline's own result.
    pub results: ResultEngine,
    /// Checks of the pipeline.
    pub checks: Checks,
    project: RwLock<Option<Arc<Project>>>,
    /// Files that runs have written, which pages may open.
    written: RwLock<HashSet<PathBuf>>,
}

fn calm_pool() -> std::result::Result<rayon::ThreadPool, rayon::ThreadPoolBuildError> {
    let lower = |_| {
        // Where the system does not allow it, the preview is slower for a moment.
        let _ = thread_priority::set_current_thread_priority(ThreadPriority::Min);
    };
    rayon::ThreadPoolBuilder::new().thread_name(|i| format!("ahead {}", i + 1)).start_handler(lower).build()
}

impl Studio {
    /// A server with nothing open.
    ///
    /// # Errors
    ///
    /// If the system gives no threads.
    pub fn new(
        context: Context,
        folders: Folders,
        uploads: PathBuf,
    ) -> std::result::Result<Self, rayon::ThreadPoolBuildError> {
        let events = broadcast::Sender::new(MAX_EVENTS);
        let to_pages = events.clone();
        Ok(Self {
            context,
            folders,
            uploads,
            jobs: Jobs::new(move |job| {
                // Nobody may be listening.
                let _ = to_pages.send(Event::Job { job });
            }),
            events,
            preview: Preview::default(),
            fast_pool: rayon::ThreadPoolBuilder::new().thread_name(|i| format!("preview {}", i + 1)).build()?,
            calm_pool: calm_pool()?,
            results: ResultEngine::default(),
            project: RwLock::default(),
            checks: Checks::new()?,
            written: RwLock::default(),
        })
    }

    /// What is open.
    ///
    /// # Errors
    ///
    /// If nothing is.
    pub fn project(&self) -> Result<Arc<Project>> {
        self.current().ok_or_else(ApiError::nothing_open)
    }

    /// What is open, if anything is.
    pub fn current(&self) -> Option<Arc<Project>> {
        self.project.read().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// What is open, as pages see it.
    pub fn session(&self) -> Arc<SessionView> {
        let project = self.current();
        Arc::new(SessionView::of(project.as_deref(), self.context.allow_commands, preview::is_linked()))
    }

    /// All formats, for files that no pipeline names.
    pub fn formats(&self) -> Formats {
        Formats::new(vec![], Reach::new(&self.context.roots))
    }

    /// Opens what `opening` names, in place of what is open; it blocks.
    ///
    /// # Errors
    ///
    /// For a file outside the folders, and what is wrong with the meshes.
    pub fn open(&self, opening: &Opening) -> Result<Arc<SessionView>> {
        let find = |path: &Path| self.folders.find(path);
        let opening = match opening {
            Opening::Pipeline { pipeline } => Opening::Pipeline { pipeline: find(pipeline)? },
            Opening::Pair { source, target } => Opening::Pair { source: find(source)?, target: find(target)? },
        };
        Ok(self.opened(Project::open(&opening, &self.context)?))
    }

    /// Opens what the program was started with, wherever it lies.
    ///
    /// # Errors
    ///
    /// What is wrong with the meshes.
    pub fn open_first(&self, opening: &Opening) -> mimesh_document::diagnostic::Result<()> {
        self.opened(Project::open(opening, &self.context)?);
        Ok(())
    }

    fn opened(&self, project: Project) -> Arc<SessionView> {
        let project = Arc::new(project);
        self.jobs.cancel_all();
        *self.project.write().unwrap_or_else(PoisonError::into_inner) = Some(project.clone());
        let session = self.session();
        self.tell(Event::Session { session: session.clone() });
        self.tell(Event::Markers { markers: project.markers.view(), cause: Cause::Open });
        self.tell(Event::Pipeline { pipeline: project.pipeline.view(), cause: Cause::Open });
        self.checks.notify();
        session
    }

    /// Lets pages open these files, which a run has written.
    pub fn allow_written(&self, files: impl IntoIterator<Item = PathBuf>) {
        self.written.write().unwrap_or_else(PoisonError::into_inner).extend(files);
    }

    /// Whether a run has written the file.
    pub fn is_written(&self, file: &Path) -> bool {
        self.written.read().unwrap_or_else(PoisonError::into_inner).contains(file)
    }

    /// Tells all pages.
    pub fn tell(&self, event: Event) {
        // Nobody may be listening.
        let _ = self.events.send(event);
    }

    /// Follows a change of the markers of `project`; it blocks.
    pub fn markers_changed(&self, project: &Project, cause: Cause) {
        let revision = project.pipeline.revision();
        if matches!(cause, Cause::Edit | Cause::Undo | Cause::Redo) {
            project.name_markers();
        }
        // Both documents have one history, so a new step of one ends what the other could do again.
        let forgotten = makes_a_step(cause) && project.pipeline.forget_redo();
        self.tell(Event::Markers { markers: project.markers.view(), cause });
        if forgotten || project.pipeline.revision() != revision {
            self.tell(Event::Pipeline { pipeline: project.pipeline.view(), cause: Cause::Edit });
        }
        self.checks.notify();
    }

    /// Follows a change of the pipeline of `project`; it blocks.
    pub fn pipeline_changed(&self, project: &Project, cause: Cause) {
        if makes_a_step(cause) && project.markers.forget_redo() {
            self.tell(Event::Markers { markers: project.markers.view(), cause: Cause::Edit });
        }
        self.check_quickly(project);
        if !project.is_outdated() {
            self.tell(Event::Pipeline { pipeline: project.pipeline.view(), cause });
            return self.checks.notify();
        }
        match project.reopened(&self.context) {
            Ok(other) => _ = self.opened(other),
            // While the text names no meshes that can be read, those from before stay.
            Err(failure) => self.opening_failed(project, &failure),
        }
        self.tell(Event::Pipeline { pipeline: project.pipeline.view(), cause });
        self.checks.notify();
    }
}

/// Whether a change by `cause` is a step of undo.
fn makes_a_step(cause: Cause) -> bool {
    matches!(cause, Cause::Edit | Cause::Propose | Cause::Disk)
}
