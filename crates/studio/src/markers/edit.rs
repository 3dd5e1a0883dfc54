//! Edits: what pages ask for, and what became of it.

use serde::{Deserialize, Serialize};

use super::pair::{Point, Side, Status};

/// Operations that are done together, and are one step of undo.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Edit {
    /// The project that the page shows; left out, that of the server.
    #[serde(default)]
    pub project: Option<u64>,
    /// The revision that the page saw when the user did it.
    pub base: u64,
    /// Any text that no other edit has; an edit that is sent twice is done once.
    pub id: String,
    /// Any text that no other page has; changes of one page do not conflict with each other.
    #[serde(default)]
    pub client: String,
    /// The operations, in order.
    pub ops: Vec<Op>,
}

/// An operation on the document.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "op", rename_all = "lowercase", deny_unknown_fields)]
pub enum Op {
    /// Adds a confirmed pair.
    Add {
        /// Its name.
        #[serde(default)]
        name: Option<String>,
        /// A remark.
        #[serde(default)]
        note: Option<String>,
        /// Its point of the source.
        #[serde(default)]
        source: Option<Point>,
        /// Its point of the target.
        #[serde(default)]
        target: Option<Point>,
    },
    /// Sets or takes away the point of one side.
    Move {
        /// The pair.
        pair: u64,
        /// The side.
        side: Side,
        /// The point.
        point: Option<Point>,
    },
    /// Sets or takes away the name.
    Rename {
        /// The pair.
        pair: u64,
        /// The name.
        name: Option<String>,
    },
    /// Sets or takes away the remark.
    Note {
        /// The pair.
        pair: u64,
        /// The remark.
        note: Option<String>,
    },
    /// Confirms, doubts or skips a pair.
    Status {
        /// The pair.
        pair: u64,
        /// The status.
        status: Status,
    },
    /// Removes a pair.
    Delete {
        /// The pair.
        pair: u64,
    },
    /// Moves a pair to another place in the order.
    Reorder {
        /// The pair.
        pair: u64,
        /// The pair that it comes before; `None` for the end.
        before: Option<u64>,
    },
    /// Adds the partners that are missing across a plane.
    Mirror {
        /// The axis across which the plane lies.
        axis: Axis,
        /// The pair whose partner is added, also if it is only proposed; all that are confirmed if left out.
        #[serde(default)]
        pair: Option<u64>,
        /// Where the plane of the source crosses the axis; its middle if left out.
        #[serde(default)]
        source_offset: Option<f64>,
        /// The same of the target.
        #[serde(default)]
        target_offset: Option<f64>,
    },
}

/// An axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Axis {
    /// The first.
    X,
    /// The second.
    Y,
    /// The third.
    Z,
}

/// What became of the operations of an edit.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EditResult {
    /// For each `add` the new pair; `None` where it was refused.
    pub added: Vec<Option<u64>>,
    /// The operations that were not done.
    pub conflicts: Vec<Conflict>,
    /// What the last `mirror` did.
    pub mirrored: Option<Mirrored>,
}

/// An operation that was not done.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Conflict {
    /// Its place in the edit.
    pub op: usize,
    /// The pair that it is about.
    pub pair: Option<u64>,
    /// Why it was not done.
    pub reason: String,
}

/// What a `mirror` did.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Mirrored {
    /// How many pairs it added.
    pub added: usize,
    /// The pairs that got no partner.
    pub left: Vec<Left>,
}

/// A pair that got no partner.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Left {
    /// The pair.
    pub pair: u64,
    /// The reason.
    pub reason: String,
}
