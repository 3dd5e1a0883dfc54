//! Painted masks.

use axum::{
    Json,
    extract::{Path, Query, Request, State},
    response::{IntoResponse, Response},
};
use serde::Deserialize;
use serde_json::json;

use super::answer::{App, binary, blocking};
use crate::{
    error::{ApiError, Result},
    markers::Side,
    web::body::{JsonBody, bounded},
};

/// The most bytes of a mask: four for each of many vertices.
const MAX_MASK: usize = 256 << 20;

pub(super) async fn masks(State(studio): App) -> Result<Response> {
    let project = studio.project()?;
    let masks = blocking(move || project.masks()).await?;
    Ok(Json(json!({ "masks": masks })).into_response())
}

/// Whether a file that is there may be replaced.
#[derive(Deserialize)]
pub(super) struct SaveQuery {
    #[serde(default)]
    replace: bool,
}

pub(super) async fn put_mask(
    State(studio): App,
    Path((side, name)): Path<(Side, String)>,
    Query(SaveQuery { replace }): Query<SaveQuery>,
    request: Request,
) -> Result<Response> {
    let bytes = bounded(request, MAX_MASK).await?;
    let project = studio.project()?;
    let mask = blocking(move || {
        let weights = crate::container::read_f32(&bytes, "weights").map_err(ApiError::bad)?;
        project.put_weights(side, &name, &weights, replace)
    });
    Ok(Json(mask.await??).into_response())
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Components {
    components: Vec<String>,
}

pub(super) async fn put_components(
    State(studio): App,
    Path((side, name)): Path<(Side, String)>,
    Query(SaveQuery { replace }): Query<SaveQuery>,
    JsonBody(body): JsonBody<Components>,
) -> Result<Response> {
    let project = studio.project()?;
    let mask = blocking(move || project.put_components(side, &name, &body.components, replace));
    Ok(Json(mask.await??).into_response())
}

pub(super) async fn mask(State(studio): App, Path((side, name)): Path<(Side, String)>) -> Result<Response> {
    let project = studio.project()?;
    Ok(binary(blocking(move || project.mask(side, &name)).await??))
}

pub(super) async fn delete_mask(State(studio): App, Path((side, name)): Path<(Side, String)>) -> Result<Response> {
    let project = studio.project()?;
    let masks = blocking(move || project.delete_mask(side, &name).map(|()| project.masks()));
    Ok(Json(json!({ "masks": masks.await?? })).into_response())
}
