//! The text of the pipeline and its file.

use std::{
    io,
    path::{Path, PathBuf},
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};

use mimesh_document::{Document, Step, diagnostic, files, include};
use serde::Serialize;
use serde_json::Value;

use super::{
    check::Checked,
    history::{TYPED, TextHistory, title},
    set,
};
use crate::{
    durable,
    error::{ApiDiagnostic, ApiError, Code, Result},
    markers::DiskState,
    regular,
};

/// The text of the pipeline of a project, and the file that holds it.
#[derive(Debug)]
pub struct PipelineStore {
    file: PathBuf,
    state: Mutex<State>,
}

#[derive(Debug)]
struct State {
    revision: u64,
    text: String,
    exists: bool,
    known: Option<blake3::Hash>,
    disk: DiskState,
    disk_error: Option<String>,
    checked: Arc<Checked>,
    /// The revision that `checked` is about.
    checked_revision: u64,
    history: TextHistory,
}

/// The pipeline as pages see it.
#[derive(Clone, Debug, Serialize)]
pub struct PipelineView {
    /// The revision.
    pub revision: u64,
    file: PathBuf,
    exists: bool,
    text: String,
    value: Value,
    /// Whether the check of this text is under way; diagnostics and choices are those of the text before.
    checking: bool,
    diagnostics: Vec<ApiDiagnostic>,
    choices: Value,
    outputs: Vec<PathBuf>,
    disk: DiskState,
    disk_error: Option<String>,
    undo: Option<String>,
    undo_order: Option<u64>,
    redo: Option<String>,
    redo_order: Option<u64>,
}

impl PipelineStore {
    /// The pipeline in `file`; `text` where there is no such file yet.
    ///
    /// # Errors
    ///
    /// If the file cannot be read.
    pub fn open(file: PathBuf, text: String) -> diagnostic::Result<Self> {
        let (text, exists) = match regular::read_text(&file) {
            Ok(text) => (text, true),
            Err(error) if error.kind() == io::ErrorKind::NotFound => (text, false),
            Err(error) => return Err(files::unreadable(&file, "read", &error).into()),
        };
        let known = exists.then(|| blake3::hash(text.as_bytes()));
        let state = State {
            revision: 1,
            text,
            exists,
            known,
            disk: DiskState::Saved,
            disk_error: None,
            checked: Arc::default(),
            checked_revision: 0,
            history: TextHistory::default(),
        };
        Ok(Self { file, state: Mutex::new(state) })
    }

    /// The file.
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// The pipeline as pages see it.
    pub fn view(&self) -> Arc<PipelineView> {
        let state = self.lock();
        let parsed = Document::parse(&self.file, &state.text);
        let mut diagnostics = state.checked.diagnostics.clone();
        if let Err(failure) = &parsed {
            diagnostics = failure.list.iter().map(|one| ApiDiagnostic::of(one, None)).collect();
        }
        Arc::new(PipelineView {
            revision: state.revision,
            file: self.file.clone(),
            exists: state.exists,
            text: state.text.clone(),
            value: parsed.map(|document| document.value).unwrap_or_default(),
            checking: state.checked_revision != state.revision,
            diagnostics,
            choices: state.checked.choices.clone(),
            outputs: state.checked.outputs.clone(),
            disk: state.disk,
            disk_error: state.disk_error.clone(),
            undo: state.history.last().map(|step| step.title.clone()),
            undo_order: state.history.last().map(|step| step.order),
            redo: state.history.next().map(|step| step.title.clone()),
            redo_order: state.history.next().map(|step| step.order),
        })
    }

    /// The revision.
    pub fn revision(&self) -> u64 {
        self.lock().revision
    }

    /// Whether the check of the present text is under way.
    pub fn is_checking(&self) -> bool {
        let state = self.lock();
        state.checked_revision != state.revision
    }

    /// The pipeline with what it includes, and the included files; with the revision.
    ///
    /// # Errors
    ///
    /// If one of the files is no YAML or cannot be read.
    pub fn document(&self) -> (u64, diagnostic::Result<(Document, Vec<PathBuf>)>) {
        let (revision, text, exists) = {
            let state = self.lock();
            (state.revision, state.text.clone(), state.exists)
        };
        let document = if exists {
            include::read(&self.file)
        } else {
            Document::parse(&self.file, &text).map(|document| (document, vec![]))
        };
        (revision, document)
    }

    /// The value of the text, as far as it is YAML.
    pub fn value(&self) -> Value {
        let text = self.lock().text.clone();
        Document::parse(&self.file, &text).map(|document| document.value).unwrap_or_default()
    }

    /// Takes `text` for the pipeline and saves it; `None` if `base` is not the present revision any more.
    pub fn put(&self, base: u64, text: String) -> Option<()> {
        let mut state = self.lock();
        self.take_in(&mut state);
        if state.revision != base {
            return None;
        }
        self.change(&mut state, text, TYPED.into());
        Some(())
    }

    /// Sets the value at `path`, or takes it away, and saves the text; `None` if `base` is not the present revision any more.
    ///
    /// # Errors
    ///
    /// If the text is no YAML, or has nothing in which the value could stand.
    pub fn set(&self, base: u64, path: &[Step], value: Option<&Value>) -> Result<Option<()>> {
        let mut state = self.lock();
        self.take_in(&mut state);
        if base != state.revision {
            return Ok(None);
        }
        let text = changed(&state.text, path, value)?;
        self.change(&mut state, text, title(path, value));
        Ok(Some(()))
    }

    /// Sets the value at `path` by the server itself, which no undo takes back, and saves the text.
    ///
    /// # Errors
    ///
    /// As [`set`](Self::set).
    pub fn set_silently(&self, path: &[Step], value: &Value) -> Result<()> {
        let mut state = self.lock();
        self.take_in(&mut state);
        let text = changed(&state.text, path, Some(value))?;
        state.history.set_everywhere(path, value);
        self.replace(&mut state, text);
        self.save(&mut state);
        Ok(())
    }

    /// Takes back the last step, or does it again (`redo`), and saves that; `None` if `base` is not the present revision any more.
    ///
    /// # Errors
    ///
    /// If there is no such step.
    pub fn undo(&self, base: u64, redo: bool) -> Result<Option<()>> {
        let mut state = self.lock();
        self.take_in(&mut state);
        if base != state.revision {
            return Ok(None);
        }
        let text = if redo { state.history.forward() } else { state.history.back() };
        let what = if redo { "redo" } else { "undo" };
        let text = text.ok_or_else(|| ApiError::new(Code::Conflict, format!("there is nothing to {what}")))?;
        self.replace(&mut state, text);
        self.save(&mut state);
        Ok(Some(()))
    }

    /// Forgets what was taken back; whether there was any.
    pub fn forget_redo(&self) -> bool {
        self.lock().history.forget_redo()
    }

    /// Saves a text that was never saved.
    pub fn save_new(&self) {
        let mut state = self.lock();
        if !state.exists {
            self.save(&mut state);
        }
    }

    /// Takes in what somebody else made of the file. Whether anything has changed.
    pub fn refresh(&self) -> bool {
        let mut state = self.lock();
        let before = state.revision;
        self.take_in(&mut state);
        before != state.revision
    }

    /// Notes what the check of `revision` found. Whether that is still the present one.
    pub fn checked(&self, revision: u64, checked: Checked) -> bool {
        let mut state = self.lock();
        if state.revision == revision {
            (state.checked, state.checked_revision) = (Arc::new(checked), revision);
        }
        state.revision == revision
    }

    /// Notes what is wrong with `revision` as far as it is known before the check of the whole pipeline ends.
    pub fn found(&self, revision: u64, diagnostics: Vec<ApiDiagnostic>) {
        let mut state = self.lock();
        if state.revision == revision && state.checked_revision != revision {
            state.checked = Arc::new(Checked { diagnostics, ..(*state.checked).clone() });
        }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn take_in(&self, state: &mut State) {
        let Ok(text) = regular::read_text(&self.file) else { return };
        let hash = blake3::hash(text.as_bytes());
        if state.known == Some(hash) {
            return;
        }
        (state.known, state.exists, state.disk, state.disk_error) = (Some(hash), true, DiskState::Saved, None);
        if text != state.text {
            state.history.push("changes in the file".into(), state.text.clone(), text.clone());
            self.replace(state, text);
        }
    }

    fn change(&self, state: &mut State, text: String, title: String) {
        if text != state.text {
            state.history.push(title, state.text.clone(), text.clone());
            self.replace(state, text);
        }
        self.save(state);
    }

    fn replace(&self, state: &mut State, text: String) {
        if text != state.text {
            state.text = text;
            state.revision += 1;
        }
    }

    fn save(&self, state: &mut State) {
        match durable::write(&self.file, state.text.as_bytes()) {
            Ok(()) => {
                state.known = Some(blake3::hash(state.text.as_bytes()));
                (state.exists, state.disk, state.disk_error) = (true, DiskState::Saved, None);
            }
            Err(error) => (state.disk, state.disk_error) = (DiskState::Failed, Some(error.to_string())),
        }
    }
}

/// The text with another value at `path`.
fn changed(text: &str, path: &[Step], value: Option<&Value>) -> Result<String> {
    set::set(text, path, value)
        .map_err(|problem| ApiError::new(Code::Unprocessable, problem).hint("change the text itself"))
}
