//! What is wrong, where, and what to do about it.

use std::{
    fmt,
    path::{Path, PathBuf},
};

use serde::Serialize;
use serde_json::{Value, json};

use crate::{core, pipeline::resolve::similar_file};

/// What kind of thing is wrong; a program that runs pipelines turns kinds into exit statuses or responses of its own.
///
/// Of several diagnostics together the largest counts: a wrong pipeline first, since the others may follow from it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// A fault of the program itself.
    Internal,
    /// The caller asked for something that cannot be done.
    Usage,
    /// A mesh, markers or a correspondence cannot be worked with.
    BadData,
    /// A file that is read does not exist.
    MissingInput,
    /// A result cannot be written.
    CannotWrite,
    /// The pipeline file is wrong.
    BadPipeline,
}

impl Kind {
    /// The kind of an error of a stage or a file.
    pub fn of(error: &core::Error) -> Self {
        match error {
            core::Error::Io { action: "write", .. } => Self::CannotWrite,
            core::Error::Io { source, .. }
                if matches!(source.kind(), std::io::ErrorKind::NotFound | std::io::ErrorKind::IsADirectory) =>
            {
                Self::MissingInput
            }
            core::Error::Setting { .. } => Self::BadPipeline,
            core::Error::Other(_) => Self::Internal,
            _ => Self::BadData,
        }
    }

    /// The kind of several diagnostics together.
    pub fn of_all(kinds: impl IntoIterator<Item = Self>) -> Self {
        kinds.into_iter().max().unwrap_or(Self::Internal)
    }
}

/// One thing that is wrong, as the user is told of it.
///
/// It displays as `place: message`, then the line of the file with the spot marked, then a hint.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnostic {
    /// What kind of thing is wrong.
    pub kind: Kind,
    /// Where, if it has a place that the message does not name itself.
    pub location: Option<Location>,
    /// Lower case, no full stop; what was expected and what was found.
    pub message: String,
    /// The way out.
    pub hint: Option<String>,
}

/// A place in what the user wrote.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Location {
    /// A file as a whole.
    File(PathBuf),
    /// A line of a file.
    Line {
        /// The file.
        file: PathBuf,
        /// Its line, from 1.
        line: usize,
    },
    /// A stretch of a line.
    Span {
        /// The file.
        file: PathBuf,
        /// Its line, from 1.
        line: usize,
        /// The first column in characters, from 1.
        column: usize,
        /// How many characters, at least 1.
        length: usize,
        /// The text of the line.
        text: Box<str>,
    },
    /// An option on the command line, as it was given.
    Option(String),
}

/// Several diagnostics, or one: why a command could not do its work.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnostics {
    /// At least one.
    pub diagnostics: Vec<Diagnostic>,
}

/// A result with [`Diagnostics`].
pub type Result<T> = std::result::Result<T, Diagnostics>;

impl Diagnostic {
    /// A diagnostic without a place.
    pub fn new(kind: Kind, message: impl Into<String>) -> Self {
        Self { kind, location: None, message: message.into(), hint: None }
    }

    /// Adds where it is.
    pub fn at(self, location: Location) -> Self {
        Self { location: Some(location), ..self }
    }

    /// Adds a way out.
    pub fn hint(self, hint: impl Into<String>) -> Self {
        Self { hint: Some(hint.into()).filter(|hint| !hint.is_empty()), ..self }
    }

    /// Says first what was being done, e.g. `transfer (gradient)`.
    pub fn doing(self, what: impl fmt::Display) -> Self {
        Self { message: format!("{what}: {}", self.message), ..self }
    }

    /// As JSON: `file`, `line` and `column` (each where known), `message` and `hint`.
    pub fn to_json(&self) -> Value {
        let (file, line, column) = match &self.location {
            Some(Location::File(file)) => (Some(file), None, None),
            Some(Location::Line { file, line }) => (Some(file), Some(line), None),
            Some(Location::Span { file, line, column, .. }) => (Some(file), Some(line), Some(column)),
            Some(Location::Option(_)) | None => (None, None, None),
        };
        let option = if let Some(Location::Option(option)) = &self.location { Some(option) } else { None };
        let mut result = json!({
            "file": file, "line": line, "column": column, "option": option, "message": self.message, "hint": self.hint,
        });
        if let Some(object) = result.as_object_mut() {
            object.retain(|_, value| !value.is_null());
        }
        result
    }
}

impl From<core::Error> for Diagnostic {
    /// The message keeps file and line where the error has them; a line becomes a place, so that editors can jump.
    fn from(error: core::Error) -> Self {
        let diagnostic = Self::new(Kind::of(&error), error.to_string()).hint(error.hint().unwrap_or_default());
        match error {
            core::Error::File { path, line: Some(line), message, .. } => {
                Self { message, ..diagnostic }.at(Location::Line { file: path, line })
            }
            core::Error::File { path, line: None, message, .. } => {
                Self { message, ..diagnostic }.at(Location::File(path))
            }
            core::Error::Io { path, action, source } => {
                let hint = io_hint(&path, action, &source);
                Self { message: io_message(action, &source), ..diagnostic }.hint(hint).at(Location::File(path))
            }
            _ => diagnostic,
        }
    }
}

/// What happened to a file, in words that do not depend on the system.
pub fn io_message(action: &str, error: &std::io::Error) -> String {
    use std::io::ErrorKind;
    match error.kind() {
        ErrorKind::NotFound if action == "write" => "cannot write: no such folder".into(),
        ErrorKind::NotFound => "no such file".into(),
        ErrorKind::IsADirectory => "is a folder, expected a file".into(),
        ErrorKind::PermissionDenied => format!("no permission to {action} it"),
        ErrorKind::StorageFull => format!("cannot {action}: the disk is full"),
        ErrorKind::InvalidData => format!("cannot {action}: not UTF-8 text"),
        _ => format!("cannot {action}: {error}"),
    }
}

/// The way out, where there is one to tell.
fn io_hint(path: &Path, action: &str, error: &std::io::Error) -> String {
    use std::io::ErrorKind;
    match (action, error.kind()) {
        ("write", ErrorKind::StorageFull) => "free some space, or write elsewhere with `--out DIR`".into(),
        ("write", _) => "write elsewhere with `--out DIR`".into(),
        (_, ErrorKind::NotFound) => similar_file(path).unwrap_or_default(),
        (_, ErrorKind::InvalidData) => "is it the file that is meant? if so, save it as UTF-8".into(),
        (_, ErrorKind::PermissionDenied) => "allow reading it, or give another file".into(),
        _ => String::new(),
    }
}

/// Reads a text file.
///
/// # Errors
///
/// A [`Diagnostic`] at the file.
pub fn read_text(path: &Path) -> std::result::Result<String, Diagnostic> {
    std::fs::read_to_string(path).map_err(|error| core::Error::read(path, error).into())
}

impl Diagnostics {
    /// The kind of all diagnostics together.
    pub fn kind(&self) -> Kind {
        Kind::of_all(self.diagnostics.iter().map(|diagnostic| diagnostic.kind))
    }
}

impl From<Diagnostic> for Diagnostics {
    fn from(diagnostic: Diagnostic) -> Self {
        Self { diagnostics: vec![diagnostic] }
    }
}

impl From<core::Error> for Diagnostics {
    fn from(error: core::Error) -> Self {
        Diagnostic::from(error).into()
    }
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File(file) => write!(f, "{}", file.display()),
            Self::Line { file, line } => write!(f, "{}:{line}", file.display()),
            Self::Span { file, line, column, .. } => write!(f, "{}:{line}:{column}", file.display()),
            Self::Option(option) => f.write_str(option),
        }
    }
}

impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(location) = &self.location {
            write!(f, "{location}: ")?;
        }
        f.write_str(&self.message)?;
        let margin = match &self.location {
            Some(Location::Span { line, column, length, text, .. }) => {
                let number = line.to_string();
                let margin = " ".repeat(number.len());
                let shown = text.replace('\t', " ");
                let marks = "^".repeat((*length).clamp(1, shown.chars().count().saturating_sub(column - 1).max(1)));
                write!(f, "\n {margin} |\n {number} | {shown}\n {margin} | {}{marks}", " ".repeat(column - 1))?;
                format!(" {margin} = ")
            }
            _ => "  ".into(),
        };
        match &self.hint {
            Some(hint) => write!(f, "\n{margin}hint: {hint}"),
            None => Ok(()),
        }
    }
}

impl fmt::Display for Diagnostics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, diagnostic) in self.diagnostics.iter().enumerate() {
            let line = if i == 0 { "" } else { "\n" };
            write!(f, "{line}error: {diagnostic}")?;
        }
        Ok(())
    }
}

impl std::error::Error for Diagnostic {}
impl std::error::Error for Diagnostics {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_in_a_line_is_shown_below_it() {
        let location =
            Location::Span { file: "a.yaml".into(), line: 12, column: 4, length: 2, text: "a: bc\t# é".into() };
        let diagnostic = Diagnostic::new(Kind::BadPipeline, "no bc").at(location).hint("say so");
        assert_eq!(
            diagnostic.to_string(),
            "a.yaml:12:4: no bc\n    |\n 12 | a: bc # é\n    |    ^^\n    = hint: say so"
        );
    }

    #[test]
    fn marks_end_with_the_line() {
        let location = Location::Span { file: "a".into(), line: 1, column: 3, length: 99, text: "a: {".into() };
        let diagnostic = Diagnostic::new(Kind::BadPipeline, "open").at(location);
        assert_eq!(diagnostic.to_string(), "a:1:3: open\n   |\n 1 | a: {\n   |   ^^");
    }
}
