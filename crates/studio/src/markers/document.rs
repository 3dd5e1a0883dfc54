//! The document: pairs, a revision, and a history.

use std::{
    collections::{HashMap, HashSet, VecDeque},
    sync::Arc,
};

use mimesh_markers::{MarkerMesh, indices};

use super::{
    edit::{Conflict, Edit, EditResult},
    history::History,
    pair::{Aspect, Change, Content, Origin, Pair, Point, Side, Status},
};
use crate::error::{ApiError, Result};

/// The most pairs of a document.
pub const MAX_PAIRS: usize = 10_000;

/// The most operations of an edit.
const MAX_OPS: usize = 1_000;

/// How many edits are remembered, so that one that is sent again is not done again.
const REMEMBERED: usize = 1_000;

/// Pairs with a revision and a history; it knows no file.
#[derive(Clone, Debug)]
pub struct MarkerDocument {
    /// Rises with every change.
    pub(super) revision: u64,
    /// The pairs, in the order of the file.
    pub(super) pairs: Vec<Arc<Pair>>,
    /// The id of the next pair.
    pub(super) next_id: u64,
    /// The number of the next pair.
    pub(super) next_number: usize,
    pub(super) history: History,
    /// The last edits with what became of them.
    done: HashMap<String, EditResult>,
    order: VecDeque<String>,
}

impl MarkerDocument {
    /// A document with these pairs, at revision 1 and without a history.
    pub fn new(pairs: impl IntoIterator<Item = (Content, Origin)>) -> Self {
        let mut document = Self {
            revision: 1,
            pairs: vec![],
            next_id: 1,
            next_number: 1,
            history: History::default(),
            done: HashMap::new(),
            order: VecDeque::new(),
        };
        for (content, origin) in pairs {
            let pair = document.new_pair(content, origin, &Change { revision: 1, client: "".into() });
            document.pairs.push(pair);
        }
        document
    }

    /// The revision.
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// The pairs, in the order of the file.
    pub fn pairs(&self) -> &[Arc<Pair>] {
        &self.pairs
    }

    /// The history.
    pub fn history(&self) -> &History {
        &self.history
    }

    /// The place of the pair `id`.
    pub fn position(&self, id: u64) -> Option<usize> {
        self.pairs.iter().position(|pair| pair.id == id)
    }

    /// Does the operations of `edit` that do not conflict; one that was done before is not done again.
    ///
    /// # Errors
    ///
    /// For an edit that makes no sense as a whole; then nothing is done.
    pub fn edit(&mut self, edit: &Edit, meshes: [MarkerMesh<'_>; 2]) -> Result<EditResult> {
        if let Some(done) = self.done.get(&edit.id) {
            return Ok(done.clone());
        }
        if edit.base > self.revision {
            let message = format!("the edit is based on revision {}, the document is at {}", edit.base, self.revision);
            return Err(ApiError::bad(message).hint("fetch the markers again"));
        }
        if edit.ops.len() > MAX_OPS || edit.id.is_empty() || edit.id.len() > 100 || edit.client.len() > 100 {
            let message = format!("expected at most {MAX_OPS} operations, and an id and a client of at most 100 bytes");
            return Err(ApiError::bad(message));
        }
        let before = self.pairs.clone();
        let title = self.title(&edit.ops);
        let result = self.apply(edit, meshes, &before);
        self.commit(before, title);
        self.remember(&edit.id, result.clone());
        Ok(result)
    }

    /// Takes back the last step.
    ///
    /// # Errors
    ///
    /// A conflict if there is none, or if the document is not at `base` any more.
    pub fn undo(&mut self, base: u64) -> std::result::Result<(), Conflict> {
        self.check_base(base)?;
        let step = self.history.back().ok_or_else(|| conflict("there is nothing to undo"))?;
        self.restore(&step.before);
        Ok(())
    }

    /// Does again what was taken back last.
    ///
    /// # Errors
    ///
    /// As [`undo`](Self::undo).
    pub fn redo(&mut self, base: u64) -> std::result::Result<(), Conflict> {
        self.check_base(base)?;
        let step = self.history.forward().ok_or_else(|| conflict("there is nothing to redo"))?;
        self.restore(&step.after);
        Ok(())
    }

    fn check_base(&self, base: u64) -> std::result::Result<(), Conflict> {
        if base == self.revision { Ok(()) } else { Err(conflict("the markers have changed in the meantime")) }
    }

    /// Brings back `pairs`; those that differ are changed by the revision that comes of it.
    fn restore(&mut self, pairs: &[Arc<Pair>]) {
        let now: HashMap<u64, Arc<Pair>> = self.pairs.iter().map(|pair| (pair.id, pair.clone())).collect();
        self.revision += 1;
        let change = Change { revision: self.revision, client: "".into() };
        let restored = pairs.iter().map(|pair| {
            let aspects = match now.get(&pair.id) {
                Some(other) => other.content.differences(&pair.content),
                None => Aspect::ALL.to_vec(),
            };
            // What others changed since then stays changed, so that edits on older revisions still conflict.
            let mut pair = Pair { changes: now.get(&pair.id).unwrap_or(pair).changes.clone(), ..(**pair).clone() };
            aspects.into_iter().for_each(|aspect| pair.changes[aspect as usize] = change.clone());
            Arc::new(pair)
        });
        self.pairs = restored.collect();
        self.next_number = self.next_number.max(self.largest_number() + 1);
    }

    /// The largest number of a pair.
    pub(super) fn largest_number(&self) -> usize {
        self.pairs.iter().map(|pair| pair.number).max().unwrap_or_default()
    }

    /// Forgets what was taken back; whether there was any.
    pub fn forget_redo(&mut self) -> bool {
        self.history.forget_redo()
    }

    /// Makes the present pairs a new revision and a step of undo, unless they are those of `before`.
    ///
    /// What an edit changes and changes back has not changed, so it keeps the revision that it had.
    pub(super) fn commit(&mut self, before: Vec<Arc<Pair>>, title: String) -> bool {
        if same(&self.pairs, &before) {
            self.pairs = before;
            return false;
        }
        self.keep_unchanged(&before);
        self.revision += 1;
        self.history.push(title, before, self.pairs.clone());
        true
    }

    /// Gives each aspect that is as in `before` the change that it had there.
    fn keep_unchanged(&mut self, before: &[Arc<Pair>]) {
        let was: HashMap<u64, &Arc<Pair>> = before.iter().map(|pair| (pair.id, pair)).collect();
        for pair in &mut self.pairs {
            let Some(old) = was.get(&pair.id).filter(|old| !Arc::ptr_eq(old, pair)) else { continue };
            let differences = old.content.differences(&pair.content);
            let pair = Arc::make_mut(pair);
            for aspect in Aspect::ALL.into_iter().filter(|aspect| !differences.contains(aspect)) {
                pair.changes[aspect as usize] = old.changes[aspect as usize].clone();
            }
        }
    }

    fn remember(&mut self, id: &str, result: EditResult) {
        self.done.insert(id.into(), result);
        self.order.push_back(id.into());
        if self.order.len() > REMEMBERED
            && let Some(oldest) = self.order.pop_front()
        {
            self.done.remove(&oldest);
        }
    }

    /// A pair with an id and a number of its own.
    pub(super) fn new_pair(&mut self, content: Content, origin: Origin, change: &Change) -> Arc<Pair> {
        let id = self.next_id;
        self.next_id += 1;
        let number = self.next_number;
        self.next_number += 1;
        Arc::new(Pair { id, number, content, origin, changes: std::array::from_fn(|_| change.clone()) })
    }

    /// The pairs that no stage can use as they are, each with the side and the reason.
    pub fn problems(&self, meshes: [MarkerMesh<'_>; 2]) -> Vec<(u64, Side, String)> {
        let mut problems = Vec::new();
        for (side, mesh) in [Side::Source, Side::Target].into_iter().zip(meshes) {
            let mut seen = HashMap::new();
            for pair in &self.pairs {
                let Some(point) = pair.content.points[side.index()] else { continue };
                if let Some(message) = indices::missing(mesh, point.into()) {
                    problems.push((pair.id, side, message));
                } else if pair.content.status != Status::Skipped
                    && let Some(key) = place(mesh, point)
                    && let Some(other) = seen.insert(key, pair.title())
                {
                    let message = format!("lies on the same point of the {} as {other}", mesh.role);
                    problems.push((pair.id, side, message));
                }
            }
        }
        problems
    }

    /// The places of the pairs that stages can use: complete, not skipped, on the meshes, and none where another lies.
    pub fn usable(&self, meshes: [MarkerMesh<'_>; 2]) -> Vec<usize> {
        let wrong: HashSet<u64> = self.problems(meshes).into_iter().map(|(pair, ..)| pair).collect();
        let is_usable = |i: &usize| {
            let Pair { id, content, .. } = &*self.pairs[*i];
            content.status != Status::Skipped && content.points.iter().all(Option::is_some) && !wrong.contains(id)
        };
        (0..self.pairs.len()).filter(is_usable).collect()
    }
}

/// The position of a point, to compare.
fn place(mesh: MarkerMesh<'_>, point: Point) -> Option<[u64; 3]> {
    let at = mesh.position(point.into())?;
    // Adding 0 makes a positive zero of a negative one.
    Some([at.x, at.y, at.z].map(|x| (x + 0.0).to_bits()))
}

/// Whether both lists have the same pairs with the same contents in the same order.
pub(super) fn same(a: &[Arc<Pair>], b: &[Arc<Pair>]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.id == b.id && a.content == b.content)
}

fn conflict(reason: &str) -> Conflict {
    Conflict { op: 0, pair: None, reason: reason.into() }
}
