//! The document of markers as pages see it.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use mimesh_markers::MarkerMesh;
use serde::Serialize;

use super::{
    document::MarkerDocument,
    edit::{Conflict, EditResult, Mirrored},
    pair::{COLOURS, Content, Origin, Pair, Point, Side, Status},
};

/// How the file stands to the document.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum DiskState {
    /// It holds the document.
    Saved,
    /// Somebody else made something of it that cannot be read.
    ChangedElsewhere,
    /// It cannot be written.
    Failed,
}

/// The document as pages see it.
#[derive(Clone, Debug, Serialize)]
pub struct MarkersView {
    /// The revision.
    pub revision: u64,
    file: PathBuf,
    exists: bool,
    pairs: Vec<PairView>,
    can_undo: bool,
    can_redo: bool,
    undo: Option<String>,
    undo_order: Option<u64>,
    redo: Option<String>,
    redo_order: Option<u64>,
    problems: Vec<Problem>,
    disk: DiskState,
    disk_error: Option<String>,
}

impl MarkersView {
    /// Whether the pair `id` was changed after `revision`, or is gone.
    pub fn changed_since(&self, id: u64, revision: u64) -> bool {
        self.pairs.iter().find(|pair| pair.id == id).is_none_or(|pair| pair.revision > revision)
    }
}

#[derive(Clone, Debug, Serialize)]
struct PairView {
    id: u64,
    number: usize,
    colour: u64,
    name: Option<String>,
    note: Option<String>,
    source: Option<Point>,
    target: Option<Point>,
    status: Status,
    confidence: Option<f64>,
    origin: Origin,
    revision: u64,
}

#[derive(Clone, Debug, Serialize)]
struct Problem {
    pair: u64,
    side: Side,
    message: String,
    hint: &'static str,
}

/// What became of an edit, with the document after it.
#[derive(Clone, Debug, Serialize)]
pub struct EditView {
    /// The document.
    #[serde(serialize_with = "crate::shared::serialize")]
    pub markers: Arc<MarkersView>,
    added: Vec<Option<u64>>,
    /// The operations that were not done.
    pub conflicts: Vec<ConflictView>,
    mirrored: Option<Mirrored>,
    /// Whether the document has changed.
    #[serde(skip)]
    pub is_changed: bool,
}

/// An operation that was not done, with the pair as it is.
#[derive(Clone, Debug, Serialize)]
pub struct ConflictView {
    op: usize,
    pair: Option<u64>,
    reason: String,
    current: Option<PairView>,
}

impl MarkersView {
    /// What pages see of `document`, which `file` holds if it `exists`; `disk` is how the file stands to it, and why.
    pub fn new(
        document: &MarkerDocument,
        meshes: [MarkerMesh<'_>; 2],
        file: &Path,
        exists: bool,
        (disk, disk_error): (DiskState, Option<String>),
    ) -> Self {
        let history = document.history();
        let problems = document.problems(meshes).into_iter().map(|(pair, side, message)| Problem {
            pair,
            side,
            message,
            hint: "move the point, or delete the pair",
        });
        Self {
            revision: document.revision(),
            file: file.into(),
            exists,
            pairs: document.pairs().iter().map(|pair| view_of_pair(pair)).collect(),
            can_undo: history.last().is_some(),
            can_redo: history.next().is_some(),
            undo: history.last().map(|step| step.title.clone()),
            undo_order: history.last().map(|step| step.order),
            redo: history.next().map(|step| step.title.clone()),
            redo_order: history.next().map(|step| step.order),
            problems: problems.collect(),
            disk,
            disk_error,
        }
    }
}

impl EditView {
    /// What became of an edit that gave `result`; `markers` are those of `document` after it.
    pub fn new(markers: Arc<MarkersView>, document: &MarkerDocument, result: EditResult, is_changed: bool) -> Self {
        let EditResult { added, conflicts, mirrored } = result;
        let current = |id: u64| Some(view_of_pair(&document.pairs()[document.position(id)?]));
        let conflict =
            |Conflict { op, pair, reason }| ConflictView { op, pair, reason, current: pair.and_then(current) };
        Self { markers, added, conflicts: conflicts.into_iter().map(conflict).collect(), mirrored, is_changed }
    }
}

fn view_of_pair(pair: &Pair) -> PairView {
    let Content { name, note, points: [source, target], status, confidence } = pair.content.clone();
    PairView {
        id: pair.id,
        number: pair.number,
        colour: (pair.id - 1) % COLOURS,
        name,
        note,
        source,
        target,
        status,
        confidence,
        origin: pair.origin,
        revision: pair.revision(),
    }
}
