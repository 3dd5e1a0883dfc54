//! The state of a server: what is open, and what all pages share.

use std::{
    collections::HashSet,
    path::{Path, PathBuf},
    sync::{Arc, PoisonError, RwLock},
    time::Duration,
};

use mimesh_core::{
    plugin::instance,
    stage::{Landmarks, Work},
};
use mimesh_pipeline::{Formats, Reach, prepare_all, prepare_document, propose::propose};
use tokio::sync::{Notify, broadcast};

use crate::{
    error::{ApiError, Code, Result},
    events::{Cause, Event},
    folders::Folders,
    jobs::{Job, JobKind, JobView, Jobs, Outcome},
    live::{
        preview::{self, Preview},
        result::ResultEngine,
    },
    markers::{Status, pair::Content, store::Usable},
    pipeline::Checked,
    project::{Context, Opening, Project, Ready, SessionView},
    scalars::ScalarView,
};

/// The stage that finds markers where the pipeline names none.
const DEFAULT_LANDMARKS: &str = "extremities";

/// How often files are looked at that somebody else may change.
const WATCH: Duration = Duration::from_secs(1);

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
    /// The pipeline's own result.
    pub results: ResultEngine,
    project: RwLock<Option<Arc<Project>>>,
    check: Notify,
    /// Files that runs have written, which pages may open.
    written: RwLock<HashSet<PathBuf>>,
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
            results: ResultEngine::default(),
            project: RwLock::default(),
            check: Notify::new(),
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
        self.check.notify_one();
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
        let markers = project.markers.view();
        self.tell(Event::Markers { markers, cause });
        let revision = project.pipeline.revision();
        if matches!(cause, Cause::Edit | Cause::Undo | Cause::Redo) {
            project.name_markers();
        }
        if project.pipeline.revision() != revision {
            self.tell(Event::Pipeline { pipeline: project.pipeline.view(), cause: Cause::Edit });
        }
        self.check.notify_one();
    }

    /// Follows a change of the pipeline of `project`; it blocks.
    pub fn pipeline_changed(&self, project: &Project, cause: Cause) {
        self.tell(Event::Pipeline { pipeline: project.pipeline.view(), cause });
        if project.is_outdated() {
            let opening = Opening::Pipeline { pipeline: project.pipeline.file().into() };
            // While the text names no meshes that can be read, those from before stay; the check says what is wrong.
            if let Ok(other) = Project::open(&opening, &self.context) {
                self.opened(other);
            }
        }
        self.check.notify_one();
    }

    /// Begins to find pairs by shape; reading number `other` of the shapes, where 0 is the likeliest.
    ///
    /// # Errors
    ///
    /// If that is under way already.
    pub fn propose(self: &Arc<Self>, project: Arc<Project>, other: usize) -> Result<Arc<JobView>> {
        let studio = self.clone();
        self.jobs.start(JobKind::Propose, move |job| studio.proposed(&project, other, job))
    }

    fn proposed(&self, project: &Project, other: usize, job: &Job) -> Result<Outcome> {
        let default = instance::<dyn Landmarks>(DEFAULT_LANDMARKS);
        let stage = project.landmarks.as_deref().or(default.as_deref()).ok_or_else(|| {
            ApiError::new(Code::Unprocessable, "no stage that finds landmarks is part of this program")
        })?;
        job.begin(&format!("landmarks ({})", stage.typetag_name()));
        let Usable { markers, contents, .. } = project.markers.usable();
        let clicks = markers.into_iter().zip(contents).filter(|(_, content)| content.status == Status::Confirmed);
        let clicks: Vec<_> = clicks.map(|(marker, _)| marker).collect();
        let sides = [&*project.meshes.sides[0], &*project.meshes.sides[1]];
        let report = |share| job.share(share);
        let proposal = propose(stage, sides, &clicks, self.context.allow_commands, Work::new(&report))?;
        let pairs = match other {
            0 => &proposal.pairs,
            n => proposal.others.get(n - 1).ok_or_else(|| {
                let message = format!("there are {} other readings of the shapes", proposal.others.len());
                ApiError::new(Code::Unprocessable, message)
            })?,
        };
        let content = |pair: &mimesh_core::stage::ProposedPair| Content {
            name: Some(pair.marker.name.clone()),
            points: [
                Some(sides[0].surface.mesh_point(pair.marker.source).into()),
                Some(sides[1].surface.mesh_point(pair.marker.target).into()),
            ],
            status: Status::Proposed,
            // Four digits are more than it is worth.
            confidence: Some((pair.confidence * 1e4).round() / 1e4),
            ..Content::default()
        };
        let clicked: Vec<_> = clicks.iter().map(|click| (click.source, click.target)).collect();
        let is_new =
            |pair: &&mimesh_core::stage::ProposedPair| !clicked.contains(&(pair.marker.source, pair.marker.target));
        let contents: Vec<Content> = pairs.iter().filter(is_new).map(content).collect();
        job.cancel.check();
        if project.markers.propose(contents).is_changed {
            self.markers_changed(project, Cause::Propose);
        }
        Ok(Outcome { warnings: proposal.figures.warnings.clone(), result: None })
    }

    /// Checks the pipeline whenever it or the markers changed, and looks for changes on the disk; it does not end.
    pub async fn attend(self: Arc<Self>) {
        let mut last: Option<(u64, u64, usize)> = None;
        loop {
            let _ = tokio::time::timeout(WATCH, self.check.notified()).await;
            let studio = self.clone();
            let known = last;
            let done = tokio::task::spawn_blocking(move || studio.attend_once(known)).await;
            last = done.unwrap_or(last);
        }
    }

    /// What was checked last: project, revision of the pipeline, and number of pairs.
    fn attend_once(self: &Arc<Self>, known: Option<(u64, u64, usize)>) -> Option<(u64, u64, usize)> {
        let project = self.current()?;
        if project.markers.refresh() {
            self.tell(Event::Markers { markers: project.markers.view(), cause: Cause::Disk });
        }
        if project.pipeline.refresh() {
            self.pipeline_changed(&project, Cause::Disk);
        }
        let project = self.current()?;
        let usable = project.markers.usable();
        let now = (project.number, project.pipeline.revision(), usable.markers.len());
        let is_first = known.is_none_or(|known| known.0 != now.0);
        if known != Some(now) {
            self.check(&project, &usable);
        }
        if is_first && project.markers.is_empty() {
            // Nobody waits for it, and what it would refuse is told when somebody asks.
            let _ = self.propose(project, 0);
        }
        Some(now)
    }

    /// Checks the whole pipeline with the pairs that stages can use in place of its markers.
    fn check(&self, project: &Project, usable: &Usable) {
        let mut options = self.context.options(project.pipeline.file());
        if !usable.markers.is_empty()
            && let Some(file) = self.scratch_markers(project, usable)
        {
            options.settings.push(format!("markers={}", serde_json::Value::from(file.to_string_lossy())));
        }
        let (revision, document) = project.pipeline.document();
        let exists = project.pipeline.file().exists();
        let kept = document.as_ref().ok().map(|(document, _)| document.clone());
        let prepared = document.and_then(|(document, _)| {
            let cache = self.context.cache.as_ref();
            if exists {
                prepare_all(project.pipeline.file(), &options, cache)
            } else {
                prepare_document(document, &options, cache)
            }
        });
        let checked = Checked::of(&prepared, kept.as_ref());
        if !project.pipeline.checked(revision, checked) {
            return self.check.notify_one();
        }
        let one = prepared.ok().and_then(|all| all.into_iter().next());
        project.set_ready(one.map(|prepared| {
            let scalars = ScalarView::all(&prepared);
            Arc::new(Ready { revision, prepared, scalars })
        }));
        self.tell(Event::Session { session: self.session() });
        self.tell(Event::Pipeline { pipeline: project.pipeline.view(), cause: Cause::Check });
    }

    /// A file with the pairs that stages can use, for checks alone.
    fn scratch_markers(&self, project: &Project, usable: &Usable) -> Option<PathBuf> {
        let file = self.context.scratch.join("markers.yaml");
        let pairs = usable.contents.iter().zip(&usable.markers).map(|(content, marker)| crate::markers::Pair {
            id: 1,
            content: Content { name: Some(marker.name.clone()), ..content.clone() },
            origin: crate::markers::Origin::File,
            changes: Default::default(),
        });
        let pairs: Vec<_> = pairs.collect();
        let markers = crate::markers::file::of_pairs(pairs.iter(), project.meshes.for_markers());
        std::fs::write(&file, mimesh_markers::formats::yaml::write(&markers)).ok().map(|()| file)
    }
}
