//! Bodies of requests: JSON of a bounded size, within a bounded time.

use std::time::Duration;

use axum::{
    body::{Bytes, to_bytes},
    extract::{FromRequest, Request},
    http::header,
};
use serde::de::DeserializeOwned;

use crate::error::{ApiError, Code};

/// The most bytes of a JSON body.
pub const MAX_JSON: usize = 4 << 20;

/// How long a small body may take.
const TIMEOUT: Duration = Duration::from_secs(30);

/// A JSON body.
#[derive(Debug)]
pub struct JsonBody<T>(pub T);

impl<T: DeserializeOwned, S: Send + Sync> FromRequest<S> for JsonBody<T> {
    type Rejection = ApiError;

    async fn from_request(request: Request, _: &S) -> Result<Self, ApiError> {
        let kind = request.headers().get(header::CONTENT_TYPE).and_then(|kind| kind.to_str().ok()).unwrap_or_default();
        if kind.split(';').next().map(str::trim) != Some("application/json") {
            let message = format!("expected a body of the type application/json, found `{kind}`");
            return Err(ApiError::new(Code::Unsupported, message));
        }
        let bytes = bounded(request, MAX_JSON).await?;
        serde_json::from_slice(&bytes).map(Self).map_err(|error| ApiError::bad(format!("the body: {error}")))
    }
}

/// The whole body of `request`, of at most `limit` bytes.
///
/// # Errors
///
/// If it is larger, breaks off, or takes too long.
pub async fn bounded(request: Request, limit: usize) -> Result<Bytes, ApiError> {
    let announced = request.headers().get(header::CONTENT_LENGTH).and_then(|length| length.to_str().ok()?.parse().ok());
    if announced.is_some_and(|length: u64| length > limit as u64) {
        return Err(too_large(limit as u64));
    }
    match tokio::time::timeout(TIMEOUT, to_bytes(request.into_body(), limit)).await {
        Ok(Ok(bytes)) => Ok(bytes),
        Ok(Err(error)) if is_length_limit(&error) => Err(too_large(limit as u64)),
        Ok(Err(error)) => Err(ApiError::bad(format!("the body broke off: {error}"))),
        Err(_) => Err(ApiError::bad("the body took too long")),
    }
}

/// The error of a body of more than `limit` bytes.
pub fn too_large(limit: u64) -> ApiError {
    ApiError::new(Code::TooLarge, format!("the body is larger than {limit} bytes"))
}

fn is_length_limit(error: &axum::Error) -> bool {
    let mut source: Option<&(dyn std::error::Error + 'static)> = Some(error);
    while let Some(error) = source {
        if error.to_string().contains("length limit exceeded") {
            return true;
        }
        source = error.source();
    }
    false
}
