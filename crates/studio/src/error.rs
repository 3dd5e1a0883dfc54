//! Errors as the page gets them.

use axum::{
    Json,
    http::StatusCode,
    response::{IntoResponse, Response},
};
use mimesh_document::{Diagnostic, Diagnostics, Document, Kind, Location, Step, source_tree::SpanTree};
use serde::Serialize;
use serde_json::json;

/// A result of a request.
pub type Result<T> = std::result::Result<T, ApiError>;

/// What went wrong with a request.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ApiError {
    /// The kind of fault.
    pub code: Code,
    /// What is wrong: lower case, no full stop.
    pub message: String,
    /// The way out.
    pub hint: Option<String>,
    /// All that is wrong, if there is more to say than the message.
    pub diagnostics: Vec<ApiDiagnostic>,
}

/// The kind of a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Code {
    /// The request makes no sense.
    BadRequest,
    /// The cookie is missing.
    Unauthorized,
    /// The request comes from elsewhere.
    Forbidden,
    /// There is no such thing.
    NotFound,
    /// Somebody else was faster.
    Conflict,
    /// The body is too large.
    TooLarge,
    /// The body is of another type.
    Unsupported,
    /// The request is understood, and cannot be done.
    Unprocessable,
    /// Something else has to end first.
    Busy,
    /// A fault of the program.
    Internal,
}

impl Code {
    /// The status of an answer with this code.
    pub fn status(self) -> StatusCode {
        match self {
            Self::BadRequest => StatusCode::BAD_REQUEST,
            Self::Unauthorized => StatusCode::UNAUTHORIZED,
            Self::Forbidden => StatusCode::FORBIDDEN,
            Self::NotFound => StatusCode::NOT_FOUND,
            Self::Conflict | Self::Busy => StatusCode::CONFLICT,
            Self::TooLarge => StatusCode::PAYLOAD_TOO_LARGE,
            Self::Unsupported => StatusCode::UNSUPPORTED_MEDIA_TYPE,
            Self::Unprocessable => StatusCode::UNPROCESSABLE_ENTITY,
            Self::Internal => StatusCode::INTERNAL_SERVER_ERROR,
        }
    }
}

/// One thing that is wrong or looks wrong, with its place.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ApiDiagnostic {
    /// `error` or `warning`.
    pub level: &'static str,
    /// What is wrong.
    pub message: String,
    /// The way out.
    pub hint: Option<String>,
    /// The file.
    pub file: Option<String>,
    /// Its line, from 1.
    pub line: Option<usize>,
    /// The column, from 1.
    pub column: Option<u32>,
    /// Characters from the column.
    pub length: Option<u32>,
    /// The value in the pipeline.
    pub path: Option<Vec<PathStep>>,
}

/// A step to a value: a key, or the place in a sequence.
#[derive(Clone, Debug, PartialEq, Eq, serde::Deserialize, Serialize)]
#[serde(untagged)]
pub enum PathStep {
    /// A place in a sequence.
    Index(usize),
    /// A key of a mapping.
    Key(String),
}

impl From<&Step> for PathStep {
    fn from(step: &Step) -> Self {
        match step {
            Step::Key(key) => Self::Key(key.clone()),
            Step::Index(index) => Self::Index(*index),
        }
    }
}

impl From<&PathStep> for Step {
    fn from(step: &PathStep) -> Self {
        match step {
            PathStep::Key(key) => Self::Key(key.clone()),
            PathStep::Index(index) => Self::Index(*index),
        }
    }
}

impl ApiError {
    /// An error with a message and nothing else.
    pub fn new(code: Code, message: impl Into<String>) -> Self {
        Self { code, message: message.into(), hint: None, diagnostics: vec![] }
    }

    /// Adds a way out.
    pub fn hint(self, hint: impl Into<String>) -> Self {
        Self { hint: Some(hint.into()), ..self }
    }

    /// A request that makes no sense.
    pub fn bad(message: impl Into<String>) -> Self {
        Self::new(Code::BadRequest, message)
    }

    /// Something that is not there.
    pub fn not_found(message: impl Into<String>) -> Self {
        Self::new(Code::NotFound, message)
    }

    /// The error that nothing is open.
    pub fn nothing_open() -> Self {
        Self::not_found("nothing is open").hint("open a pipeline, or a source and a target")
    }

    /// The diagnostics of work that failed.
    pub fn of(diagnostics: &Diagnostics) -> Self {
        let code = if diagnostics.kind() == Kind::Internal { Code::Internal } else { Code::Unprocessable };
        let first = diagnostics.list.first();
        let message = match (first, diagnostics.len()) {
            (Some(first), 1) => first.message.clone(),
            (_, count) => format!("{count} things are wrong"),
        };
        let list: Vec<_> = diagnostics.list.iter().map(|diagnostic| ApiDiagnostic::of(diagnostic, None)).collect();
        let hint = list.first().filter(|_| list.len() == 1).and_then(|one| one.hint.clone());
        Self { code, message, hint, diagnostics: list }
    }
}

impl ApiDiagnostic {
    /// `diagnostic` with its place; the path of a value is looked up in `document`.
    pub fn of(diagnostic: &Diagnostic, document: Option<&Document>) -> Self {
        let words = diagnostic.remedy.as_ref().map(|remedy| remedy.words.clone());
        let hint = match (&diagnostic.hint, words) {
            (Some(hint), Some(words)) => Some(format!("{hint}, or {words}")),
            (hint, words) => hint.clone().or(words),
        };
        let (file, line, column, length) = match &diagnostic.location {
            Some(Location::File(file)) => (Some(file), None, None, None),
            Some(Location::Line { file, line }) => (Some(file), Some(*line), None, None),
            Some(Location::Span { file, line, column, length, .. }) => {
                (Some(file), Some(*line), Some(*column), Some(*length))
            }
            _ => (None, None, None, None),
        };
        let path = diagnostic.location.as_ref().zip(document).and_then(|(at, document)| path_of(at, document));
        Self {
            level: "error",
            message: diagnostic.message.clone(),
            hint,
            file: file.map(|file| file.display().to_string()),
            line,
            column,
            length,
            path,
        }
    }

    /// A sentence about what looks wrong.
    pub fn warning(message: impl Into<String>) -> Self {
        Self {
            level: "warning",
            message: message.into(),
            hint: None,
            file: None,
            line: None,
            column: None,
            length: None,
            path: None,
        }
    }
}

/// The path of the value whose key or text stands at `location`; the deepest one.
fn path_of(location: &Location, document: &Document) -> Option<Vec<PathStep>> {
    fn search(node: &SpanTree, location: &Location, path: &mut Vec<PathStep>) -> Option<Vec<PathStep>> {
        for entry in &node.parts {
            path.push(PathStep::from(&entry.step));
            let deeper = search(&entry.node, location, path);
            let own =
                || (entry.key.location() == *location || entry.node.span.location() == *location).then(|| path.clone());
            let found = deeper.or_else(own);
            if found.is_some() {
                return found;
            }
            path.pop();
        }
        None
    }
    search(&document.root, location, &mut vec![])
}

impl From<Diagnostics> for ApiError {
    fn from(diagnostics: Diagnostics) -> Self {
        Self::of(&diagnostics)
    }
}

impl From<Diagnostic> for ApiError {
    fn from(diagnostic: Diagnostic) -> Self {
        Self::of(&diagnostic.into())
    }
}

impl IntoResponse for ApiError {
    fn into_response(self) -> Response {
        (self.code.status(), Json(json!({ "error": self }))).into_response()
    }
}
