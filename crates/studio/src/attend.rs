//! Checking the pipeline whenever it or the markers change, and looking for changes on the disk.
//!
//! What the text alone shows, and what opening its meshes shows, is told at once. The check of the whole pipeline follows on threads of its
//! own: those of all other work may be taken for long by a result under way. A newer check does not wait for an older one.

use std::{
    panic::{AssertUnwindSafe, catch_unwind},
    path::PathBuf,
    sync::{Arc, atomic::Ordering},
    time::Duration,
};

use mimesh_document::diagnostic;
use mimesh_pipeline::{check_text, prepare_all, prepare_document};

use crate::{
    checks::MAX_CHECKS,
    error::ApiDiagnostic,
    events::{Cause, Event},
    markers::{pair::Content, store::Usable},
    pipeline::Checked,
    project::{Project, Ready},
    scalars::ScalarView,
    studio::Studio,
};

/// How often files are looked at that somebody else may change.
const WATCH: Duration = Duration::from_secs(1);

/// What a check is about: project, revision of the pipeline, number of pairs, and saves of masks.
type Subject = (u64, u64, usize, u64);

impl Studio {
    /// Checks the pipeline whenever it or the markers changed, and looks for changes on the disk; it does not end.
    pub async fn attend(self: Arc<Self>) {
        let mut last: Option<Subject> = None;
        loop {
            let _ = tokio::time::timeout(WATCH, self.checks.due.notified()).await;
            let (studio, known) = (self.clone(), last);
            let begun = tokio::task::spawn_blocking(move || studio.attend_once(known)).await;
            last = begun.unwrap_or(last);
        }
    }

    /// What is checked now, after what was `known`.
    fn attend_once(self: &Arc<Self>, known: Option<Subject>) -> Option<Subject> {
        let project = self.current()?;
        if project.markers.refresh() {
            self.markers_changed(&project, Cause::Disk);
        }
        if project.pipeline.refresh() {
            self.pipeline_changed(&project, Cause::Disk);
        }
        let project = self.current()?;
        let usable = project.markers.usable();
        let masks = project.masks_saved.load(Ordering::Relaxed);
        let now = (project.number, project.pipeline.revision(), usable.markers.len(), masks);
        if known == Some(now) || self.checks.running.load(Ordering::Relaxed) >= MAX_CHECKS {
            return known;
        }
        if known.is_none_or(|known| known.0 != now.0) && project.markers.is_empty() {
            // Nobody waits for it, and what it would refuse is told when somebody asks.
            let _ = self.propose(project.clone(), 0);
        }
        self.checks.running.fetch_add(1, Ordering::Relaxed);
        let turn = self.checks.begun.fetch_add(1, Ordering::Relaxed) + 1;
        let studio = self.clone();
        std::thread::spawn(move || {
            // A check that fails by a mistake of the program leaves what was known, and others go on.
            let _ = catch_unwind(AssertUnwindSafe(|| studio.check(&project, &usable, turn)));
            studio.checks.running.fetch_sub(1, Ordering::Relaxed);
            studio.checks.notify();
        });
        Some(now)
    }

    /// Notes what the text of the pipeline alone shows to be wrong; whether nothing is.
    pub(crate) fn check_quickly(&self, project: &Project) -> bool {
        let (revision, document) = project.pipeline.document();
        // A text that is no YAML is told by the view itself.
        let Ok((document, included)) = document else { return false };
        let options = self.context.options(project.pipeline.file());
        match check_text(document.clone(), included, &options) {
            Ok(()) => true,
            Err(failure) => {
                let list = failure.list.iter().map(|one| ApiDiagnostic::of(one, Some(&document))).collect();
                project.pipeline.found(revision, list);
                false
            }
        }
    }

    /// Notes why the meshes that the pipeline names now cannot be opened.
    pub(crate) fn opening_failed(&self, project: &Project, failure: &diagnostic::Diagnostics) {
        let (revision, document) = project.pipeline.document();
        let document = document.ok().map(|(document, _)| document);
        let list = failure.list.iter().map(|one| ApiDiagnostic::of(one, document.as_ref())).collect();
        project.pipeline.found(revision, list);
    }

    /// Checks the whole pipeline with the pairs that stages can use in place of its markers.
    fn check(&self, project: &Project, usable: &Usable, turn: u64) {
        let mut options = self.context.options(project.pipeline.file());
        if !usable.markers.is_empty()
            && let Some(file) = self.scratch_markers(project, usable, turn)
        {
            options.settings.push(format!("markers={}", serde_json::Value::from(file.to_string_lossy())));
        }
        let (revision, document) = project.pipeline.document();
        let exists = project.pipeline.file().exists();
        let kept = document.as_ref().ok().map(|(document, _)| document.clone());
        let prepared = self.checks.pool.install(|| {
            let (document, _) = document?;
            let cache = self.context.cache.as_ref();
            if exists {
                prepare_all(project.pipeline.file(), &options, cache)
            } else {
                prepare_document(document, &options, cache)
            }
        });
        let checked = Checked::of(&prepared, kept.as_ref());
        // Another project may be open, and a newer check may be done.
        let is_open = self.current().is_some_and(|open| open.number == project.number);
        if !is_open || self.checks.taken.fetch_max(turn, Ordering::Relaxed) > turn {
            return;
        }
        if !project.pipeline.checked(revision, checked) {
            return;
        }
        let one = prepared.ok().and_then(|all| all.into_iter().next());
        project.set_ready(one.map(|prepared| {
            let scalars = self.checks.pool.install(|| ScalarView::all(&prepared));
            Arc::new(Ready { revision, prepared, scalars })
        }));
        self.tell(Event::Session { session: self.session() });
        self.tell(Event::Pipeline { pipeline: project.pipeline.view(), cause: Cause::Check });
    }

    /// A file with the pairs that stages can use, for checks alone.
    fn scratch_markers(&self, project: &Project, usable: &Usable, turn: u64) -> Option<PathBuf> {
        let file = self.context.scratch.join(format!("markers-{}.yaml", turn % (2 * MAX_CHECKS as u64)));
        let pairs = usable.contents.iter().zip(&usable.markers).map(|(content, marker)| crate::markers::Pair {
            id: 1,
            number: 1,
            content: Content { name: Some(marker.name.clone()), ..content.clone() },
            origin: crate::markers::Origin::File,
            changes: Default::default(),
        });
        let pairs: Vec<_> = pairs.collect();
        let markers = crate::markers::file::of_pairs(pairs.iter(), project.meshes.for_markers());
        std::fs::write(&file, mimesh_markers::formats::yaml::write(&markers)).ok().map(|()| file)
    }
}
