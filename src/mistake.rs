//! What is wrong, where, and what to do about it.

use std::{
    fmt,
    path::{Path, PathBuf},
};

use serde::Serialize;
use serde_json::{Value, json};

use crate::{core, pipeline::resolve::similar_file, status::Status};

/// One thing that is wrong, as the user is told of it.
///
/// It displays as `place: message`, then the line of the file with the spot marked, then a hint.
#[derive(Clone, Debug, PartialEq)]
pub struct Mistake {
    /// The exit status it leads to.
    pub status: Status,
    /// Where, if it has a place that the message does not name itself.
    pub place: Option<Place>,
    /// Lower case, no full stop; what was expected and what was found.
    pub message: String,
    /// The way out.
    pub hint: Option<String>,
}

/// A place in what the user wrote.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Place {
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

/// Several mistakes, or one: why a command could not do its work.
#[derive(Clone, Debug, PartialEq)]
pub struct Failure {
    /// At least one.
    pub mistakes: Vec<Mistake>,
}

/// A result with [`Failure`].
pub type Result<T> = std::result::Result<T, Failure>;

impl Mistake {
    /// A mistake without a place.
    pub fn new(status: Status, message: impl Into<String>) -> Self {
        Self { status, place: None, message: message.into(), hint: None }
    }

    /// Adds where it is.
    pub fn at(self, place: Place) -> Self {
        Self { place: Some(place), ..self }
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
        let (file, line, column) = match &self.place {
            Some(Place::File(file)) => (Some(file), None, None),
            Some(Place::Line { file, line }) => (Some(file), Some(line), None),
            Some(Place::Span { file, line, column, .. }) => (Some(file), Some(line), Some(column)),
            Some(Place::Option(_)) | None => (None, None, None),
        };
        let option = if let Some(Place::Option(option)) = &self.place { Some(option) } else { None };
        let mut result = json!({
            "file": file, "line": line, "column": column, "option": option, "message": self.message, "hint": self.hint,
        });
        if let Some(object) = result.as_object_mut() {
            object.retain(|_, value| !value.is_null());
        }
        result
    }
}

impl From<core::Error> for Mistake {
    /// The message keeps file and line where the error has them; a line becomes a place, so that editors can jump.
    fn from(error: core::Error) -> Self {
        let mistake = Self::new(Status::of(&error), error.to_string()).hint(error.hint().unwrap_or_default());
        match error {
            core::Error::File { path, line: Some(line), message, .. } => {
                Self { message, ..mistake }.at(Place::Line { file: path, line })
            }
            core::Error::File { path, line: None, message, .. } => Self { message, ..mistake }.at(Place::File(path)),
            core::Error::Io { path, action, source } => {
                let hint = io_hint(&path, action, &source);
                Self { message: io_message(action, &source), ..mistake }.hint(hint).at(Place::File(path))
            }
            _ => mistake,
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
/// A [`Mistake`] at the file.
pub fn read_text(path: &Path) -> std::result::Result<String, Mistake> {
    std::fs::read_to_string(path).map_err(|error| core::Error::read(path, error).into())
}

impl Failure {
    /// The exit status of all mistakes together.
    pub fn status(&self) -> Status {
        Status::of_all(self.mistakes.iter().map(|mistake| mistake.status))
    }
}

impl From<Mistake> for Failure {
    fn from(mistake: Mistake) -> Self {
        Self { mistakes: vec![mistake] }
    }
}

impl From<core::Error> for Failure {
    fn from(error: core::Error) -> Self {
        Mistake::from(error).into()
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File(file) => write!(f, "{}", file.display()),
            Self::Line { file, line } => write!(f, "{}:{line}", file.display()),
            Self::Span { file, line, column, .. } => write!(f, "{}:{line}:{column}", file.display()),
            Self::Option(option) => f.write_str(option),
        }
    }
}

impl fmt::Display for Mistake {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(place) = &self.place {
            write!(f, "{place}: ")?;
        }
        f.write_str(&self.message)?;
        let margin = match &self.place {
            Some(Place::Span { line, column, length, text, .. }) => {
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

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, mistake) in self.mistakes.iter().enumerate() {
            let line = if i == 0 { "" } else { "\n" };
            write!(f, "{line}error: {mistake}")?;
        }
        Ok(())
    }
}

impl std::error::Error for Mistake {}
impl std::error::Error for Failure {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_in_a_line_is_shown_below_it() {
        let place = Place::Span { file: "a.yaml".into(), line: 12, column: 4, length: 2, text: "a: bc\t# é".into() };
        let mistake = Mistake::new(Status::BadPipeline, "no bc").at(place).hint("say so");
        assert_eq!(mistake.to_string(), "a.yaml:12:4: no bc\n    |\n 12 | a: bc # é\n    |    ^^\n    = hint: say so");
    }

    #[test]
    fn marks_end_with_the_line() {
        let place = Place::Span { file: "a".into(), line: 1, column: 3, length: 99, text: "a: {".into() };
        let mistake = Mistake::new(Status::BadPipeline, "open").at(place);
        assert_eq!(mistake.to_string(), "a:1:3: open\n   |\n 1 | a: {\n   |   ^^");
    }
}
