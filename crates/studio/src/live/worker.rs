//! What is done for a page that looks: frames at once, and results a moment later.
//!
//! The loops wait for something new to show. Each takes the newest wish only, so that a page that scrolls through poses, or drags a point,
//! never waits for what it does not want any more.

use std::time::Instant;

use tokio::sync::watch;

use super::{
    confidence,
    frame::Shown,
    look::{Channel, Look},
    measure::Looked,
    page::{CALM, Page, Wish, failed, state, truth_at},
    pair::LiveMarkers,
    result::can_have_result,
};
use crate::{
    cancel::{Cancel, Stopped},
    error::{ApiError, Code, Result},
    events::{LiveState, Message},
    project::Project,
    scalars,
};

impl Page {
    /// Begins the loops for the page, which tells its wishes by `wishes`; they end with it.
    pub fn attend(self, wishes: &watch::Receiver<Wish>) {
        tokio::spawn(self.clone().at_once(wishes.clone()));
        tokio::spawn(self.clone().a_moment_later(wishes.clone()));
        tokio::spawn(self.ahead(wishes.clone()));
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
        let pipeline = project.pipeline.revision();
        let source = match project.source_at(&look.pose) {
            Ok(source) => source,
            Err(error) => return self.tell_now(Message::Error { error }),
        };
        let plain =
            LiveMarkers { revision: project.markers.revision(), drag: None, markers: vec![], confidences: vec![] };
        if look.channels.contains(&Channel::Source) && is_new_look {
            let shown = Shown { project: &project, channel: Channel::Source, look, live: &plain, pipeline, began };
            self.frame(shown.frame(&source, None));
        }
        if look.channels.contains(&Channel::Truth) && is_new_look {
            match truth_at(&project, &look.pose) {
                Some(truth) => {
                    let shown =
                        Shown { project: &project, channel: Channel::Truth, look, live: &plain, pipeline, began };
                    self.frame(shown.frame(&truth, None));
                }
                None => {
                    let error = ApiError::new(Code::NotFound, "the result of this pose is not known");
                    self.tell_now(state("truth", LiveState::Unavailable, plain.revision, Some(error)));
                }
            }
        }
        if look.channels.contains(&Channel::Result) && is_new_look {
            if let Err(error) = can_have_result(&project) {
                self.tell_now(state("result", LiveState::Unavailable, plain.revision, Some(error)));
            } else if wish.drag.is_none() && self.computed_before(&project, look) {
                return;
            }
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
                let shown = Shown { project: &project, channel: Channel::Preview, look, live: &live, pipeline, began };
                self.frame(shown.frame(&target, colours.as_ref()));
                self.tell_now(state("preview", LiveState::Ready, live.revision, None));
            }
            Err(error) => self.tell_now(state("preview", failed(&error), live.revision, Some(error))),
        }
    }

    /// Sends the result of a frame that was computed ahead; whether it was.
    fn computed_before(&self, project: &Project, look: &Look) -> bool {
        let began = Instant::now();
        let live = LiveMarkers::new(project, None);
        let Some(index) = look.pose.index() else { return false };
        let Some(bound) = self.studio.results.at_hand(project, &live) else { return false };
        let Some((positions, field)) = bound.frames.get(index, look.scalar.as_deref()) else { return false };
        let pipeline = bound.pipeline();
        let shown = Shown { project, channel: Channel::Result, look, live: &live, pipeline, began };
        self.frame(shown.relative_frame(&positions, field.as_deref()));
        true
    }

    /// The pipeline's own result, when nothing has changed for a moment.
    async fn a_moment_later(self, mut wishes: watch::Receiver<Wish>) {
        while wishes.changed().await.is_ok() {
            loop {
                // Changes that come meanwhile put it off.
                while tokio::time::timeout(CALM, wishes.changed()).await.is_ok_and(|changed| changed.is_ok()) {}
                let wish = wishes.borrow_and_update().clone();
                // The preview needs the processor. When the drag is over the page wants the result in place of it.
                if wish.drag.is_some() {
                    break;
                }
                // Another pose stops the frame. Other markers or settings and a drag also stop the binding, which all poses share.
                let (cancel, unbind) = (Cancel::default(), Cancel::default());
                let (page, stop, stop_binding, of) = (self.clone(), cancel.clone(), unbind.clone(), wish.clone());
                let mut work = tokio::task::spawn_blocking(move || stop.run(|| page.slow(&of, &stop, &stop_binding)));
                let done = loop {
                    tokio::select! {
                        done = &mut work => break Some(done),
                        changed = wishes.changed() => match changed {
                            Ok(()) if !is_wanted(&wish, &wishes.borrow()) => {
                                cancel.cancel();
                                if wish.changes != wishes.borrow().changes || wishes.borrow().drag.is_some() {
                                    unbind.cancel();
                                    break None;
                                }
                            }
                            Ok(()) => {}
                            Err(_) => {
                                cancel.cancel();
                                unbind.cancel();
                                return;
                            }
                        },
                    }
                };
                match done {
                    Some(Ok(Err(Stopped::Panicked(words)))) => {
                        let error = ApiError::new(Code::Internal, format!("the program made a mistake: {words}"));
                        self.tell(state("result", LiveState::Failed, 0, Some(error))).await;
                    }
                    Some(Ok(Err(Stopped::Cancelled))) => continue,
                    Some(_) => {}
                    None => {
                        let _ = work.await;
                        continue;
                    }
                }
                // A wish that came when it was too late to stop the work was taken note of above, and must not be forgotten.
                if is_wanted(&wish, &wishes.borrow()) {
                    break;
                }
            }
        }
    }

    fn slow(&self, wish: &Wish, cancel: &Cancel, unbind: &Cancel) {
        let (Some(look), Some(project)) = (&wish.look, self.studio.current()) else { return };
        if !look.channels.contains(&Channel::Result) {
            return;
        }
        let began = Instant::now();
        let live = LiveMarkers::new(&project, None);
        match self.slow_frame(&project, look, &live, [cancel, unbind], began) {
            Ok(()) => {}
            Err(error) => self.tell_now(state("result", failed(&error), live.revision, Some(error))),
        }
    }

    fn slow_frame(
        &self,
        project: &Project,
        look: &Look,
        live: &LiveMarkers,
        [cancel, unbind]: [&Cancel; 2],
        began: Instant,
    ) -> Result<()> {
        let source = project.source_at(&look.pose)?;
        let report = self.computing(live.revision);
        let bound = self.studio.results.bound(project, live, unbind, &report)?;
        cancel.check();
        let target = bound.at(project, &look.pose, &source)?;
        cancel.check();
        let truth = truth_at(project, &look.pose);
        let looked = bound.looked(&source, &target, truth.as_deref());
        let colours = look.scalar.as_deref().and_then(|name| match name {
            scalars::CONFIDENCE => Some(confidence::field(&project.meshes, live)),
            _ => looked.field(name),
        });
        let shown = Shown { project, channel: Channel::Result, look, live, pipeline: bound.pipeline(), began };
        self.frame(shown.frame(&target, colours.as_ref()));
        self.tell_now(state("result", LiveState::Ready, live.revision, None));
        cancel.check();
        let list = looked.worst(project, look.pose.index());
        self.tell_now(Message::Worst { channel: "result", revision: live.revision, list });
        Ok(())
    }
}

/// Whether the result that `begun` asked for is still wanted.
fn is_wanted(begun: &Wish, newest: &Wish) -> bool {
    begun.look == newest.look && begun.changes == newest.changes && newest.drag.is_none()
}

#[cfg(test)]
mod tests {
    use serde_json::{from_value, json};

    use super::*;

    #[test]
    fn a_drag_or_another_pose_makes_a_result_unwanted() {
        let look = |index| Some(from_value(json!({ "look": 1, "pose": { "index": index }, "channels": [] })).unwrap());
        let begun = Wish { look: look(0), ..Wish::default() };
        assert!(is_wanted(&begun, &begun.clone()));
        assert!(!is_wanted(&begun, &Wish { look: look(1), ..Wish::default() }));
        let drag = json!({ "drag": 1, "pair": 1, "side": "target", "point": { "vertex": 3 } });
        assert!(!is_wanted(&begun, &Wish { drag: from_value(drag).unwrap(), ..begun.clone() }));
    }
}
