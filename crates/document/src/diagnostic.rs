//! Diagnostics: what is wrong, where, and what to do about it.

use std::{collections::HashSet, fmt, path::PathBuf};

use serde::Serialize;
use serde_json::{Value, json};

use crate::limits::{MAX_DIAGNOSTICS, on_one_line, shortened};

/// What kind of thing is wrong; a program that runs pipelines turns kinds into exit statuses or responses of its own.
///
/// Of several diagnostics together the largest counts: a wrong pipeline first, since the others may follow from it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
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
    /// Another process is at work on the same files or results, or has not yet done its part.
    Busy,
    /// There is not enough memory.
    Memory,
    /// The pipeline file is wrong.
    BadPipeline,
}

impl Kind {
    /// The kind of several diagnostics together.
    pub fn of_all(kinds: impl IntoIterator<Item = Self>) -> Self {
        kinds.into_iter().max().unwrap_or(Self::Internal)
    }
}

/// One thing that is wrong, as the user sees it.
///
/// It displays as `location: message`, then the line of the file with the wrong part marked, then a hint.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Diagnostic {
    /// What kind of thing is wrong.
    pub kind: Kind,
    /// Where, if it has a place that the message does not name itself.
    pub location: Option<Location>,
    /// Lower case, no full stop; what was expected and what was found.
    pub message: String,
    /// The way out.
    pub hint: Option<String>,
    /// A way out that the host program has to name, e.g. by one of its options.
    pub remedy: Option<Box<Remedy>>,
}

/// A way out that depends on the program around the library: a command line names an option, a server something else.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Remedy {
    /// The action, one of the constants of the crate that proposes it; the host program looks it up.
    pub action: &'static str,
    /// What the action is about, e.g. the value to set; may be empty.
    pub argument: String,
    /// The action in words that fit every host.
    pub words: String,
}

/// Remedy: set a value of the pipeline; the argument is `key=value`.
pub const SET_VALUE: &str = "set_value";

/// Remedy: show the settings of a stage; the argument is its kind and its type with a blank between them.
pub const SHOW_SETTINGS: &str = "show_settings";

/// A place in what the user wrote.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize)]
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
        column: u32,
        /// How many characters, at least 1.
        length: u32,
        /// The text of the line; empty where it is too long to be shown, or none of the user's.
        text: Box<str>,
    },
    /// A value that was set beside the file, `key=value`.
    Setting(String),
    /// The folder for results that was given beside the file.
    OutputFolder(PathBuf),
    /// An argument of the host program, as it was given there.
    Argument(String),
}

/// A list of diagnostics: what a check has found so far, or, as an error, why work could not be done.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Diagnostics {
    /// The diagnostics in the order in which they were found.
    pub list: Vec<Diagnostic>,
}

/// A result with [`Diagnostics`].
pub type Result<T> = std::result::Result<T, Diagnostics>;

impl Diagnostic {
    /// A diagnostic without a place.
    pub fn new(kind: Kind, message: impl Into<String>) -> Self {
        Self { kind, location: None, message: message.into(), hint: None, remedy: None }
    }

    /// Adds where it is.
    pub fn at(self, location: Location) -> Self {
        Self { location: Some(location), ..self }
    }

    /// Adds a way out.
    pub fn hint(self, hint: impl Into<String>) -> Self {
        Self { hint: Some(hint.into()).filter(|hint| !hint.is_empty()), ..self }
    }

    /// Adds a way out that the host program names.
    pub fn remedy(self, action: &'static str, argument: impl Into<String>, words: impl Into<String>) -> Self {
        let remedy = Remedy { action, argument: argument.into(), words: words.into() };
        Self { remedy: Some(Box::new(remedy)), ..self }
    }

    /// Puts the action in front of the message, e.g. `transfer (gradient)`.
    pub fn doing(self, what: impl fmt::Display) -> Self {
        Self { message: format!("{what}: {}", self.message), ..self }
    }

    /// Hint and remedy together.
    fn way_out(&self) -> Option<String> {
        match (&self.hint, &self.remedy) {
            (Some(hint), Some(remedy)) => Some(format!("{hint}, or {}", remedy.words)),
            (Some(hint), None) => Some(hint.clone()),
            (None, remedy) => remedy.as_ref().map(|remedy| remedy.words.clone()),
        }
    }

    /// As JSON: `file`, `line` and `column` (each where known), `message` and `hint`.
    pub fn to_json(&self) -> Value {
        let (file, line, column) = match &self.location {
            Some(Location::File(file)) => (Some(file), None, None),
            Some(Location::Line { file, line }) => (Some(file), Some(line), None),
            Some(Location::Span { file, line, column, .. }) => (Some(file), Some(line), Some(column)),
            _ => (None, None, None),
        };
        let option = match &self.location {
            Some(location @ (Location::Setting(_) | Location::OutputFolder(_) | Location::Argument(_))) => {
                Some(location.to_string())
            }
            _ => None,
        };
        // A name that is no Unicode has a mark in place of what is none.
        let file = file.map(|file| file.to_string_lossy());
        let mut result = json!({
            "file": file, "line": line, "column": column, "option": option, "message": shortened(&self.message), "hint": self.way_out(),
        });
        if let Some(object) = result.as_object_mut() {
            object.retain(|_, value| !value.is_null());
        }
        result
    }
}

impl Diagnostics {
    /// Whether nothing is wrong.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// The number of diagnostics.
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Adds a diagnostic, unless there are so many that more would tell nothing.
    pub fn push(&mut self, diagnostic: Diagnostic) {
        if self.list.len() < MAX_DIAGNOSTICS {
            self.list.push(diagnostic);
        }
    }

    /// Adds the diagnostics of `others`.
    pub fn extend(&mut self, others: impl IntoIterator<Item = Diagnostic>) {
        others.into_iter().for_each(|other| self.push(other));
    }

    /// Leaves out repetitions; the first of equal diagnostics stays.
    pub fn deduplicate(&mut self) {
        let mut seen = HashSet::new();
        self.list.retain(|diagnostic| seen.insert(diagnostic.clone()));
    }

    /// The list as an error, unless it is empty.
    ///
    /// # Errors
    ///
    /// The diagnostics themselves.
    pub fn into_result(self) -> Result<()> {
        if self.is_empty() { Ok(()) } else { Err(self) }
    }

    /// The kind of all diagnostics together.
    pub fn kind(&self) -> Kind {
        Kind::of_all(self.list.iter().map(|diagnostic| diagnostic.kind))
    }
}

impl From<Diagnostic> for Diagnostics {
    fn from(diagnostic: Diagnostic) -> Self {
        Self { list: vec![diagnostic] }
    }
}

impl From<Vec<Diagnostic>> for Diagnostics {
    fn from(list: Vec<Diagnostic>) -> Self {
        Self { list }
    }
}

impl IntoIterator for Diagnostics {
    type Item = Diagnostic;
    type IntoIter = std::vec::IntoIter<Diagnostic>;

    fn into_iter(self) -> Self::IntoIter {
        self.list.into_iter()
    }
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File(file) => write!(f, "{}", file.display()),
            Self::Line { file, line } => write!(f, "{}:{line}", file.display()),
            Self::Span { file, line, column, .. } => write!(f, "{}:{line}:{column}", file.display()),
            Self::Setting(setting) => f.write_str(setting),
            Self::OutputFolder(folder) => write!(f, "output folder {}", folder.display()),
            Self::Argument(argument) => f.write_str(argument),
        }
    }
}

impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(location) = &self.location {
            write!(f, "{}: ", on_one_line(&shortened(&location.to_string())))?;
        }
        f.write_str(&on_one_line(&shortened(&self.message)))?;
        let margin = match &self.location {
            Some(Location::Span { line, column, length, text, .. }) if !text.is_empty() => {
                let number = line.to_string();
                let margin = " ".repeat(number.len());
                let shown = text.replace('\t', " ").replace(char::is_control, "\u{fffd}");
                let before = *column as usize - 1;
                let marks =
                    "^".repeat((*length as usize).clamp(1, shown.chars().count().saturating_sub(before).max(1)));
                write!(f, "\n {margin} |\n {number} | {shown}\n {margin} | {}{marks}", " ".repeat(before))?;
                format!(" {margin} = ")
            }
            _ => "  ".into(),
        };
        match self.way_out() {
            Some(hint) => write!(f, "\n{margin}hint: {}", on_one_line(&shortened(&hint))),
            None => Ok(()),
        }
    }
}

impl fmt::Display for Diagnostics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, diagnostic) in self.list.iter().enumerate() {
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

    #[test]
    fn a_wrong_pipeline_outweighs_a_missing_file() {
        assert_eq!(Kind::of_all([Kind::MissingInput, Kind::BadPipeline, Kind::BadData]), Kind::BadPipeline);
    }
}
