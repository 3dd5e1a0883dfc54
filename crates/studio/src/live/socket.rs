//! The WebSocket of a page.

use std::{sync::Arc, time::Instant};

use axum::extract::ws::{CloseFrame, Message as Frame, WebSocket};
use serde::Serialize;
use tokio::sync::{broadcast::error::RecvError, mpsc, watch};

use super::{
    look::ToServer,
    page::{Page, ToPage, Wish},
};
use crate::{
    error::ApiError,
    events::{Cause, Event, Message},
    studio::Studio,
};

/// The most bytes of a message of the page.
pub const MAX_MESSAGE: usize = 64 << 10;

/// How many messages a page may send a second, and at once.
const RATE: f64 = 100.0;
const BURST: f64 = 200.0;

/// The code of a socket that is closed because of what the page did.
const POLICY: u16 = 1008;

/// How many frames and messages wait for a page that is slow.
const WAITING: usize = 4;

/// Serves the socket of a page until it is closed.
pub async fn serve(mut socket: WebSocket, studio: Arc<Studio>) {
    let mut events = studio.events.subscribe();
    if send(&mut socket, &hello(&studio)).await.is_none() {
        return;
    }
    let (wishes, receiver) = watch::channel(Wish::default());
    let (out, mut outgoing) = mpsc::channel(WAITING);
    Page { studio: studio.clone(), out }.attend(&receiver);
    let mut rate = Rate::new();
    loop {
        let sent = tokio::select! {
            event = events.recv() => match event {
                Ok(event) => {
                    if changes_frames(&event) {
                        wishes.send_modify(|wish| wish.changed(&event));
                    }
                    send(&mut socket, &event).await
                }
                Err(RecvError::Lagged(_)) => {
                    wishes.send_modify(|wish| wish.changes += 1);
                    tell_all(&mut socket, &studio).await
                }
                Err(RecvError::Closed) => return,
            },
            Some(message) = outgoing.recv() => match message {
                ToPage::Frame(bytes) => socket.send(Frame::Binary(bytes.into())).await.ok(),
                ToPage::Message(message) => send(&mut socket, &message).await,
            },
            message = socket.recv() => match message {
                Some(Ok(Frame::Close(_)) | Err(_)) | None => return,
                Some(Ok(_)) if !rate.passes() => {
                    let frame = CloseFrame { code: POLICY, reason: "too many messages".into() };
                    let _ = socket.send(Frame::Close(Some(frame))).await;
                    return;
                }
                Some(Ok(Frame::Text(text))) => match wish(&text, &wishes, &studio) {
                    Ok(()) => Some(()),
                    Err(error) => send(&mut socket, &Message::Error { error }).await,
                },
                Some(Ok(Frame::Binary(_))) => {
                    let error = ApiError::bad("expected a text, found a binary message");
                    send(&mut socket, &Message::Error { error }).await
                }
                Some(Ok(_)) => Some(()),
            },
        };
        if sent.is_none() {
            return;
        }
    }
}

/// Takes a message of the page for its new wish.
fn wish(text: &str, wishes: &watch::Sender<Wish>, studio: &Studio) -> Result<(), ApiError> {
    let message: ToServer =
        serde_json::from_str(text).map_err(|error| ApiError::bad(format!("the message: {error}")))?;
    match message {
        ToServer::Look(look) => wishes.send_modify(|wish| wish.look = Some(look)),
        ToServer::Drag(drag) => {
            let now = studio.current().map_or(0, |project| project.markers.revision());
            // The end of a drag that an edit has ended already asks for nothing.
            wishes.send_if_modified(|wish| {
                let was_dragged = wish.drag.is_some();
                wish.drag = Some(drag).filter(|drag| drag.point.is_some());
                wish.dragged_at = now;
                was_dragged || wish.drag.is_some()
            });
        }
    }
    Ok(())
}

/// Whether other frames come of what has happened.
fn changes_frames(event: &Event) -> bool {
    match event {
        Event::Session { .. } | Event::Markers { .. } => true,
        Event::Pipeline { .. } | Event::Job { .. } => false,
    }
}

fn hello(studio: &Studio) -> Message {
    let project = studio.current();
    Message::Hello {
        project: project.as_ref().map(|project| project.number),
        markers: project.as_ref().map_or(0, |project| project.markers.revision()),
        pipeline: project.as_ref().map_or(0, |project| project.pipeline.revision()),
    }
}

/// Tells a page that was too slow how things are now.
async fn tell_all(socket: &mut WebSocket, studio: &Studio) -> Option<()> {
    send(socket, &Event::Session { session: studio.session() }).await?;
    let Some(project) = studio.current() else { return Some(()) };
    send(socket, &Event::Markers { markers: project.markers.view(), cause: Cause::Open }).await?;
    send(socket, &Event::Pipeline { pipeline: project.pipeline.view(), cause: Cause::Open }).await
}

/// `None` if the page is gone.
async fn send(socket: &mut WebSocket, message: &impl Serialize) -> Option<()> {
    let text = serde_json::to_string(message).ok()?;
    socket.send(Frame::Text(text.into())).await.ok()
}

/// A bucket of messages that fills with time.
struct Rate {
    left: f64,
    at: Instant,
}

impl Rate {
    fn new() -> Self {
        Self { left: BURST, at: Instant::now() }
    }

    /// Whether one more message is within the rate.
    fn passes(&mut self) -> bool {
        let now = Instant::now();
        self.left = (self.left + RATE * (now - self.at).as_secs_f64()).min(BURST);
        self.at = now;
        if self.left < 1.0 {
            return false;
        }
        self.left -= 1.0;
        true
    }
}
