//! Doing operations, and what they conflict with.

use std::sync::Arc;

use mimesh_markers::{MarkerMesh, Outcome, Plane, indices, mirror};

use super::{
    document::{MAX_PAIRS, MarkerDocument},
    edit::{Axis, Conflict, Edit, EditResult, Left, Mirrored, Op},
    file,
    pair::{Aspect, Change, Content, Origin, Pair, Point, Side, Status},
};

/// The most characters of a name and of a remark.
const MAX_NAME: usize = 200;
const MAX_NOTE: usize = 2_000;

/// Why an operation is not done.
type Refusal = String;

/// What operations of one edit have in common.
struct Context<'a> {
    base: u64,
    change: Change,
    meshes: [MarkerMesh<'a>; 2],
    /// The pairs before the edit.
    before: &'a [Arc<Pair>],
}

impl MarkerDocument {
    /// Does all operations of `edit` that do not conflict; they belong to the revision that comes next. `before` are the pairs as they are.
    pub(super) fn apply(&mut self, edit: &Edit, meshes: [MarkerMesh<'_>; 2], before: &[Arc<Pair>]) -> EditResult {
        let change = Change { revision: self.revision + 1, client: edit.client.as_str().into() };
        let context = Context { base: edit.base, change, meshes, before };
        let mut result = EditResult::default();
        for (op, i) in edit.ops.iter().zip(0..) {
            let done = self.one(op, &context, &mut result);
            if matches!(op, Op::Add { .. }) && done.is_err() {
                result.added.push(None);
            }
            if let Err(reason) = done {
                result.conflicts.push(Conflict { op: i, pair: pair_of(op), reason });
            }
        }
        result
    }

    fn one(&mut self, op: &Op, context: &Context<'_>, result: &mut EditResult) -> Result<(), Refusal> {
        match op {
            Op::Add { name, note, source, target } => {
                let id = self.add(name, note, [*source, *target], context)?;
                result.added.push(Some(id));
            }
            Op::Move { pair, side, point } => self.set_point(*pair, *side, *point, context)?,
            Op::Rename { pair, name } => {
                let name = self.checked_name(name.as_deref(), Some(*pair))?;
                self.set(*pair, Aspect::Name, context, |content| content.name = name)?;
            }
            Op::Note { pair, note } => {
                let note = checked_text(note.as_deref(), MAX_NOTE)?;
                self.set(*pair, Aspect::Note, context, |content| content.note = note)?;
            }
            Op::Status { pair, status } => {
                self.set(*pair, Aspect::Status, context, |content| content.status = *status)?;
            }
            Op::Delete { pair } => self.delete(*pair, context)?,
            Op::Reorder { pair, before } => self.reorder(*pair, *before)?,
            Op::Mirror { axis, pair, source_offset, target_offset } => {
                result.mirrored = Some(self.mirror(*axis, *pair, [*source_offset, *target_offset], context)?);
            }
        }
        Ok(())
    }

    fn add(
        &mut self,
        name: &Option<String>,
        note: &Option<String>,
        points: [Option<Point>; 2],
        context: &Context<'_>,
    ) -> Result<u64, Refusal> {
        if self.pairs.len() >= MAX_PAIRS {
            return Err(format!("there are {MAX_PAIRS} pairs, the most that a document takes"));
        }
        if points == [None, None] {
            return Err("a pair needs a point on one of the meshes at least".into());
        }
        let [source, target] = points;
        let points = [checked_point(source, context.meshes[0])?, checked_point(target, context.meshes[1])?];
        let name = self.checked_name(name.as_deref(), None)?;
        let content = Content { name, note: checked_text(note.as_deref(), MAX_NOTE)?, points, ..Content::default() };
        let pair = self.new_pair(content, Origin::User, &context.change);
        let id = pair.id;
        self.pairs.push(pair);
        Ok(id)
    }

    /// A person who moves a point of a proposal stands for the pair.
    fn set_point(&mut self, id: u64, side: Side, point: Option<Point>, context: &Context<'_>) -> Result<(), Refusal> {
        let point = checked_point(point, context.meshes[side.index()])?;
        let pair = &self.pairs[self.find(id)?];
        if point.is_none() && pair.content.points[1 - side.index()].is_none() {
            return Err("a pair needs a point on one of the meshes at least; delete it instead".into());
        }
        let is_confirmed = pair.content.status == Status::Proposed && pair.content.points[side.index()] != point;
        self.set(id, side.aspect(), context, |content| content.points[side.index()] = point)?;
        if is_confirmed {
            let i = self.find(id)?;
            let pair = Arc::make_mut(&mut self.pairs[i]);
            pair.content.status = Status::Confirmed;
            pair.changes[Aspect::Status as usize] = context.change.clone();
        }
        Ok(())
    }

    /// Changes an aspect of a pair, unless somebody else changed it after the page saw it.
    fn set(
        &mut self,
        id: u64,
        aspect: Aspect,
        context: &Context<'_>,
        change: impl FnOnce(&mut Content),
    ) -> Result<(), Refusal> {
        let i = self.find(id)?;
        let mut content = self.pairs[i].content.clone();
        change(&mut content);
        if content == self.pairs[i].content {
            return Ok(());
        }
        if context.is_newer(id, aspect) {
            return Err(format!("{} was changed in the meantime", what(aspect)));
        }
        let pair = Arc::make_mut(&mut self.pairs[i]);
        pair.content = content;
        pair.changes[aspect as usize] = context.change.clone();
        Ok(())
    }

    /// A pair that somebody else changed in the meantime is not deleted: that change would be lost.
    fn delete(&mut self, id: u64, context: &Context<'_>) -> Result<(), Refusal> {
        let Some(i) = self.position(id) else {
            return if id < self.next_id { Ok(()) } else { self.find(id).map(|_| ()) };
        };
        if Aspect::ALL.into_iter().any(|aspect| context.is_newer(id, aspect)) {
            return Err("the pair was changed in the meantime".into());
        }
        self.pairs.remove(i);
        Ok(())
    }

    fn reorder(&mut self, id: u64, before: Option<u64>) -> Result<(), Refusal> {
        if before == Some(id) {
            return Ok(());
        }
        let i = self.find(id)?;
        before.map_or(Ok(0), |before| self.find(before))?;
        let pair = self.pairs.remove(i);
        let place = before.and_then(|before| self.position(before)).unwrap_or(self.pairs.len());
        self.pairs.insert(place, pair);
        Ok(())
    }

    /// Adds partners across a plane: that of `only`, or of all pairs.
    fn mirror(
        &mut self,
        axis: Axis,
        only: Option<u64>,
        offsets: [Option<f64>; 2],
        context: &Context<'_>,
    ) -> Result<Mirrored, Refusal> {
        if offsets.into_iter().flatten().any(|offset| !offset.is_finite()) {
            return Err("the place of the plane is not finite".into());
        }
        let used = self.usable(context.meshes);
        let markers = file::of_pairs(used.iter().map(|&i| &*self.pairs[i]), context.meshes);
        let planes = [0, 1].map(|k: usize| {
            let middle = Plane::middle(context.meshes[k], axis as usize);
            offsets[k].map_or(middle, |offset| Plane { offset, ..middle })
        });
        let done = mirror(&markers, context.meshes, planes).map_err(|failure| failure.to_string())?;
        let (mut mirrored, mut added_count) = (Mirrored::default(), 0);
        let mut left = |pair: u64, reason: &str| mirrored.left.push(Left { pair, reason: reason.into() });
        if let Some(pair) = only.filter(|pair| used.iter().all(|&i| self.pairs[i].id != *pair)) {
            left(pair, "it has no point on one of the meshes, or is skipped");
        }
        for (outcome, &i) in done.outcomes.into_iter().zip(&used) {
            let of = self.pairs[i].clone();
            if only.is_some_and(|only| only != of.id) {
                continue;
            }
            match outcome {
                // The stage that found it looked for its partner too, whose place is near the image and not on it.
                Outcome::Added(..) if only.is_none() && of.content.status == Status::Proposed => {
                    left(of.id, "it is only proposed: confirm it first");
                }
                Outcome::Added(..) if self.pairs.len() >= MAX_PAIRS => {
                    left(of.id, &format!("there are {MAX_PAIRS} pairs, the most that a document takes"));
                }
                Outcome::Added(at, _) => {
                    let added = file::content(&done.markers.pairs[at]);
                    let name = self.checked_name(added.name.as_deref(), None).unwrap_or_default();
                    let pair = self.new_pair(Content { name, ..added }, Origin::Mirrored, &context.change);
                    self.pairs.push(pair);
                    added_count += 1;
                }
                Outcome::Left(reason) => left(of.id, &reason),
                Outcome::OnPlane if only.is_some() => left(of.id, "it lies on the plane"),
                Outcome::Partner(_) if only.is_some() => left(of.id, "its partner is there already"),
                Outcome::OnPlane | Outcome::Partner(_) => {}
            }
        }
        mirrored.added = added_count;
        Ok(mirrored)
    }

    fn find(&self, id: u64) -> Result<usize, Refusal> {
        self.position(id).ok_or_else(|| match id < self.next_id {
            true => "the pair was deleted in the meantime".into(),
            false => format!("there is no pair {id}"),
        })
    }

    /// The name as it is kept; `None` for an empty one.
    fn checked_name(&self, name: Option<&str>, of: Option<u64>) -> Result<Option<String>, Refusal> {
        let name = checked_text(name, MAX_NAME)?;
        let taken = name.is_some() && self.pairs.iter().any(|pair| Some(pair.id) != of && pair.content.name == name);
        if taken { Err(format!("another pair is called {}", name.unwrap_or_default())) } else { Ok(name) }
    }

    /// What an edit does, in words for the user.
    pub(super) fn title(&self, ops: &[Op]) -> String {
        let Some(first) = ops.first() else { return String::new() };
        let label = |id: &u64| self.position(*id).map_or_else(|| "a pair".into(), |i| self.pairs[i].title());
        let title = match first {
            Op::Add { name, .. } => format!("add {}", name.as_deref().unwrap_or("a pair")),
            Op::Move { pair, point: Some(_), .. } => format!("move {}", label(pair)),
            Op::Move { pair, side, point: None } => format!("take away the {} of {}", side.role(), label(pair)),
            Op::Rename { pair, .. } => format!("rename {}", label(pair)),
            Op::Note { pair, .. } => format!("note on {}", label(pair)),
            Op::Status { pair, status: Status::Confirmed } => format!("confirm {}", label(pair)),
            Op::Status { pair, status: Status::Proposed } => format!("doubt {}", label(pair)),
            Op::Status { pair, status: Status::Skipped } => format!("skip {}", label(pair)),
            Op::Delete { pair } => format!("delete {}", label(pair)),
            Op::Reorder { pair, .. } => format!("reorder {}", label(pair)),
            Op::Mirror { .. } => "mirror".into(),
        };
        if ops.len() > 1 { format!("{title} and {} more", ops.len() - 1) } else { title }
    }
}

impl Context<'_> {
    /// Whether somebody else changed this after the page saw the document; what the edit itself did does not count.
    fn is_newer(&self, id: u64, aspect: Aspect) -> bool {
        let pair = self.before.iter().find(|pair| pair.id == id);
        let change = pair.map(|pair| &pair.changes[aspect as usize]);
        change.is_some_and(|change| change.revision > self.base && !self.is_own(change))
    }

    fn is_own(&self, change: &Change) -> bool {
        !self.change.client.is_empty() && change.client == self.change.client
    }
}

fn pair_of(op: &Op) -> Option<u64> {
    match op {
        Op::Add { .. } | Op::Mirror { .. } => None,
        Op::Move { pair, .. }
        | Op::Rename { pair, .. }
        | Op::Note { pair, .. }
        | Op::Status { pair, .. }
        | Op::Delete { pair }
        | Op::Reorder { pair, .. } => Some(*pair),
    }
}

fn what(aspect: Aspect) -> &'static str {
    match aspect {
        Aspect::Source => "its point on the source",
        Aspect::Target => "its point on the target",
        Aspect::Name => "its name",
        Aspect::Note => "its note",
        Aspect::Status => "its status",
    }
}

fn checked_point(point: Option<Point>, mesh: MarkerMesh<'_>) -> Result<Option<Point>, Refusal> {
    let Some(point) = point else { return Ok(None) };
    let point = point.normalised()?;
    indices::missing(mesh, point.into()).map_or(Ok(Some(point)), Err)
}

/// A text as it is kept: without blanks around it, `None` if it is empty.
fn checked_text(text: Option<&str>, most: usize) -> Result<Option<String>, Refusal> {
    let text = text.unwrap_or_default().trim();
    // Characters for private use may be those by which YAML texts are guarded.
    if text.chars().any(|c| c.is_control() || ('\u{e000}'..='\u{f8ff}').contains(&c)) {
        return Err("a text with characters that are not to be seen".into());
    }
    if text.chars().count() > most {
        return Err(format!("a text of more than {most} characters"));
    }
    Ok(Some(text.to_owned()).filter(|text| !text.is_empty()))
}
