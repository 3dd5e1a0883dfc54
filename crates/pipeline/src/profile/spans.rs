//! What was recorded of spans.

use std::{collections::BTreeMap, time::Duration};

use serde_json::{Map, Value};

use super::frames::{Times, Visit};

/// A place in the tree of spans: all spans of one label whose parents are at one place.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Node {
    /// The place of the parent; `None` at the root.
    pub parent: Option<usize>,
    /// E.g. `correspondence (nonrigid_fit)`.
    pub label: String,
    /// The crate that emits the spans.
    pub target: &'static str,
    /// How many things the spans stand for.
    pub count: u64,
    /// Time that the spans had of their threads.
    pub own: Times,
    /// The part of it on threads that no ancestor was entered on.
    pub apart: Times,
    /// CPU time of the process meanwhile, for stages of which one runs at a time.
    pub process: Option<Duration>,
}

/// A span on its thread.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Slice {
    /// Its place in the tree.
    pub node: usize,
    /// The thread.
    pub thread: u32,
    /// When it was entered.
    pub start: Duration,
    /// From entering to leaving.
    pub whole: Times,
    /// Its other fields.
    pub fields: Option<Box<Map<String, Value>>>,
}

/// All spans so far.
#[derive(Debug, Default)]
pub(super) struct Spans {
    /// The tree; parents come before their children.
    pub nodes: Vec<Node>,
    /// In the order in which they were left.
    pub slices: Vec<Slice>,
    /// The names of threads.
    pub threads: BTreeMap<u32, String>,
    places: BTreeMap<(Option<usize>, String), usize>,
}

impl Spans {
    /// The place of spans with `label` below `parent`.
    pub fn place(&mut self, parent: Option<usize>, label: String, target: &'static str) -> usize {
        let next = self.nodes.len();
        let place = *self.places.entry((parent, label.clone())).or_insert(next);
        if place == next {
            let (own, apart) = Default::default();
            self.nodes.push(Node { parent, label, target, count: 0, own, apart, process: None });
        }
        place
    }

    /// Adds what a span had of a thread.
    pub fn add(&mut self, node: usize, visit: Visit, count: u64, fields: Option<Box<Map<String, Value>>>) {
        let Visit { start, whole, own, is_within, thread } = visit;
        let place = &mut self.nodes[node];
        place.count += count;
        place.own.wall += own.wall;
        place.own.cpu += own.cpu;
        if !is_within {
            place.apart.wall += own.wall;
            place.apart.cpu += own.cpu;
        }
        let name = || std::thread::current().name().map_or_else(|| format!("thread {thread}"), str::to_owned);
        self.threads.entry(thread).or_insert_with(name);
        self.slices.push(Slice { node, thread, start, whole, fields });
    }

    /// Adds CPU time of the process while a stage ran.
    pub fn add_process(&mut self, node: usize, cpu: Duration) {
        *self.nodes[node].process.get_or_insert_default() += cpu;
    }
}
