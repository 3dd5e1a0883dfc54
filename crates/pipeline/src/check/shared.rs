//! Meshes that several runs of one file have in common, read once.

use std::{collections::HashMap, sync::Arc};

use mimesh_document::{Diagnostic, Document, Step, path};
use serde_json::Value;

use super::{
    findings::{Findings, Scope},
    poses,
    seams::{self, SeamCache},
};
use crate::{
    choices::Choice,
    input::{InputFile, PoseInput, RestMesh},
    pose_files::Poses,
    spec::{Source, Target},
};

/// A source and its poses, as far as they can be had.
type SourceMesh = (Option<Arc<RestMesh>>, Vec<PoseInput>, Option<Poses>);

/// The meshes of several runs of one file, by what the document declares of them.
#[derive(Debug, Default)]
pub(super) struct SharedMeshes {
    sources: HashMap<String, Read<SourceMesh>>,
    targets: HashMap<String, Read<Option<Arc<RestMesh>>>>,
}

/// What was read, with the findings on the way.
#[derive(Clone, Debug)]
struct Read<T> {
    value: T,
    inputs: Vec<InputFile>,
    diagnostics: Vec<Diagnostic>,
    warnings: Vec<String>,
    choices: Vec<Choice>,
}

impl SharedMeshes {
    /// The source and its poses, as far as they can be had.
    ///
    /// Poses that are chosen for it are put into `source`.
    pub fn source(
        &mut self,
        scope: Scope<'_>,
        found: &mut Findings,
        source: &mut Source,
        by: SeamCache<'_>,
    ) -> (Option<Arc<RestMesh>>, Vec<PoseInput>) {
        let (mesh, poses, chosen) = once(&mut self.sources, scope, found, "source", |found| {
            let chosen = poses::source(scope, found, source, by);
            (chosen.0.map(Arc::new), chosen.1, chosen.2)
        });
        source.poses = source.poses.take().or(chosen);
        (mesh, poses)
    }

    /// The target, as far as it can be had.
    pub fn target(&mut self, scope: Scope<'_>, found: &mut Findings, target: &Target) -> Option<Arc<RestMesh>> {
        once(&mut self.targets, scope, found, "target", |found| seams::target(scope, found, target).map(Arc::new))
    }
}

/// Reads what the slot declares, or takes what was read for the same values in the same folders.
fn once<T: Clone>(
    known: &mut HashMap<String, Read<T>>,
    scope: Scope<'_>,
    found: &mut Findings,
    slot: &str,
    read: impl FnOnce(&mut Findings) -> T,
) -> T {
    let key = format!("{} {}", declared(scope.document, slot), declared(scope.document, "formats"));
    let read = known.entry(key).or_insert_with(|| {
        let mut own = Findings::default();
        let value = read(&mut own);
        Read {
            value,
            inputs: own.inputs,
            diagnostics: own.diagnostics.list,
            warnings: own.warnings,
            choices: own.choices,
        }
    });
    found.inputs.extend(read.inputs.iter().cloned());
    found.diagnostics.extend(read.diagnostics.iter().cloned());
    found.warnings.extend(read.warnings.iter().cloned());
    found.choices.extend(read.choices.iter().cloned());
    read.value.clone()
}

/// The value of a slot, and the folders that the paths in it are relative to.
fn declared(document: &Document, slot: &str) -> String {
    let at = path([slot]);
    let leaves = leaves(document.get(&at), at);
    let folders: Vec<_> = leaves.into_iter().map(|at| document.folder(&at).clone()).collect();
    format!("{:?} {folders:?}", document.value.get(slot).map(ToString::to_string))
}

/// The paths of all values within `value` that have no entries.
fn leaves(value: Option<&Value>, at: Vec<Step>) -> Vec<Vec<Step>> {
    let below = |step: Step, value: &Value| leaves(Some(value), [&at[..], &[step]].concat());
    match value {
        Some(Value::Object(map)) => map.iter().flat_map(|(key, value)| below(Step::Key(key.clone()), value)).collect(),
        Some(Value::Array(list)) => {
            list.iter().enumerate().flat_map(|(i, value)| below(Step::Index(i), value)).collect()
        }
        _ => vec![at],
    }
}
