//! The stages that run once: the correspondence and the bound transfer, each computed when it is first asked for.

use std::sync::{Mutex, OnceLock, PoisonError};

use mimesh_core::{
    Figures, Result,
    stage::{BindInput, BoundTransfer, Proposal, Transfer, TransferPair, TriangleMap, Work},
};
use mimesh_document::{Diagnostic, diagnostic};
use mimesh_markers::IntoDiagnostic;
use tracing::{Span, info_span};

use super::{
    failures::{doing, with_remedy},
    sharing::Sharing,
};
use crate::{
    cache::{Cache, PoseCache, StageKey, StageLock, TransferSummary},
    cached_run::CachedRun,
    handedness,
    input::{Prepared, read_evenly_spaced},
    plan::Plan,
    progress::{Progress, Rising},
    propose::propose,
    report::{Clock, StageReport},
    shard::{Extent, PoseOrder},
};

/// Remedy: give markers in place of those that a stage proposes.
pub const GIVE_MARKERS: &str = "give_markers";

/// The stages of a run that run once.
pub(super) struct Stages<'a> {
    prepared: &'a Prepared,
    /// The transfer of the pipeline.
    pub transfer: &'a dyn Transfer,
    cache: Option<(&'a Cache, &'a CachedRun)>,
    /// The poses of the run in their order.
    pub order: &'a PoseOrder,
    /// Whether no pose is computed.
    pub is_merge: bool,
    /// What is done about results that several processes may compute at once.
    sharing: Sharing,
    progress: &'a dyn Progress,
    proposal: OnceLock<Proposal>,
    map: OnceLock<TriangleMap>,
    bound: OnceLock<Box<dyn BoundTransfer>>,
    reports: Mutex<Vec<StageReport>>,
}

impl<'a> Stages<'a> {
    /// The stages of `prepared` by `plan`, none of which has run but those that its check needed.
    pub fn new(
        prepared: &'a Prepared,
        plan: &'a Plan,
        transfer: &'a dyn Transfer,
        cache: Option<&'a Cache>,
        progress: &'a dyn Progress,
    ) -> Self {
        let cache = cache.zip(plan.cached.as_ref());
        let sharing = if plan.extent == Extent::Whole { Sharing::None } else { Sharing::Respect };
        let mut reports = vec![prepared.reading.clone()];
        if let Some(proximity) = &prepared.proximity {
            reports.push(proximity.report.clone());
            if let Some((cache, cached)) = cache
                && let Some(key) = cached.keys.proximity.as_ref().filter(|_| !proximity.report.reused)
            {
                cache.put("proximity", key.key, &proximity.graph);
            }
        }
        let (proposal, map, bound) = (OnceLock::new(), OnceLock::new(), OnceLock::new());
        let (order, is_merge, reports) = (&plan.order, plan.extent.is_merge(), Mutex::new(reports));
        Self { prepared, transfer, cache, order, is_merge, sharing, progress, proposal, map, bound, reports }
    }

    /// The same stages, locked while they are computed.
    pub fn locked(self) -> Self {
        Self { sharing: Sharing::Lock, ..self }
    }

    /// Takes the lock on the result of `stage` (by the implementation `name`) if that is called for.
    ///
    /// # Errors
    ///
    /// Those of [`Sharing::lock`].
    fn lock(&self, stage: &'static str, name: &str, key: Option<&StageKey>) -> diagnostic::Result<Option<StageLock>> {
        match self.cache.zip(key) {
            Some(((cache, _), key)) => Ok(self.sharing.lock(&cache.store, stage, name, key.key)?),
            None => Ok(None),
        }
    }

    /// The surfaces, markers and the proximity graph.
    pub fn pair(&self) -> TransferPair<'a> {
        let Prepared { source, target, proximity, .. } = self.prepared;
        TransferPair {
            source: &source.surface,
            target: target.seen_surface(),
            markers: self.prepared.markers(),
            proximity: proximity.as_ref().map(|proximity| &proximity.graph),
        }
    }

    /// Proposes the markers of a pipeline that leaves them to a stage, unless they are cached; all other stages take them as given.
    ///
    /// # Errors
    ///
    /// Those of the stage.
    pub fn propose(&self) -> diagnostic::Result<()> {
        let Some(landmarks) = self.prepared.landmarks() else { return Ok(()) };
        let name = landmarks.typetag_name();
        let key = self.cache.and_then(|(cache, cached)| Some((cache, cached.keys.landmarks.as_ref()?.key)));
        let clock = Clock::start();
        let find = || -> Option<Proposal> { key.and_then(|(cache, key)| cache.get("landmarks", key)) };
        let mut cached = find();
        let mut lock = None;
        if cached.is_none() {
            lock = self.lock("landmarks", name, self.cache.and_then(|(_, cached)| cached.keys.landmarks.as_ref()))?;
            // Another process may have ended meanwhile.
            cached = find();
        }
        let proposal = match cached {
            Some(proposal) => {
                self.report(clock.stop("landmarks", name, proposal.figures.clone()).reused());
                proposal
            }
            None => {
                self.progress.stage(&format!("landmarks ({name})"));
                let clock = Clock::start();
                let Prepared { source, target, clicks, allow_commands, .. } = self.prepared;
                let rising = Rising::default();
                let report = |share| rising.pass(share, |share| self.progress.done(share));
                let proposal = info_span!("landmarks", "type" = name)
                    .in_scope(|| propose(landmarks, [source, target], clicks, *allow_commands, Work::new(&report)));
                let proposal = proposal.map_err(|failure| doing(failure, format!("landmarks ({name})")));
                let proposal =
                    proposal.map_err(|failure| with_remedy(failure, GIVE_MARKERS, "give a file of `markers`"))?;
                self.report(clock.stop("landmarks", name, proposal.figures.clone()));
                if let Some((cache, key)) = key {
                    cache.put("landmarks", key, &proposal);
                }
                proposal
            }
        };
        drop(lock);
        self.prepared.markers.get_or_init(|| proposal.markers());
        self.proposal.get_or_init(|| proposal);
        Ok(())
    }

    /// The markers that a stage proposed, once it has run.
    pub fn proposal(&self) -> Option<&Proposal> {
        self.proposal.get()
    }

    /// The triangle map, if it is cached or has been computed.
    pub fn cached_map(&self) -> Option<&TriangleMap> {
        if let Some(map) = self.map.get() {
            return Some(map);
        }
        let clock = Clock::start();
        let (cache, cached) = self.cache?;
        let map: TriangleMap = cache.get("correspondence", cached.keys.correspondence.as_ref()?.key)?;
        let name = self.prepared.pipeline.correspondence.as_ref()?.typetag_name();
        self.report(clock.stop("correspondence", name, map.figures.clone()).reused());
        Some(self.map.get_or_init(|| map))
    }

    /// The triangle map; `None` for a pipeline without a correspondence.
    ///
    /// # Errors
    ///
    /// Those of the stage.
    pub fn map(&self) -> diagnostic::Result<Option<&TriangleMap>> {
        let Some(correspondence) = &self.prepared.pipeline.correspondence else { return Ok(None) };
        if let Some(map) = self.cached_map() {
            return Ok(Some(map));
        }
        let name = correspondence.typetag_name();
        let key = self.cache.and_then(|(_, cached)| cached.keys.correspondence.as_ref());
        let _lock = self.lock("correspondence", name, key)?;
        // Another process may have ended meanwhile.
        if let Some(map) = self.cached_map() {
            return Ok(Some(map));
        }
        let map = self.stage("correspondence", name, info_span!("correspondence", "type" = name), |work| {
            let mut map = correspondence.correspond_watched(self.pair(), work)?;
            map.check(self.pair())?;
            map.figures.set("orphans", map.orphan_count());
            let axis = self.prepared.target.mirror_axis();
            if let Some(warning) = handedness::warning_of_map(self.pair(), &map, axis)? {
                map.figures.warn(warning);
            }
            let figures = map.figures.clone();
            Ok((map, figures))
        })?;
        if let Some((cache, cached)) = self.cache
            && let Some(key) = &cached.keys.correspondence
        {
            cache.put("correspondence", key.key, &map);
        }
        Ok(Some(self.map.get_or_init(|| map)))
    }

    /// The bound transfer, if it was bound.
    pub fn bound_so_far(&self) -> Option<&dyn BoundTransfer> {
        self.bound.get().map(Box::as_ref)
    }

    /// The bound transfer.
    ///
    /// # Errors
    ///
    /// Those of the transfer, and of the correspondence that it needs.
    pub fn bound(&self) -> diagnostic::Result<&dyn BoundTransfer> {
        if let Some(bound) = self.bound.get() {
            return Ok(bound.as_ref());
        }
        let map = self.map()?;
        let Prepared { source, formats, poses, .. } = self.prepared;
        let learned = read_evenly_spaced(source, formats, poses, self.transfer.poses_wanted());
        let learned = learned.map_err(IntoDiagnostic::into_diagnostic)?;
        let name = self.transfer.typetag_name();
        let bound = self.stage("transfer", name, info_span!("transfer", "type" = name), |work| {
            let bound = self.transfer.bind(BindInput { pair: self.pair(), map, poses: &learned, work })?;
            let figures = bound.figures();
            Ok((bound, figures))
        })?;
        if let Some((cache, cached)) = self.cache {
            let summary = TransferSummary { figures: bound.figures(), motion: bound.motion().is_some() };
            cache.put("transfer", cached.keys.transfer.key, &summary);
        }
        Ok(self.bound.get_or_init(|| bound).as_ref())
    }

    /// Binds the transfer, unless an earlier run has told what is cached of it.
    ///
    /// # Errors
    ///
    /// Those of [`bound`](Self::bound), and those of [`Sharing::lock`].
    pub fn bind_once(&self) -> diagnostic::Result<()> {
        let find = || {
            let (cache, cached) = self.cache?;
            cache.get::<TransferSummary>("transfer", cached.keys.transfer.key)
        };
        let name = self.transfer.typetag_name();
        let clock = Clock::start();
        let mut summary = find();
        let mut lock = None;
        if summary.is_none() {
            lock = self.lock("transfer", name, self.cache.map(|(_, cached)| &cached.keys.transfer))?;
            summary = find();
        }
        match summary {
            Some(summary) => self.report(clock.stop("transfer", name, summary.figures).reused()),
            None => _ = self.bound()?,
        }
        drop(lock);
        Ok(())
    }

    /// The cached results of poses, once it is known whether they are frames of one motion.
    pub fn pose_cache(&self) -> Option<PoseCache<'a>> {
        let (cache, cached) = self.cache?;
        let order = self.order;
        let motion = match self.bound.get() {
            Some(bound) => bound.motion().is_some(),
            None => cached.transfer.as_ref()?.motion,
        };
        Some(PoseCache { cache, keys: &cached.keys, motion, order })
    }

    /// The cached results that may be used one by one: frames of one motion only where all are there.
    pub fn reusable_poses(&self) -> Option<PoseCache<'a>> {
        self.pose_cache().filter(|poses| self.is_complete() || !poses.motion)
    }

    /// Whether the results of all poses are cached.
    pub fn is_complete(&self) -> bool {
        self.cache.is_some_and(|(_, cached)| cached.complete)
    }

    /// Seconds that binding the transfer took, if it was bound.
    pub fn seconds_of_binding(&self) -> Option<f64> {
        let reports = self.reports.lock().unwrap_or_else(PoisonError::into_inner);
        reports.iter().find(|report| report.stage == "transfer" && !report.reused).map(|report| report.seconds)
    }

    /// Adds the report of a stage.
    pub fn report(&self, report: StageReport) {
        self.reports.lock().unwrap_or_else(PoisonError::into_inner).push(report);
    }

    /// The reports of the stages, in the order in which they ran.
    pub fn into_reports(self) -> Vec<StageReport> {
        self.reports.into_inner().unwrap_or_else(PoisonError::into_inner)
    }

    /// Runs a stage in its span, notes its time and figures, and names it in its error.
    fn stage<T>(
        &self,
        stage: &'static str,
        name: &str,
        span: Span,
        work: impl FnOnce(Work<'_>) -> Result<(T, Figures)>,
    ) -> diagnostic::Result<T> {
        self.progress.stage(&format!("{stage} ({name})"));
        let rising = Rising::default();
        let report = |share| rising.pass(share, |share| self.progress.done(share));
        let clock = Clock::start();
        match span.in_scope(|| work(Work::new(&report))) {
            Ok((result, figures)) => {
                self.report(clock.stop(stage, name, figures));
                Ok(result)
            }
            Err(error) => {
                let diagnostic = error.into_diagnostic();
                // Some errors name the stage themselves.
                let message = diagnostic.message.trim_start_matches(&format!("{stage}: ")).to_owned();
                Err(Diagnostic { message, ..diagnostic }.doing(format!("{stage} ({name})")).into())
            }
        }
    }
}
