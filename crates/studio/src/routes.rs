//! The routes: what a page may ask, and which part of the server answers.

use std::{path::PathBuf, sync::Arc};

use axum::{
    Json, Router,
    extract::{Path, Query, Request, State, WebSocketUpgrade},
    http::{HeaderValue, StatusCode, header},
    middleware,
    response::{IntoResponse, Response},
    routing::{any, get, post, put},
};
use mimesh_document::Step;
use mimesh_pipeline::schema::file_schema;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use tokio::io::AsyncWriteExt;

use crate::{
    error::{ApiError, PathStep, Result},
    events::Cause,
    live::socket,
    markers::{Edit, Side, store::EditView},
    next::next,
    project::{Opening, Project},
    studio::Studio,
    web::{
        body::{JsonBody, bounded, too_large},
        page,
        security::{Guard, content_of_results, guard},
    },
};

/// The most bytes of an upload.
pub const MAX_UPLOAD: u64 = 2 << 30;

/// The most bytes of a mask: four for each of many vertices.
const MAX_MASK: usize = 256 << 20;

/// How long an upload may rest.
const UPLOAD_TIMEOUT: std::time::Duration = std::time::Duration::from_secs(60);

type App = State<Arc<Studio>>;

/// All routes of `studio` behind `guardian`.
pub fn router(studio: Arc<Studio>, guardian: Arc<Guard>) -> Router {
    let api = Router::new()
        .route("/session", get(session))
        .route("/mesh/{side}", get(mesh))
        .route("/files", get(files))
        .route("/open", post(open))
        .route("/upload", post(upload))
        .route("/markers", get(markers).post(edit))
        .route("/markers/undo", post(undo))
        .route("/markers/redo", post(redo))
        .route("/markers/propose", post(propose))
        .route("/markers/next", get(next_point))
        .route("/live", any(live))
        .route("/pipeline", get(pipeline).put(put_pipeline))
        .route("/pipeline/set", post(set_value))
        .route("/pipeline/unset", post(unset_value))
        .route("/schema", get(async || Json(file_schema())))
        .route("/run", post(run))
        .route("/jobs", get(jobs))
        .route("/jobs/{id}", get(job).delete(cancel))
        .route("/written", get(written))
        .route("/masks", get(masks))
        .route("/masks/{side}/{name}", put(put_mask).get(mask).delete(delete_mask))
        .route("/masks/{side}/{name}/components", put(put_components))
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

/// Does work that takes long where it does not keep others waiting.
async fn blocking<T: Send + 'static>(work: impl FnOnce() -> T + Send + 'static) -> Result<T> {
    tokio::task::spawn_blocking(work)
        .await
        .map_err(|error| ApiError::new(crate::error::Code::Internal, format!("the program made a mistake: {error}")))
}

/// An answer with a status of its own.
fn with_status(status: StatusCode, body: impl Serialize) -> Response {
    (status, Json(body)).into_response()
}

fn json(body: &impl Serialize) -> Response {
    with_status(StatusCode::OK, body)
}

async fn session(State(studio): App) -> Response {
    json(&*studio.session())
}

async fn jobs(State(studio): App) -> Response {
    json(&studio.jobs.views().iter().map(|view| (**view).clone()).collect::<Vec<_>>())
}

fn binary(bytes: Vec<u8>) -> Response {
    ([(header::CONTENT_TYPE, HeaderValue::from_static("application/octet-stream"))], bytes).into_response()
}

async fn mesh(State(studio): App, Path(side): Path<Side>) -> Result<Response> {
    let project = studio.project()?;
    Ok(binary(blocking(move || project.meshes.container(side.index(), project.number)).await?))
}

#[derive(Deserialize)]
struct FolderQuery {
    path: Option<PathBuf>,
}

async fn files(State(studio): App, Query(query): Query<FolderQuery>) -> Result<Response> {
    let list = blocking(move || studio.folders.list(query.path.as_deref(), &studio.formats())).await??;
    Ok(Json(list).into_response())
}

async fn open(State(studio): App, JsonBody(opening): JsonBody<Opening>) -> Result<Response> {
    Ok(json(&*blocking(move || studio.open(&opening)).await??))
}

#[derive(Deserialize)]
struct UploadQuery {
    name: String,
}

async fn upload(State(studio): App, Query(query): Query<UploadQuery>, request: Request) -> Result<Response> {
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

async fn markers(State(studio): App) -> Result<Response> {
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

async fn edit(State(studio): App, JsonBody(edit): JsonBody<Edit>) -> Result<Response> {
    edited(studio, Cause::Edit, move |project| {
        same_project(project, edit.project)?;
        project.markers.edit(&edit)
    })
    .await
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct BasedOn {
    #[serde(default)]
    project: Option<u64>,
    base: u64,
}

async fn undo(State(studio): App, JsonBody(on): JsonBody<BasedOn>) -> Result<Response> {
    edited(studio, Cause::Undo, move |project| {
        same_project(project, on.project)?;
        Ok(project.markers.undo(on.base, false))
    })
    .await
}

async fn redo(State(studio): App, JsonBody(on): JsonBody<BasedOn>) -> Result<Response> {
    edited(studio, Cause::Redo, move |project| {
        same_project(project, on.project)?;
        Ok(project.markers.undo(on.base, true))
    })
    .await
}

/// Edits of a page that shows something else are not done.
fn same_project(project: &Project, shown: Option<u64>) -> Result<()> {
    if shown.is_none_or(|shown| shown == project.number) {
        return Ok(());
    }
    let message = "another project is open than the one that the page shows";
    Err(ApiError::new(crate::error::Code::Conflict, message).hint("fetch the session and the markers again"))
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ProposeBody {
    /// Proposals are merged with what is there, whatever the page saw.
    #[serde(default, rename = "base")]
    _base: Option<u64>,
    #[serde(default)]
    others: Option<usize>,
}

async fn propose(State(studio): App, JsonBody(body): JsonBody<ProposeBody>) -> Result<Response> {
    let project = studio.project()?;
    Ok(json(&*studio.propose(project, body.others.unwrap_or(0))?))
}

#[derive(Deserialize)]
struct NextQuery {
    after: Option<u64>,
}

async fn next_point(State(studio): App, Query(query): Query<NextQuery>) -> Result<Response> {
    let project = studio.project()?;
    Ok(Json(blocking(move || next(&project, query.after)).await?).into_response())
}

async fn live(State(studio): App, upgrade: WebSocketUpgrade) -> Response {
    let upgrade = upgrade.max_message_size(socket::MAX_MESSAGE).max_frame_size(socket::MAX_MESSAGE);
    upgrade.on_upgrade(move |socket| socket::serve(socket, studio))
}

async fn pipeline(State(studio): App) -> Result<Response> {
    let project = studio.project()?;
    Ok(json(&*blocking(move || project.pipeline.view()).await?))
}

/// The answer to a change of the pipeline: the pipeline after it, or that it has changed in the meantime.
async fn changed(
    studio: Arc<Studio>,
    change: impl FnOnce(&Project) -> Result<Option<()>> + Send + 'static,
) -> Result<Response> {
    blocking(move || {
        let project = studio.project()?;
        Ok(match change(&project)? {
            Some(()) => {
                studio.pipeline_changed(&project, Cause::Edit);
                json(&*project.pipeline.view())
            }
            None => with_status(StatusCode::CONFLICT, json!({ "conflict": &*project.pipeline.view() })),
        })
    })
    .await?
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PutPipeline {
    base: u64,
    text: String,
}

async fn put_pipeline(State(studio): App, JsonBody(body): JsonBody<PutPipeline>) -> Result<Response> {
    changed(studio, move |project| Ok(project.pipeline.put(body.base, body.text))).await
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SetValue {
    base: u64,
    path: Vec<PathStep>,
    value: Value,
}

async fn set_value(State(studio): App, JsonBody(body): JsonBody<SetValue>) -> Result<Response> {
    let path: Vec<Step> = body.path.iter().map(Step::from).collect();
    changed(studio, move |project| project.pipeline.set(Some(body.base), &path, Some(&body.value))).await
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct UnsetValue {
    base: u64,
    path: Vec<PathStep>,
}

async fn unset_value(State(studio): App, JsonBody(body): JsonBody<UnsetValue>) -> Result<Response> {
    let path: Vec<Step> = body.path.iter().map(Step::from).collect();
    changed(studio, move |project| project.pipeline.set(Some(body.base), &path, None)).await
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Nothing {}

async fn run(State(studio): App, JsonBody(Nothing {}): JsonBody<Nothing>) -> Result<Response> {
    Ok(json(&*studio.run()?))
}

async fn job(State(studio): App, Path(id): Path<u64>) -> Result<Response> {
    Ok(json(&*studio.jobs.find(id)?.view()))
}

async fn cancel(State(studio): App, Path(id): Path<u64>) -> Result<Response> {
    let job = studio.jobs.find(id)?;
    job.cancel.cancel();
    Ok(json(&*job.view()))
}

#[derive(Deserialize)]
struct WrittenQuery {
    path: PathBuf,
}

/// A file that a run has written: pages and pictures are shown, and hardly may do anything; all else is downloaded.
async fn written(State(studio): App, Query(query): Query<WrittenQuery>) -> Result<Response> {
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

async fn masks(State(studio): App) -> Result<Response> {
    let project = studio.project()?;
    let masks = blocking(move || project.masks()).await?;
    Ok(Json(json!({ "masks": masks })).into_response())
}

async fn put_mask(State(studio): App, Path((side, name)): Path<(Side, String)>, request: Request) -> Result<Response> {
    let bytes = bounded(request, MAX_MASK).await?;
    let project = studio.project()?;
    let mask = blocking(move || {
        let weights = crate::container::read_f32(&bytes, "weights").map_err(ApiError::bad)?;
        project.put_weights(side, &name, &weights)
    });
    Ok(Json(mask.await??).into_response())
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Components {
    components: Vec<String>,
}

async fn put_components(
    State(studio): App,
    Path((side, name)): Path<(Side, String)>,
    JsonBody(body): JsonBody<Components>,
) -> Result<Response> {
    let project = studio.project()?;
    let mask = blocking(move || project.put_components(side, &name, &body.components));
    Ok(Json(mask.await??).into_response())
}

async fn mask(State(studio): App, Path((side, name)): Path<(Side, String)>) -> Result<Response> {
    let project = studio.project()?;
    Ok(binary(blocking(move || project.mask(side, &name)).await??))
}

async fn delete_mask(State(studio): App, Path((side, name)): Path<(Side, String)>) -> Result<Response> {
    let project = studio.project()?;
    let masks = blocking(move || project.delete_mask(side, &name).map(|()| project.masks()));
    Ok(Json(json!({ "masks": masks.await?? })).into_response())
}

async fn about() -> Json<Value> {
    let licences = mimesh_web::text("licences.json").and_then(|text| serde_json::from_str::<Value>(&text).ok());
    Json(json!({ "version": env!("CARGO_PKG_VERSION"), "licences": licences.unwrap_or_else(|| json!([])) }))
}
