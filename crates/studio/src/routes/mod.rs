//! The routes: what a page may ask, and which part of the server answers.

mod answer;
mod files;
mod jobs;
mod markers;
mod masks;
mod pipeline;

use std::sync::Arc;

use axum::{
    Json, Router,
    extract::{Path, State, WebSocketUpgrade},
    http::StatusCode,
    middleware,
    response::Response,
    routing::{any, get, post, put},
};
use mimesh_pipeline::schema::file_schema;
use serde_json::{Value, json};

use self::answer::{App, binary, blocking, json};
use crate::{
    error::{ApiError, Result},
    live::socket,
    markers::Side,
    studio::Studio,
    web::{
        page,
        security::{Guard, guard},
    },
};

pub use self::files::MAX_UPLOAD;

/// All routes of `studio` behind `guardian`.
pub fn router(studio: Arc<Studio>, guardian: Arc<Guard>) -> Router {
    let api = Router::new()
        .route("/session", get(session))
        .route("/mesh/{side}", get(mesh))
        .route("/files", get(files::files))
        .route("/open", post(files::open))
        .route("/upload", post(files::upload))
        .route("/markers", get(markers::markers).post(markers::edit))
        .route("/markers/undo", post(markers::undo))
        .route("/markers/redo", post(markers::redo))
        .route("/markers/propose", post(markers::propose))
        .route("/markers/next", get(markers::next_point))
        .route("/live", any(live))
        .route("/pipeline", get(pipeline::pipeline).put(pipeline::put_pipeline))
        .route("/pipeline/set", post(pipeline::set_value))
        .route("/pipeline/unset", post(pipeline::unset_value))
        .route("/pipeline/undo", post(pipeline::undo))
        .route("/pipeline/redo", post(pipeline::redo))
        .route("/yaml", post(pipeline::yaml))
        .route("/schema", get(async || Json(file_schema())))
        .route("/run", post(jobs::run))
        .route("/jobs", get(jobs::jobs))
        .route("/jobs/{id}", get(jobs::job).delete(jobs::cancel))
        .route("/written", get(jobs::written))
        .route("/masks", get(masks::masks))
        .route("/masks/{side}/{name}", put(masks::put_mask).get(masks::mask).delete(masks::delete_mask))
        .route("/masks/{side}/{name}/components", put(masks::put_components))
        .route("/about", get(about))
        .fallback(async || ApiError::not_found("there is no such route"));
    Router::new()
        .nest("/api", api)
        .fallback(get(page::file))
        .method_not_allowed_fallback(async || {
            (StatusCode::METHOD_NOT_ALLOWED, Json(json!({ "error": ApiError::bad("the route takes other methods") })))
        })
        .with_state(studio)
        .layer(middleware::from_fn_with_state(guardian, guard))
}

async fn session(State(studio): App) -> Response {
    json(&*studio.session())
}

async fn mesh(State(studio): App, Path(side): Path<Side>) -> Result<Response> {
    let project = studio.project()?;
    Ok(binary(blocking(move || project.meshes.container(side.index(), project.number)).await?))
}

async fn live(State(studio): App, upgrade: WebSocketUpgrade) -> Response {
    let upgrade = upgrade.max_message_size(socket::MAX_MESSAGE).max_frame_size(socket::MAX_MESSAGE);
    upgrade.on_upgrade(move |socket| socket::serve(socket, studio))
}

async fn about() -> Json<Value> {
    let licences = mimesh_web::text("licences.json").and_then(|text| serde_json::from_str::<Value>(&text).ok());
    Json(json!({ "version": env!("CARGO_PKG_VERSION"), "licences": licences.unwrap_or_else(|| json!([])) }))
}
