//! Files: what lies in folders, what is opened, and uploads.

use std::{path::PathBuf, time::Duration};

use axum::{
    Json,
    extract::{Query, Request, State},
    http::header,
    response::{IntoResponse, Response},
};
use serde::Deserialize;
use serde_json::json;
use tokio::io::AsyncWriteExt;

use super::answer::{App, blocking, json};
use crate::{
    error::{ApiError, Result},
    project::Opening,
    web::body::{JsonBody, too_large},
};

/// The most bytes of an upload.
pub const MAX_UPLOAD: u64 = 2 << 30;

/// How long an upload may rest.
const UPLOAD_TIMEOUT: Duration = Duration::from_secs(60);

#[derive(Deserialize)]
pub(super) struct FolderQuery {
    path: Option<PathBuf>,
}

pub(super) async fn files(State(studio): App, Query(query): Query<FolderQuery>) -> Result<Response> {
    let list = blocking(move || studio.folders.list(query.path.as_deref(), &studio.formats())).await??;
    Ok(Json(list).into_response())
}

pub(super) async fn open(State(studio): App, JsonBody(opening): JsonBody<Opening>) -> Result<Response> {
    Ok(json(&*blocking(move || studio.open(&opening)).await??))
}

#[derive(Deserialize)]
pub(super) struct UploadQuery {
    name: String,
}

pub(super) async fn upload(State(studio): App, Query(query): Query<UploadQuery>, request: Request) -> Result<Response> {
    let name = &query.name;
    let is_name = !name.is_empty() && name.len() <= 200 && !name.starts_with('.');
    if !is_name || name.chars().any(|c| c.is_control() || "/\\:".contains(c)) {
        let message = format!("`{name}` is no name of a file");
        return Err(ApiError::bad(message).hint("give a name without folders, which begins with no dot"));
    }
    let announced = request.headers().get(header::CONTENT_LENGTH).and_then(|length| length.to_str().ok()?.parse().ok());
    if announced.is_some_and(|length: u64| length > MAX_UPLOAD) {
        return Err(too_large(MAX_UPLOAD));
    }
    let place = studio.uploads.join(name);
    let failed =
        |error: std::io::Error| ApiError::new(crate::error::Code::Internal, format!("cannot keep the upload: {error}"));
    let temporary = tempfile::Builder::new().prefix(".upload-").tempfile_in(&studio.uploads).map_err(failed)?;
    let (file, temporary) = temporary.into_parts();
    let mut out = tokio::fs::File::from_std(file);
    let mut stream = request.into_body().into_data_stream();
    let mut bytes = 0u64;
    loop {
        let next = tokio::time::timeout(UPLOAD_TIMEOUT, futures_util::StreamExt::next(&mut stream)).await;
        let Some(part) = next.map_err(|_| ApiError::bad("the upload rested too long"))? else { break };
        let part = part.map_err(|error| ApiError::bad(format!("the upload broke off: {error}")))?;
        bytes += part.len() as u64;
        if bytes > MAX_UPLOAD {
            return Err(too_large(MAX_UPLOAD));
        }
        out.write_all(&part).await.map_err(failed)?;
    }
    out.flush().await.map_err(failed)?;
    temporary.persist(&place).map_err(|error| failed(error.error))?;
    Ok(Json(json!({ "path": place, "bytes": bytes })).into_response())
}
