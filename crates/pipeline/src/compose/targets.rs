//! `targets`: several meshes in place of `target`, each with what differs for it.

use std::collections::HashMap;

use mimesh_document::{
    At, Document, Step, describe,
    diagnostic::Diagnostics,
    merge::merge_into,
    path,
    source_tree::{SpanEntry, SpanTree},
    suggest::did_you_mean,
};
use serde_json::{Map, Value};

use crate::{compose::names::refused, parse::slots as pipeline_slots, schema::SchemaNode};

/// The keys that give the mesh of a target.
pub(super) const MESH: [&str; 2] = ["rest", "generator"];

/// A target with what differs for it.
#[derive(Debug)]
pub(super) struct OneTarget {
    /// Its name.
    pub name: String,
    /// What is laid over the pipeline.
    own: Document,
}

impl OneTarget {
    /// The pipeline for this target alone.
    pub(super) fn of(&self, whole: &Document) -> Document {
        let mut result = whole.clone();
        merge_into(&mut result, self.own.clone());
        result
    }
}

/// Takes `targets` out of the pipeline; `None` if it has none.
pub(super) fn take(document: &mut Document, diagnostics: &mut Diagnostics) -> Option<Vec<OneTarget>> {
    let at = path(["targets"]);
    let value = document.get(&at)?;
    let Some(map) = value.as_object().filter(|map| !map.is_empty()) else {
        let message = format!("`targets`: expected a mapping of names and meshes, found {}", empty_or(value));
        let hint = "e.g. `targets: { camel: { rest: camel.obj }, giraffe: { rest: giraffe.obj } }`";
        diagnostics.push(document.diagnostic(&at, At::Value, message).hint(hint));
        document.take("targets");
        return Some(vec![]);
    };
    // Over one that is included stands `target: ~`.
    if document.get(&path(["target"])).is_some_and(|target| !target.is_null()) {
        let hint = "name it among the targets and remove `target`; over one that is included write `target: ~`";
        diagnostics.push(document.diagnostic(&path(["target"]), At::Key, "`target` beside `targets`").hint(hint));
    }
    let mut targets = Vec::new();
    let mut by_letters: HashMap<String, &String> = HashMap::new();
    for (name, entry) in map {
        let at = [&at[..], &[Step::Key(name.clone())]].concat();
        if let Some(problem) = refused(name) {
            let hint = "it becomes a part of the names of results: letters, digits, `-` and `_` do everywhere";
            diagnostics.push(
                document.diagnostic(&at, At::Key, format!("`{name}` cannot name a target: {problem}")).hint(hint),
            );
        }
        if let Some(other) = by_letters.insert(name.to_lowercase(), name) {
            let message = format!(
                "`{other}` and `{name}` differ in capitals alone, and Windows and macOS take them for one name"
            );
            diagnostics.push(document.diagnostic(&at, At::Key, message).hint("give one of the two another name"));
        }
        match entry {
            Value::Object(entry) => {
                targets.push(OneTarget { name: name.clone(), own: own(document, &at, entry, diagnostics) });
            }
            other => {
                let message = format!("`{name}`: expected a mapping with a mesh, found {}", describe(other));
                diagnostics.push(
                    document.diagnostic(&at, At::Value, message).hint(format!("e.g. `{name}: {{ rest: mesh.obj }}`")),
                );
            }
        }
    }
    document.take("targets");
    document.take("target");
    Some(targets)
}

/// What an entry says, as a pipeline: the mesh under `target`, the rest as it is.
fn own(document: &Document, at: &[Step], entry: &Map<String, Value>, diagnostics: &mut Diagnostics) -> Document {
    let of_mesh = SchemaNode::pipeline().entry(&Step::Key("target".into()), None).map(|node| node.properties(None));
    let of_mesh: Vec<&str> = of_mesh.unwrap_or_default().into_iter().map(|(key, _)| key).collect();
    let slots = pipeline_slots().into_iter().filter(|slot| *slot != "target").chain(["variables"]);
    let known: Vec<&str> = of_mesh.iter().copied().chain(slots).collect();
    let span = document.span(at, At::Value).clone();
    let folder = document.folder(at).clone();
    let whole = SpanTree::leaf(span.clone(), folder.clone());
    // Settings of the whole are no settings of the entry, so its place is theirs only where they are its own.
    let mut root = SpanTree::leaf(document.root.span.clone(), document.root.folder.clone());
    let (mut mesh, mut mesh_node, mut slots) = (Map::new(), whole, Map::new());
    for (key, value) in entry {
        let at = [at, &[Step::Key(key.clone())]].concat();
        let step = Step::Key(key.clone());
        let part = SpanEntry { step, key: document.span(&at, At::Key).clone(), node: node_at(document, &at) };
        if of_mesh.contains(&key.as_str()) {
            mesh_node.put(part);
            mesh.insert(key.clone(), value.clone());
        } else if known.contains(&key.as_str()) {
            root.put(part);
            slots.insert(key.clone(), value.clone());
        } else {
            let hint = did_you_mean(key, &known).unwrap_or_else(|| format!("known keys: {}", known.join(", ")));
            diagnostics.push(document.diagnostic(&at, At::Key, format!("unknown key `{key}`")).hint(&hint));
        }
    }
    root.put(SpanEntry { step: Step::Key("target".into()), key: document.span(at, At::Key).clone(), node: mesh_node });
    slots.insert("target".into(), Value::Object(mesh));
    Document { file: document.file.clone(), value: Value::Object(slots), root }
}

/// The places of the value at `at`.
pub(super) fn node_at(document: &Document, at: &[Step]) -> SpanTree {
    let mut node = &document.root;
    for step in at {
        match node.part(step) {
            Some(part) => node = &part.node,
            None => return SpanTree::leaf(node.span.clone(), node.folder.clone()),
        }
    }
    node.clone()
}

fn empty_or(value: &Value) -> String {
    if value.as_object().is_some_and(Map::is_empty) { "an empty one".into() } else { describe(value) }
}
