//! A page that looks: what it wants, and the way to it.

use std::{
    sync::{Arc, Mutex, PoisonError},
    time::{Duration, Instant},
};

use tokio::sync::mpsc;

use super::look::{Drag, Look, PoseRef};
use crate::{
    error::{ApiError, Code},
    events::{Event, LiveState, Message},
    project::Project,
    studio::Studio,
};

/// A result is begun when nothing has changed for this long.
pub(super) const CALM: Duration = Duration::from_millis(120);

/// Pages hear of a result under way no oftener than this.
pub(super) const STEP: Duration = Duration::from_millis(100);

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
    pub(super) studio: Arc<Studio>,
    pub(super) out: mpsc::Sender<ToPage>,
}

impl Page {
    /// Tells the page what is under way, now and then.
    pub(super) fn computing(&self, revision: u64) -> impl Fn(&str, f64) + Sync {
        let told: Mutex<Option<(String, Instant)>> = Mutex::new(None);
        move |stage: &str, share: f64| {
            let mut told = told.lock().unwrap_or_else(PoisonError::into_inner);
            if told.as_ref().is_some_and(|(name, at)| name == stage && at.elapsed() < STEP) {
                return;
            }
            *told = Some((stage.into(), Instant::now()));
            self.tell_now(Message::Live {
                channel: "result",
                state: LiveState::Computing,
                revision,
                stage: Some(stage.into()),
                share: Some(share),
                error: None,
            });
        }
    }

    /// Sends a frame.
    pub(super) fn frame(&self, bytes: Vec<u8>) {
        // The page may be gone; else this waits until it takes the frame.
        let _ = self.out.blocking_send(ToPage::Frame(bytes));
    }

    pub(super) fn tell_now(&self, message: Message) {
        let _ = self.out.blocking_send(ToPage::Message(message));
    }

    pub(super) async fn tell(&self, message: Message) {
        let _ = self.out.send(ToPage::Message(message)).await;
    }
}

pub(super) fn state(channel: &'static str, state: LiveState, revision: u64, error: Option<ApiError>) -> Message {
    Message::Live { channel, state, revision, stage: None, share: None, error }
}

/// Something that is missing is no failure.
pub(super) fn failed(error: &ApiError) -> LiveState {
    if error.code == Code::NotFound { LiveState::Unavailable } else { LiveState::Failed }
}

/// The vertices of the target's file in a pose, if they are known.
pub(super) fn truth_at(project: &Project, pose: &PoseRef) -> Option<Vec<nalgebra::Point3<f64>>> {
    let ready = project.ready()?;
    let prepared = &ready.prepared;
    let rest = &prepared.target.sequence.rest;
    match pose {
        PoseRef::Rest if !prepared.truth.is_none() => Some(rest.positions.clone()),
        PoseRef::Index { index } => {
            let place = ready.place_of(project.poses.get(*index)?)?;
            let name = &prepared.poses.get(place)?.name;
            prepared.truth.positions(place, name, rest, &prepared.formats).ok().flatten()
        }
        _ => None,
    }
}
