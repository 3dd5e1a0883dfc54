//! Runs and other long work, and the files that runs have written.

use std::path::PathBuf;

use axum::{
    extract::{Path, Query, State},
    http::header,
    response::{IntoResponse, Response},
};
use serde::Deserialize;

use super::answer::{App, json};
use crate::{
    error::{ApiError, Result},
    web::{body::JsonBody, security::content_of_results},
};

pub(super) async fn jobs(State(studio): App) -> Response {
    json(&studio.jobs.views().iter().map(|view| (**view).clone()).collect::<Vec<_>>())
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Nothing {}

pub(super) async fn run(State(studio): App, JsonBody(Nothing {}): JsonBody<Nothing>) -> Result<Response> {
    Ok(json(&*studio.run()?))
}

pub(super) async fn job(State(studio): App, Path(id): Path<u64>) -> Result<Response> {
    Ok(json(&*studio.jobs.find(id)?.view()))
}

pub(super) async fn cancel(State(studio): App, Path(id): Path<u64>) -> Result<Response> {
    let job = studio.jobs.find(id)?;
    job.cancel.cancel();
    Ok(json(&*job.view()))
}

#[derive(Deserialize)]
pub(super) struct WrittenQuery {
    path: PathBuf,
}

/// A file that a run has written: pages and pictures are shown, and hardly may do anything; all else is downloaded.
pub(super) async fn written(State(studio): App, Query(query): Query<WrittenQuery>) -> Result<Response> {
    let missing = || ApiError::not_found(format!("no run has written `{}`", query.path.display()));
    if !studio.is_written(&query.path) {
        return Err(missing());
    }
    let bytes = tokio::fs::read(&query.path).await.map_err(|_| missing())?;
    let kind = match query.path.extension().and_then(|extension| extension.to_str()) {
        Some("html") => "text/html; charset=utf-8",
        Some("png") => "image/png",
        Some("json") => "application/json",
        _ => "application/octet-stream",
    };
    let is_shown = kind != "application/octet-stream";
    let name = query.path.file_name().unwrap_or_default().to_string_lossy();
    let name: String =
        name.chars().map(|c| if c.is_ascii_graphic() && !"\"\\".contains(c) { c } else { '_' }).collect();
    let how = format!("{}; filename=\"{name}\"", if is_shown { "inline" } else { "attachment" });
    let headers = [
        (header::CONTENT_TYPE, kind.to_owned()),
        (header::CONTENT_DISPOSITION, how),
        (header::CONTENT_SECURITY_POLICY, content_of_results().to_owned()),
    ];
    Ok((headers, bytes).into_response())
}
