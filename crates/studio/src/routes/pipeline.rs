//! The pipeline: its text, its values, undo, and what a text means.

use std::sync::Arc;

use axum::{extract::State, http::StatusCode, response::Response};
use mimesh_document::{Step, yaml::yaml_value};
use serde::Deserialize;
use serde_json::{Value, json};

use super::answer::{App, blocking, json, with_status};
use crate::{
    error::{PathStep, Result},
    events::Cause,
    project::Project,
    studio::Studio,
    web::body::JsonBody,
};

pub(super) async fn pipeline(State(studio): App) -> Result<Response> {
    let project = studio.project()?;
    Ok(json(&*blocking(move || project.pipeline.view()).await?))
}

/// The answer to a change of the pipeline: the pipeline after it, or that it has changed in the meantime.
async fn changed(
    studio: Arc<Studio>,
    cause: Cause,
    change: impl FnOnce(&Project) -> Result<Option<()>> + Send + 'static,
) -> Result<Response> {
    blocking(move || {
        let project = studio.project()?;
        Ok(match change(&project)? {
            Some(()) => {
                studio.pipeline_changed(&project, cause);
                json(&*project.pipeline.view())
            }
            None => with_status(StatusCode::CONFLICT, json!({ "conflict": &*project.pipeline.view() })),
        })
    })
    .await?
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PutPipeline {
    base: u64,
    text: String,
}

pub(super) async fn put_pipeline(State(studio): App, JsonBody(body): JsonBody<PutPipeline>) -> Result<Response> {
    changed(studio, Cause::Edit, move |project| Ok(project.pipeline.put(body.base, body.text))).await
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SetValue {
    base: u64,
    path: Vec<PathStep>,
    value: Value,
}

pub(super) async fn set_value(State(studio): App, JsonBody(body): JsonBody<SetValue>) -> Result<Response> {
    let path: Vec<Step> = body.path.iter().map(Step::from).collect();
    changed(studio, Cause::Edit, move |project| project.pipeline.set(body.base, &path, Some(&body.value))).await
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct UnsetValue {
    base: u64,
    path: Vec<PathStep>,
}

pub(super) async fn unset_value(State(studio): App, JsonBody(body): JsonBody<UnsetValue>) -> Result<Response> {
    let path: Vec<Step> = body.path.iter().map(Step::from).collect();
    changed(studio, Cause::Edit, move |project| project.pipeline.set(body.base, &path, None)).await
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct BasedOn {
    base: u64,
}

pub(super) async fn undo(State(studio): App, JsonBody(on): JsonBody<BasedOn>) -> Result<Response> {
    changed(studio, Cause::Undo, move |project| project.pipeline.undo(on.base, false)).await
}

pub(super) async fn redo(State(studio): App, JsonBody(on): JsonBody<BasedOn>) -> Result<Response> {
    changed(studio, Cause::Redo, move |project| project.pipeline.undo(on.base, true)).await
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Text {
    text: String,
}

/// The value of a text in YAML, as the pipeline would read it, or what is wrong with the text: that is an answer, too.
pub(super) async fn yaml(JsonBody(Text { text }): JsonBody<Text>) -> Result<Response> {
    let read = yaml_value(&text).map_err(|error| error.without_snippet().to_string());
    let problem = read.as_ref().err().map(|problem| format!("this is no YAML: {problem}"));
    Ok(json(&json!({ "value": read.unwrap_or_default(), "problem": problem })))
}
