//! What a check collects on its way, and what it looks things up in.

use std::path::{Path, PathBuf};

use mimesh_core::Error;
use mimesh_document::{At, Diagnostic, Diagnostics, Document, Kind, Location, Step, files::why_no_file, paths};
use serde_json::Value;

use crate::{choices::Choice, formats::Formats, input::InputFile};

/// What a check has found so far.
#[derive(Debug, Default)]
pub(super) struct Findings {
    /// What is wrong.
    pub diagnostics: Diagnostics,
    /// Sentences about what looks wrong or was left out.
    pub warnings: Vec<String>,
    /// The files that a run reads.
    pub inputs: Vec<InputFile>,
    /// What was chosen where the pipeline leaves it open.
    pub choices: Vec<Choice>,
}

/// The document that is checked, and the formats that it configures.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scope<'a> {
    /// The document.
    pub document: &'a Document,
    /// The formats.
    pub formats: &'a Formats,
    /// The paths of values that have diagnostics of their own.
    pub rejected: &'a [Vec<Step>],
}

impl Scope<'_> {
    /// The path at `at`, as seen from the current folder: it is relative to the folder of the file that names it.
    pub fn path(&self, at: &[Step], path: &Path) -> PathBuf {
        paths::from_base(self.document.folder(at), path)
    }

    /// Whether `error` is about a setting of the stage at `at` that has a diagnostic already.
    pub fn is_reported(&self, error: &Error, at: &[Step]) -> bool {
        matches!(error, Error::Setting { .. })
            && self.rejected.iter().any(|rejected| rejected.starts_with(at) || at.starts_with(rejected))
    }
}

impl Findings {
    /// Adds all that was found elsewhere.
    pub fn absorb(&mut self, other: Self) {
        let Self { diagnostics, warnings, inputs, choices } = other;
        self.diagnostics.extend(diagnostics);
        self.warnings.extend(warnings);
        self.inputs.extend(inputs);
        self.choices.extend(choices);
    }

    /// Adds a diagnostic at `path`.
    pub fn wrong(
        &mut self,
        scope: Scope<'_>,
        path: &[Step],
        at: At,
        message: impl Into<String>,
        hint: impl Into<String>,
    ) {
        self.diagnostics.push(scope.document.diagnostic(path, at, message).hint(hint));
    }

    /// Adds a diagnostic about a file that is missing, named at `path`.
    pub fn missing(&mut self, scope: Scope<'_>, path: &[Step], message: impl Into<String>, hint: impl Into<String>) {
        let diagnostic = scope.document.diagnostic(path, At::Value, message).hint(hint);
        self.diagnostics.push(Diagnostic { kind: Kind::MissingInput, ..diagnostic });
    }

    /// Notes that `path` and the files that it names are read; `false`, and a diagnostic at `at`, if there is no such file.
    pub fn input(&mut self, scope: Scope<'_>, role: &'static str, path: &Path, at: &[Step]) -> bool {
        let Some((message, hint)) = why_no_file(path) else {
            self.inputs.push(InputFile { role, path: path.into() });
            // Several files may share one that they name; that it is missing is reported when they are read.
            for path in scope.formats.files(path).into_iter().filter(|file| file != path && file.is_file()) {
                let named = InputFile { role: "mesh data", path };
                if !self.inputs.contains(&named) {
                    self.inputs.push(named);
                }
            }
            return true;
        };
        let base = match scope.document.location(at, At::Value) {
            Location::Argument(_) => "the current folder",
            _ => "the folder of the pipeline's file",
        };
        let hint = hint.unwrap_or_else(|| format!("paths are relative to {base}"));
        self.missing(scope, at, message, hint);
        false
    }

    /// Adds the warnings of a reader of `file`, each once for all files that have it: poses of one rig have the same.
    pub fn warn_of_file(&mut self, file: &Path, warnings: &[String]) {
        for warning in warnings {
            let tail = format!(": {warning}");
            if !self.warnings.iter().any(|other| other.ends_with(&tail)) {
                self.warnings.push(format!("{}{tail}", file.display()));
            }
        }
    }

    /// Reports empty strings where a path belongs: the value at `path`, or items of the sequence there.
    pub fn check_empty(&mut self, scope: Scope<'_>, path: &[Step]) {
        let Some(value) = scope.document.get(path) else { return };
        let empty: Vec<Vec<Step>> = match value {
            Value::String(text) if text.is_empty() => vec![path.to_vec()],
            Value::Array(list) => {
                let items = list.iter().enumerate().filter(|(_, item)| item.as_str() == Some(""));
                items.map(|(i, _)| [path, &[Step::Index(i)]].concat()).collect()
            }
            _ => vec![],
        };
        for path in empty {
            self.wrong(scope, &path, At::Value, "expected a path, found an empty string", "name a file, or remove it");
        }
    }
}
