//! Results of all frames, computed ahead, so that the result can be played.
//!
//! The frames lie with the transfer that they come from, so all pages share them, and they go with it.

use std::{
    sync::{
        Arc,
        atomic::{AtomicUsize, Ordering},
    },
    time::Instant,
};

use mimesh_core::{mesh::PosesAre, stage::BoundMetric};
use nalgebra::Vector3;
use rayon::prelude::*;
use tokio::sync::watch;

use super::{
    confidence,
    frames::step_for,
    look::PoseRef,
    measure::Field,
    page::{CALM, Page, STEP, ToPage, Wish, failed, state, truth_at},
    pair::LiveMarkers,
    result::BoundResult,
};
use crate::{
    cancel::{Cancel, Stopped},
    container,
    error::{ApiError, Code, Result},
    events::Message,
    project::Project,
    scalars,
};

/// What is to be computed ahead.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Wanted {
    changes: u64,
    scalar: Option<String>,
}

impl Wanted {
    /// Nothing while a point is dragged: the preview needs the processor, and the frames change when the drag ends.
    fn of(wish: &Wish) -> Option<Self> {
        let look = wish.look.as_ref().filter(|look| look.ahead && wish.drag.is_none())?;
        Some(Self { changes: wish.changes, scalar: look.scalar.clone() })
    }
}

impl Page {
    /// Results of all frames, whenever markers, the pipeline or the colours have changed.
    pub(super) async fn ahead(self, mut wishes: watch::Receiver<Wish>) {
        let mut done: Option<Wanted> = None;
        while wishes.changed().await.is_ok() {
            loop {
                let newest = Wanted::of(&wishes.borrow_and_update());
                let Some(wanted) = newest.filter(|wanted| Some(wanted) != done.as_ref()) else { break };
                tokio::time::sleep(CALM).await;
                if Wanted::of(&wishes.borrow()).as_ref() != Some(&wanted) {
                    continue;
                }
                let cancel = Cancel::default();
                let (page, stop, scalar) = (self.clone(), cancel.clone(), wanted.scalar.clone());
                let mut work = tokio::task::spawn_blocking(move || stop.run(|| page.prepare(scalar.as_deref(), &stop)));
                let ended = loop {
                    tokio::select! {
                        ended = &mut work => break ended,
                        changed = wishes.changed() => {
                            if changed.is_err() {
                                return cancel.cancel();
                            }
                            if Wanted::of(&wishes.borrow_and_update()).as_ref() != Some(&wanted) {
                                cancel.cancel();
                            }
                        }
                    }
                };
                match ended {
                    Ok(Err(Stopped::Cancelled)) => {}
                    Ok(Err(Stopped::Panicked(words))) => {
                        let error = ApiError::new(Code::Internal, format!("the program made a mistake: {words}"));
                        self.tell(Message::Error { error }).await;
                        done = Some(wanted);
                    }
                    _ => done = Some(wanted),
                }
            }
        }
    }

    fn prepare(&self, scalar: Option<&str>, cancel: &Cancel) {
        let Some(project) = self.studio.current().filter(|project| project.poses_are == PosesAre::Frames) else {
            return;
        };
        let live = LiveMarkers::new(&project, None);
        let step = step_for(project.poses.len(), project.meshes.sides[1].sequence.rest.positions.len());
        let count = project.poses.len().div_ceil(step);
        let told = |done: usize, pipeline: u64, error: Option<ApiError>| {
            let (revision, scalar) = (live.revision, scalar.map(Into::into));
            Message::Ahead { revision, pipeline, done, count, step, scalar, error }
        };
        let pipeline = project.pipeline.revision();
        let bound = match self.studio.results.bound(&project, &live, cancel, &self.computing(live.revision)) {
            Ok(bound) => bound,
            Err(error) => {
                self.tell_now(state("result", failed(&error), live.revision, Some(error.clone())));
                return self.tell_now(told(0, pipeline, Some(error)));
            }
        };
        let pipeline = bound.pipeline();
        let frames: Vec<usize> = (0..project.poses.len()).step_by(step).collect();
        let there = frames.iter().filter(|i| bound.frames.get(**i, scalar).is_some()).count();
        self.tell_now(told(there, pipeline, None));
        let done = AtomicUsize::new(there);
        let progress = |latest: Instant| {
            let done = done.fetch_add(1, Ordering::Relaxed) + 1;
            if latest.elapsed() < STEP {
                return latest;
            }
            // A page that is slow hears of it later.
            let _ = self.out.try_send(ToPage::Message(told(done, pipeline, None)));
            Instant::now()
        };
        let missing: Vec<usize> = frames.into_iter().filter(|i| bound.frames.get(*i, scalar).is_none()).collect();
        let ahead = Ahead::new(&project, &live, &bound, scalar);
        let computed = self.studio.calm_pool.install(|| {
            let computed = missing.into_par_iter().with_max_len(4).try_fold(Instant::now, |latest, i| {
                cancel.check();
                ahead.frame(i)?;
                Ok(progress(latest))
            });
            computed.try_reduce(Instant::now, |latest, _| Ok(latest))
        });
        match computed {
            Ok(_) => self.tell_now(told(count, pipeline, None)),
            Err(error) => self.tell_now(told(done.into_inner(), pipeline, Some(error))),
        }
    }
}

/// Computes single frames.
struct Ahead<'a> {
    project: &'a Project,
    bound: &'a BoundResult,
    origin: Vector3<f64>,
    scalar: Option<&'a str>,
    metric: Option<Box<dyn BoundMetric + 'a>>,
    /// Colours that are the same in all frames.
    confidence: Option<Arc<Field>>,
}

impl<'a> Ahead<'a> {
    fn new(project: &'a Project, live: &LiveMarkers, bound: &'a BoundResult, scalar: Option<&'a str>) -> Self {
        let rest = &project.meshes.sides[0].sequence.rest.positions;
        let target = &project.meshes.sides[1].sequence.rest.positions;
        let metric = scalar.and_then(|name| bound.looked(rest, target, None).bound_metric(name));
        let is_confidence = scalar == Some(scalars::CONFIDENCE);
        let confidence = is_confidence.then(|| Arc::new(confidence::field(&project.meshes, live)));
        Self { project, bound, origin: project.meshes.origins[1], scalar, metric, confidence }
    }

    /// The frame `index` with its colours.
    fn frame(&self, index: usize) -> Result<()> {
        let frames = &self.bound.frames;
        let source = self.project.pose(index)?;
        let target = match frames.positions(index) {
            Some(positions) => container::absolute(&positions, self.origin),
            None => {
                let target = self.bound.at(self.project, &PoseRef::Index { index }, &source)?;
                frames.put(index, Arc::new(container::relative(&target, self.origin)));
                target
            }
        };
        let Some(scalar) = self.scalar else { return Ok(()) };
        let field = self.confidence.clone().or_else(|| {
            let pose = PoseRef::Index { index };
            let truth = truth_at(self.project, &pose);
            let looked = self.bound.looked(&source, &target, truth.as_deref());
            looked.field_of(self.metric.as_deref()?).map(Arc::new)
        });
        frames.put_field(index, scalar, field);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use serde_json::{from_value, json};

    use super::*;

    #[test]
    fn nothing_is_computed_ahead_during_a_drag() {
        let look = json!({ "look": 1, "pose": { "index": 0 }, "channels": ["result"], "ahead": true });
        let drag = json!({ "drag": 1, "pair": 1, "side": "target", "point": { "vertex": 3 } });
        let mut wish = Wish { look: Some(from_value(look).unwrap()), ..Wish::default() };
        assert!(Wanted::of(&wish).is_some());
        wish.drag = Some(from_value(drag).unwrap());
        assert_eq!(Wanted::of(&wish), None);
    }
}
