//! What is done for a page that looks: frames at once, and results a moment later.
//!
//! Two loops wait for something new to show. Each takes the newest wish only, so that a page that scrolls through poses, or drags a point,
//! never waits for what it does not want any more.

use std::{
    sync::{Arc, Mutex, PoisonError},
    time::{Duration, Instant},
};

use tokio::sync::{mpsc, watch};

use super::{
    confidence,
    frame::Shown,
    look::{Channel, Drag, Look, PoseRef},
    pair::LiveMarkers,
    result::{Looked, can_have_result},
};
use crate::{
    cancel::{Cancel, Stopped},
    error::{ApiError, Code, Result},
    events::{Event, LiveState, Message},
    project::Project,
    scalars,
    studio::Studio,
};

/// A result is begun when nothing has changed for this long.
const CALM: Duration = Duration::from_millis(120);

/// Pages hear of a result under way no oftener than this.
const STEP: Duration = Duration::from_millis(100);

/// What a page wants to see.
#[derive(Clone, Debug, Default)]
pub struct Wish {
    /// The last look.
    pub look: Option<Look>,
    /// The last drag.
    pub drag: Option<Drag>,
    /// The revision of the markers when it came; who changes its pair after that ends it.
    pub dragged_at: u64,
    /// Rises when markers or the pipeline have changed.
    pub changes: u64,
}

impl Wish {
    /// Takes note of what has changed.
    pub fn changed(&mut self, event: &Event) {
        self.changes += 1;
        if let Event::Markers { markers, .. } = event
            && self.drag.as_ref().is_some_and(|drag| markers.changed_since(drag.pair, self.dragged_at))
        {
            self.drag = None;
        }
    }
}

/// What goes to a page.
#[derive(Clone, Debug)]
pub enum ToPage {
    /// A frame.
    Frame(Vec<u8>),
    /// A message.
    Message(Message),
}

/// The way to a page.
#[derive(Clone, Debug)]
pub struct Page {
    studio: Arc<Studio>,
    out: mpsc::Sender<ToPage>,
}

impl Page {
    /// Begins the two loops for a page that tells its wishes by `wishes`; they end with it.
    pub fn attend(studio: Arc<Studio>, wishes: &watch::Receiver<Wish>, out: mpsc::Sender<ToPage>) {
        let page = Self { studio, out };
        tokio::spawn(page.clone().at_once(wishes.clone()));
        tokio::spawn(page.a_moment_later(wishes.clone()));
    }

    /// Source, truth and preview, whenever something is wished.
    async fn at_once(self, mut wishes: watch::Receiver<Wish>) {
        let mut shown: Option<Wish> = None;
        while wishes.changed().await.is_ok() {
            let wish = wishes.borrow_and_update().clone();
            let (page, before) = (self.clone(), shown.replace(wish.clone()));
            if tokio::task::spawn_blocking(move || page.fast(&wish, before.as_ref())).await.is_err() {
                let error = ApiError::new(Code::Internal, "the preview failed by a mistake of the program");
                self.tell(Message::Error { error }).await;
            }
        }
    }

    fn fast(&self, wish: &Wish, before: Option<&Wish>) {
        let (Some(look), Some(project)) = (&wish.look, self.studio.current()) else { return };
        let is_new_look = before.and_then(|before| before.look.as_ref()) != Some(look);
        let began = Instant::now();
        let source = match project.source_at(&look.pose) {
            Ok(source) => source,
            Err(error) => return self.tell_now(Message::Error { error }),
        };
        let plain =
            LiveMarkers { revision: project.markers.revision(), drag: None, markers: vec![], confidences: vec![] };
        if look.channels.contains(&Channel::Source) && is_new_look {
            let shown = Shown { project: &project, channel: Channel::Source, look, live: &plain, began };
            self.frame(shown.frame(&source, None));
        }
        if look.channels.contains(&Channel::Truth) && is_new_look {
            match truth_at(&project, &look.pose) {
                Some(truth) => {
                    let shown = Shown { project: &project, channel: Channel::Truth, look, live: &plain, began };
                    self.frame(shown.frame(&truth, None));
                }
                None => {
                    let error = ApiError::new(Code::NotFound, "the result of this pose is not known");
                    self.tell_now(state("truth", LiveState::Unavailable, plain.revision, Some(error)));
                }
            }
        }
        if look.channels.contains(&Channel::Result)
            && is_new_look
            && let Err(error) = can_have_result(&project)
        {
            self.tell_now(state("result", LiveState::Unavailable, plain.revision, Some(error)));
        }
        if !look.channels.contains(&Channel::Preview) {
            return;
        }
        let live = LiveMarkers::new(&project, wish.drag.as_ref());
        let began = Instant::now();
        let previewed = self.studio.fast_pool.install(|| self.studio.preview.at(&project, &live, &source));
        match previewed {
            Ok(target) => {
                let ready = project.ready();
                let truth = truth_at(&project, &look.pose);
                let colours = look.scalar.as_deref().and_then(|name| match (name, ready.as_ref()) {
                    (scalars::CONFIDENCE, _) => Some(confidence::field(&project.meshes, &live)),
                    (_, Some(ready)) => {
                        let truth = truth.as_deref();
                        Looked { ready, live: &live, map: None, source: &source, target: &target, truth }.field(name)
                    }
                    _ => None,
                });
                let shown = Shown { project: &project, channel: Channel::Preview, look, live: &live, began };
                self.frame(shown.frame(&target, colours.as_ref()));
                self.tell_now(state("preview", LiveState::Ready, live.revision, None));
            }
            Err(error) => self.tell_now(state("preview", failed(&error), live.revision, Some(error))),
        }
    }

    /// The pipeline's own result, when nothing has changed for a moment.
    async fn a_moment_later(self, mut wishes: watch::Receiver<Wish>) {
        let mut shown: Option<Wish> = None;
        while wishes.changed().await.is_ok() {
            loop {
                // Changes that come meanwhile put it off.
                while tokio::time::timeout(CALM, wishes.changed()).await.is_ok_and(|changed| changed.is_ok()) {}
                let wish = wishes.borrow_and_update().clone();
                // The page has it. When the drag is over it wants it again, in place of the preview.
                if wish.drag.is_some() && shown.as_ref().is_some_and(|shown| is_same_result(shown, &wish)) {
                    break;
                }
                shown = None;
                let cancel = Cancel::default();
                let (page, stop, of) = (self.clone(), cancel.clone(), wish.clone());
                let mut work = tokio::task::spawn_blocking(move || stop.run(|| page.slow(&of, &stop)));
                let done = loop {
                    tokio::select! {
                        done = &mut work => break Some(done),
                        changed = wishes.changed() => match changed {
                            Ok(()) if !is_same_result(&wish, &wishes.borrow()) => {
                                cancel.cancel();
                                break None;
                            }
                            Ok(()) => {}
                            Err(_) => {
                                cancel.cancel();
                                return;
                            }
                        },
                    }
                };
                match done {
                    Some(Ok(Err(Stopped::Panicked(words)))) => {
                        let error = ApiError::new(Code::Internal, format!("the program made a mistake: {words}"));
                        self.tell(state("result", LiveState::Failed, 0, Some(error))).await;
                        break;
                    }
                    Some(_) => {
                        shown = Some(wish);
                        break;
                    }
                    None => _ = work.await,
                }
            }
        }
    }

    fn slow(&self, wish: &Wish, cancel: &Cancel) {
        let (Some(look), Some(project)) = (&wish.look, self.studio.current()) else { return };
        if !look.channels.contains(&Channel::Result) {
            return;
        }
        let began = Instant::now();
        let live = LiveMarkers::new(&project, None);
        match self.slow_frame(&project, look, &live, cancel, began) {
            Ok(()) => {}
            Err(error) => self.tell_now(state("result", failed(&error), live.revision, Some(error))),
        }
    }

    fn slow_frame(
        &self,
        project: &Project,
        look: &Look,
        live: &LiveMarkers,
        cancel: &Cancel,
        began: Instant,
    ) -> Result<()> {
        let source = project.source_at(&look.pose)?;
        let told: Mutex<Option<(String, Instant)>> = Mutex::new(None);
        let report = |stage: &str, share: f64| {
            let mut told = told.lock().unwrap_or_else(PoisonError::into_inner);
            if told.as_ref().is_some_and(|(name, at)| name == stage && at.elapsed() < STEP) {
                return;
            }
            *told = Some((stage.into(), Instant::now()));
            self.tell_now(Message::Live {
                channel: "result",
                state: LiveState::Computing,
                revision: live.revision,
                stage: Some(stage.into()),
                share: Some(share),
                error: None,
            });
        };
        let bound = self.studio.results.bound(project, live, cancel, &report)?;
        cancel.check();
        let target = bound.at(&source)?;
        cancel.check();
        let truth = truth_at(project, &look.pose);
        let looked = bound.looked(&source, &target, truth.as_deref());
        let colours = look.scalar.as_deref().and_then(|name| match name {
            scalars::CONFIDENCE => Some(confidence::field(&project.meshes, live)),
            _ => looked.field(name),
        });
        let shown = Shown { project, channel: Channel::Result, look, live, began };
        self.frame(shown.frame(&target, colours.as_ref()));
        self.tell_now(state("result", LiveState::Ready, live.revision, None));
        cancel.check();
        let list = looked.worst(look.pose.index());
        self.tell_now(Message::Worst { channel: "result", revision: live.revision, list });
        Ok(())
    }

    fn frame(&self, bytes: Vec<u8>) {
        // The page may be gone; else this waits until it takes the frame.
        let _ = self.out.blocking_send(ToPage::Frame(bytes));
    }

    fn tell_now(&self, message: Message) {
        let _ = self.out.blocking_send(ToPage::Message(message));
    }

    async fn tell(&self, message: Message) {
        let _ = self.out.send(ToPage::Message(message)).await;
    }
}

/// Whether both wishes have the same result: a drag alone has no other.
fn is_same_result(a: &Wish, b: &Wish) -> bool {
    a.look == b.look && a.changes == b.changes
}

fn state(channel: &'static str, state: LiveState, revision: u64, error: Option<ApiError>) -> Message {
    Message::Live { channel, state, revision, stage: None, share: None, error }
}

/// Something that is missing is no failure.
fn failed(error: &ApiError) -> LiveState {
    if error.code == Code::NotFound { LiveState::Unavailable } else { LiveState::Failed }
}

/// The vertices of the target's file in a pose, if they are known.
fn truth_at(project: &Project, pose: &PoseRef) -> Option<Vec<nalgebra::Point3<f64>>> {
    let ready = project.ready()?;
    let prepared = &ready.prepared;
    let rest = &prepared.target.sequence.rest;
    match pose {
        PoseRef::Rest if !prepared.truth.is_none() => Some(rest.positions.clone()),
        PoseRef::Index { index } => {
            let name = &prepared.poses.get(*index)?.name;
            prepared.truth.positions(*index, name, rest, &prepared.formats).ok().flatten()
        }
        _ => None,
    }
}
