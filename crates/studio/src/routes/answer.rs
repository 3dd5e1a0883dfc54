//! What all routes answer with.

use std::sync::Arc;

use axum::{
    Json,
    extract::State,
    http::{HeaderValue, StatusCode, header},
    response::{IntoResponse, Response},
};
use serde::Serialize;

use crate::{
    error::{ApiError, Code, Result},
    project::Project,
    studio::Studio,
};

/// The state of the server, as a route gets it.
pub(super) type App = State<Arc<Studio>>;

/// Does work that takes long where it does not keep others waiting.
pub(super) async fn blocking<T: Send + 'static>(work: impl FnOnce() -> T + Send + 'static) -> Result<T> {
    tokio::task::spawn_blocking(work)
        .await
        .map_err(|error| ApiError::new(Code::Internal, format!("the program made a mistake: {error}")))
}

/// An answer with a status of its own.
pub(super) fn with_status(status: StatusCode, body: impl Serialize) -> Response {
    (status, Json(body)).into_response()
}

/// An answer.
pub(super) fn json(body: &impl Serialize) -> Response {
    with_status(StatusCode::OK, body)
}

/// An answer of bytes.
pub(super) fn binary(bytes: Vec<u8>) -> Response {
    ([(header::CONTENT_TYPE, HeaderValue::from_static("application/octet-stream"))], bytes).into_response()
}

/// Edits of a page that shows something else are not done.
pub(super) fn same_project(project: &Project, shown: Option<u64>) -> Result<()> {
    if shown.is_none_or(|shown| shown == project.number) {
        return Ok(());
    }
    let message = "another project is open than the one that the page shows";
    Err(ApiError::new(Code::Conflict, message).hint("fetch the session and the markers again"))
}
