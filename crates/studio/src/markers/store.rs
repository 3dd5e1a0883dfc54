//! The document with its file: every accepted change is on the disk before anybody hears of it.

use std::{
    io,
    path::{Path, PathBuf},
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};

use mimesh_core::stage::Marker;
use mimesh_document::{Diagnostics, diagnostic};
use mimesh_markers::{MarkerFile, formats::yaml};

use super::{
    document::MarkerDocument,
    edit::{Edit, EditResult},
    file,
    pair::{Content, Origin, Pair, Status},
    view::{DiskState, EditView, MarkersView},
};
use crate::{durable, error::Result, meshes::Meshes, regular};

/// The document of a project, and the file that holds it.
#[derive(Debug)]
pub struct MarkerStore {
    meshes: Arc<Meshes>,
    file: PathBuf,
    state: Mutex<State>,
}

#[derive(Debug)]
struct State {
    document: MarkerDocument,
    /// The hash of the file as it was read or written last; `None` if there is none.
    known: Option<blake3::Hash>,
    /// The file as somebody else left it, which could not be read; it is set aside before it is overwritten.
    unreadable: Option<Vec<u8>>,
    disk: DiskState,
    disk_error: Option<String>,
}

/// Pairs that stages can use, at a revision.
#[derive(Clone, Debug)]
pub struct Usable {
    /// The revision.
    pub revision: u64,
    /// The pairs on the surfaces.
    pub markers: Vec<Marker>,
    /// The ids of the same pairs.
    pub ids: Vec<u64>,
    /// Their contents.
    pub contents: Vec<Content>,
}

impl MarkerStore {
    /// The document in `file`, or if there is none, with the pairs of `initial`.
    ///
    /// # Errors
    ///
    /// What is wrong with the file; it is left as it is.
    pub fn open(file: PathBuf, meshes: Arc<Meshes>, initial: Vec<(Content, Origin)>) -> diagnostic::Result<Self> {
        let (document, known) = match regular::read(&file) {
            Ok(bytes) => {
                let contents = parse(&file, &bytes)?.into_iter().map(|content| (content, Origin::File));
                (MarkerDocument::new(contents), Some(blake3::hash(&bytes)))
            }
            Err(error) if error.kind() == io::ErrorKind::NotFound => (MarkerDocument::new(initial), None),
            Err(error) => return Err(mimesh_document::files::unreadable(&file, "read", &error).into()),
        };
        let state = State { document, known, unreadable: None, disk: DiskState::Saved, disk_error: None };
        Ok(Self { meshes, file, state: Mutex::new(state) })
    }

    /// The file.
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// The document as pages see it.
    pub fn view(&self) -> Arc<MarkersView> {
        self.view_of(&self.lock())
    }

    /// The revision.
    pub fn revision(&self) -> u64 {
        self.lock().document.revision()
    }

    /// Whether there are no pairs.
    pub fn is_empty(&self) -> bool {
        self.lock().document.pairs().is_empty()
    }

    /// Does the operations of `edit` that do not conflict, and saves them.
    ///
    /// What was changed on the disk is taken in first, so that it can conflict.
    ///
    /// # Errors
    ///
    /// For an edit that makes no sense as a whole.
    pub fn edit(&self, edit: &Edit) -> Result<EditView> {
        let mut state = self.lock();
        let before = state.document.revision();
        self.take_in(&mut state);
        let result = state.document.edit(edit, self.meshes.for_markers())?;
        Ok(self.finish(&mut state, before, result))
    }

    /// Takes back the last step, or does it again (`redo`), and saves that.
    pub fn undo(&self, base: u64, redo: bool) -> EditView {
        let mut state = self.lock();
        let before = state.document.revision();
        self.take_in(&mut state);
        let done = if redo { state.document.redo(base) } else { state.document.undo(base) };
        let conflicts = done.err().into_iter().collect();
        self.finish(&mut state, before, EditResult { conflicts, ..EditResult::default() })
    }

    /// Replaces all pairs that are still proposed. Proposals alone make no file: nobody has done anything yet.
    pub fn propose(&self, proposals: Vec<Content>) -> EditView {
        let mut state = self.lock();
        let before = state.document.revision();
        self.take_in(&mut state);
        let is_new = state.known.is_none();
        state.document.propose(proposals);
        let is_only_proposed =
            is_new && state.document.pairs().iter().all(|pair| pair.content.status == Status::Proposed);
        if !is_only_proposed {
            self.save(&mut state);
        }
        self.view_of_edit(&state, before, EditResult::default())
    }

    /// Forgets what was taken back; whether there was any.
    pub fn forget_redo(&self) -> bool {
        self.lock().document.forget_redo()
    }

    /// Takes in what somebody else made of the file. Whether anything has changed, also in how the file stands.
    pub fn refresh(&self) -> bool {
        let mut state = self.lock();
        let before = (state.document.revision(), state.disk, state.disk_error.clone());
        self.take_in(&mut state);
        if state.disk == DiskState::Failed {
            self.save(&mut state);
        }
        before != (state.document.revision(), state.disk, state.disk_error.clone())
    }

    /// The pairs that stages can use.
    pub fn usable(&self) -> Usable {
        let state = self.lock();
        let meshes = self.meshes.for_markers();
        let mut usable = Usable { revision: state.document.revision(), markers: vec![], ids: vec![], contents: vec![] };
        for i in state.document.usable(meshes) {
            let pair = &state.document.pairs()[i];
            let [Some(source), Some(target)] = pair.content.points else { continue };
            let on = (meshes[0].surface.point(source.into()), meshes[1].surface.point(target.into()));
            let (Some(source), Some(target)) = on else { continue };
            usable.markers.push(Marker { name: pair.label(), source, target });
            usable.ids.push(pair.id);
            usable.contents.push(pair.content.clone());
        }
        usable
    }

    /// The pairs in order.
    pub fn pairs(&self) -> (u64, Vec<Arc<Pair>>) {
        let state = self.lock();
        (state.document.revision(), state.document.pairs().to_vec())
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Saves what has changed since revision `before`.
    fn finish(&self, state: &mut State, before: u64, result: EditResult) -> EditView {
        if state.document.revision() != before || state.disk == DiskState::Failed {
            self.save(state);
        }
        self.view_of_edit(state, before, result)
    }

    /// Reads the file if it is not as it was left.
    fn take_in(&self, state: &mut State) {
        let Ok(bytes) = regular::read(&self.file) else { return };
        let hash = blake3::hash(&bytes);
        if state.known == Some(hash) {
            return;
        }
        state.known = Some(hash);
        if state.disk == DiskState::Failed {
            // What could not be saved counts for more than what somebody else saved; nothing of either is lost.
            state.unreadable = Some(bytes);
            return;
        }
        match parse(&self.file, &bytes) {
            Ok(contents) => {
                state.document.take_in(contents, "changes in the file");
                (state.disk, state.disk_error, state.unreadable) = (DiskState::Saved, None, None);
            }
            Err(failure) => {
                let first = failure.list.first().map(ToString::to_string).unwrap_or_default();
                let first = first.lines().next().unwrap_or_default().to_owned();
                (state.disk, state.disk_error, state.unreadable) =
                    (DiskState::ChangedElsewhere, Some(first), Some(bytes));
            }
        }
    }

    fn save(&self, state: &mut State) {
        let meshes = self.meshes.for_markers();
        let [source, target] = self.meshes.references();
        let pairs = file::of_pairs(state.document.pairs().iter().map(|pair| &**pair), meshes);
        let text = yaml::write(&MarkerFile { source: Some(source.clone()), target: Some(target.clone()), ..pairs });
        let saved = set_aside(&self.file, state.unreadable.as_deref())
            .and_then(|()| durable::write(&self.file, text.as_bytes()));
        match saved {
            Ok(()) => {
                state.known = Some(blake3::hash(text.as_bytes()));
                (state.disk, state.disk_error, state.unreadable) = (DiskState::Saved, None, None);
            }
            Err(error) => (state.disk, state.disk_error) = (DiskState::Failed, Some(error.to_string())),
        }
    }

    fn view_of(&self, state: &State) -> Arc<MarkersView> {
        let disk = (state.disk, state.disk_error.clone());
        Arc::new(MarkersView::new(&state.document, self.meshes.for_markers(), &self.file, state.known.is_some(), disk))
    }

    fn view_of_edit(&self, state: &State, before: u64, result: EditResult) -> EditView {
        let is_changed = state.document.revision() != before;
        EditView::new(self.view_of(state), &state.document, result, is_changed)
    }
}

/// The pairs in the text of `file`.
fn parse(path: &Path, bytes: &[u8]) -> std::result::Result<Vec<Content>, Diagnostics> {
    let text = std::str::from_utf8(bytes)
        .map_err(|_| mimesh_document::files::unreadable(path, "read", &io::ErrorKind::InvalidData.into()))?;
    Ok(yaml::parse(path, text)?.pairs.iter().map(file::content).collect())
}

/// Copies what somebody else wrote into `file` beside it, before it is overwritten.
fn set_aside(file: &Path, contents: Option<&[u8]>) -> std::result::Result<(), mimesh_document::Diagnostic> {
    let Some(contents) = contents else { return Ok(()) };
    let stem = mimesh_document::paths::stem(file);
    let free =
        (1..1000).map(|i| file.with_file_name(format!("{stem}.unreadable-{i}.yaml"))).find(|path| !path.exists());
    free.map_or(Ok(()), |path| durable::write(&path, contents))
}
