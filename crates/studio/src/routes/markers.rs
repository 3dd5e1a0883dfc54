//! The document of markers: edits, undo, proposals, and what to do next.

use std::sync::Arc;

use axum::{
    Json,
    extract::{Query, State},
    http::StatusCode,
    response::{IntoResponse, Response},
};
use serde::Deserialize;

use super::answer::{App, blocking, json, same_project, with_status};
use crate::{
    error::{ApiError, Result},
    events::Cause,
    markers::{Edit, view::EditView},
    next::next,
    project::Project,
    studio::Studio,
    web::body::JsonBody,
};

pub(super) async fn markers(State(studio): App) -> Result<Response> {
    Ok(json(&*studio.project()?.markers.view()))
}

/// The answer to an edit, and what follows from it.
async fn edited(
    studio: Arc<Studio>,
    cause: Cause,
    edit: impl FnOnce(&Project) -> Result<EditView> + Send + 'static,
) -> Result<Response> {
    let view = blocking(move || {
        let project = studio.project()?;
        let view = edit(&project)?;
        if view.is_changed {
            studio.markers_changed(&project, cause);
        }
        Ok::<_, ApiError>(view)
    });
    let view = view.await??;
    let status = if view.conflicts.is_empty() { StatusCode::OK } else { StatusCode::CONFLICT };
    Ok(with_status(status, view))
}

pub(super) async fn edit(State(studio): App, JsonBody(edit): JsonBody<Edit>) -> Result<Response> {
    edited(studio, Cause::Edit, move |project| {
        same_project(project, edit.project)?;
        project.markers.edit(&edit)
    })
    .await
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct BasedOn {
    #[serde(default)]
    project: Option<u64>,
    base: u64,
}

pub(super) async fn undo(State(studio): App, JsonBody(on): JsonBody<BasedOn>) -> Result<Response> {
    edited(studio, Cause::Undo, move |project| {
        same_project(project, on.project)?;
        Ok(project.markers.undo(on.base, false))
    })
    .await
}

pub(super) async fn redo(State(studio): App, JsonBody(on): JsonBody<BasedOn>) -> Result<Response> {
    edited(studio, Cause::Redo, move |project| {
        same_project(project, on.project)?;
        Ok(project.markers.undo(on.base, true))
    })
    .await
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ProposeBody {
    /// Proposals are merged with what is there, whatever the page saw.
    #[serde(default, rename = "base")]
    _base: Option<u64>,
    #[serde(default)]
    others: Option<usize>,
}

pub(super) async fn propose(State(studio): App, JsonBody(body): JsonBody<ProposeBody>) -> Result<Response> {
    let project = studio.project()?;
    Ok(json(&*studio.propose(project, body.others.unwrap_or(0))?))
}

#[derive(Deserialize)]
pub(super) struct NextQuery {
    after: Option<u64>,
}

pub(super) async fn next_point(State(studio): App, Query(query): Query<NextQuery>) -> Result<Response> {
    let project = studio.project()?;
    Ok(Json(blocking(move || next(&project, query.after)).await?).into_response())
}
