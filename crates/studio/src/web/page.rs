//! The page's files, which are part of the program if the page was built before it.

use axum::{
    http::{StatusCode, Uri, header},
    response::{IntoResponse, Response},
};
use mimesh_web::BUILD;

use crate::error::ApiError;

/// Answers with a file of the page.
pub async fn file(uri: Uri) -> Response {
    let path = uri.path().trim_start_matches('/');
    let name = if path.is_empty() { "index.html" } else { path };
    match mimesh_web::file(name) {
        Some(file) => {
            // Names of assets hold a hash of their contents.
            let cache = if name.starts_with("assets/") { "public, max-age=31536000, immutable" } else { "no-cache" };
            let kind = file.metadata.mimetype().to_owned();
            ([(header::CONTENT_TYPE, kind), (header::CACHE_CONTROL, cache.into())], file.data).into_response()
        }
        None if path.is_empty() => {
            let text = format!("The page is not part of this program. Build it, then the program again:\n\n{BUILD}\n");
            (StatusCode::NOT_FOUND, text).into_response()
        }
        None => ApiError::not_found(format!("there is no `{}`", uri.path())).into_response(),
    }
}
