//! What all pages hear of.

use std::sync::Arc;

use serde::Serialize;

use crate::{
    error::ApiError, job::JobView, markers::MarkersView, pipeline::PipelineView, project::SessionView, shared,
    worst::Worst,
};

/// A message of the server to every page.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum Event {
    /// Another project is open, or more is known of it.
    Session {
        /// The session.
        #[serde(serialize_with = "shared::serialize")]
        session: Arc<SessionView>,
    },
    /// The markers have changed.
    Markers {
        /// The document.
        #[serde(serialize_with = "shared::serialize")]
        markers: Arc<MarkersView>,
        /// What changed them.
        cause: Cause,
    },
    /// The pipeline has changed, or more is known of it.
    Pipeline {
        /// The pipeline.
        #[serde(serialize_with = "shared::serialize")]
        pipeline: Arc<PipelineView>,
        /// What changed it.
        cause: Cause,
    },
    /// A job goes on.
    Job {
        /// The job.
        #[serde(serialize_with = "shared::serialize")]
        job: Arc<JobView>,
    },
}

/// What changed a document.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Cause {
    /// A page.
    Edit,
    /// A page took a step back.
    Undo,
    /// A page did a step again.
    Redo,
    /// A stage.
    Propose,
    /// Somebody else, on the disk.
    Disk,
    /// It was opened.
    Open,
    /// It is the same, and was checked.
    Check,
}

/// What a socket says of its own.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum Message {
    /// The first message.
    Hello {
        /// The project, if one is open.
        project: Option<u64>,
        /// The revision of its markers.
        markers: u64,
        /// The revision of its pipeline.
        pipeline: u64,
    },
    /// How far a live result is.
    Live {
        /// The channel.
        channel: &'static str,
        /// The state.
        state: LiveState,
        /// The revision of the markers.
        revision: u64,
        /// The stage under way.
        stage: Option<String>,
        /// How much of it is done.
        share: Option<f64>,
        /// Why there is none.
        error: Option<ApiError>,
    },
    /// What is worst in the pose that the page looks at.
    Worst {
        /// The channel.
        channel: &'static str,
        /// The revision of the markers.
        revision: u64,
        /// Statistics above their limits, worst first.
        list: Vec<Worst>,
    },
    /// How many frames of the clip have a result that can be played.
    Ahead {
        /// The revision of the markers.
        revision: u64,
        /// The revision of the pipeline.
        pipeline: u64,
        /// How many are there.
        done: usize,
        /// How many there will be.
        count: usize,
        /// How far they lie apart: 1 if all frames are among them.
        step: usize,
        /// The colour map that they have.
        scalar: Option<String>,
        /// Why there will be no more.
        error: Option<ApiError>,
    },
    /// A message of the page made no sense.
    Error {
        /// Why.
        error: ApiError,
    },
}

/// How far a live result is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LiveState {
    /// It is under way.
    Computing,
    /// It was sent.
    Ready,
    /// Something is missing.
    Unavailable,
    /// It could not be computed.
    Failed,
}
