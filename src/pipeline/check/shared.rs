use std::{collections::HashMap, sync::Arc};

use super::{Check, Input, PoseInput, Side};
use crate::{
    diagnostic::Diagnostic,
    pipeline::{Source, Step, Target, document::path},
};

/// A source and its poses, as far as they can be had.
type SourceRead = (Option<Arc<Side>>, Vec<PoseInput>);

/// What several runs of one file have in common, read once.
#[derive(Debug, Default)]
pub(super) struct Shared {
    sources: HashMap<String, Read<SourceRead>>,
    targets: HashMap<String, Read<Option<Arc<Side>>>>,
}

/// What was read, and what was found while reading.
#[derive(Clone, Debug)]
struct Read<T> {
    value: T,
    inputs: Vec<Input>,
    diagnostics: Vec<Diagnostic>,
    warnings: Vec<String>,
}

impl Shared {
    /// The source and its poses, as far as they can be had.
    pub(super) fn source(&mut self, check: &mut Check<'_>, source: &Source) -> SourceRead {
        let read = |check: &mut Check<'_>| {
            let (side, poses) = check.source(source);
            (side.map(Arc::new), poses)
        };
        once(&mut self.sources, check, "source", read)
    }

    /// The target, as far as it can be had.
    pub(super) fn target(&mut self, check: &mut Check<'_>, target: &Target) -> Option<Arc<Side>> {
        once(&mut self.targets, check, "target", |check| check.target(target).map(Arc::new))
    }
}

/// Reads what the slot declares, or takes what was read for the same words in the same folders.
fn once<T: Clone>(
    known: &mut HashMap<String, Read<T>>,
    check: &mut Check<'_>,
    slot: &str,
    read: impl FnOnce(&mut Check<'_>) -> T,
) -> T {
    let declared = |slot: &str| {
        let at = path([slot]);
        let folders = leaves(check.document.get(&at), at).into_iter().map(|at| check.document.folder(&at).clone());
        let value = check.document.value.get(slot).map(ToString::to_string);
        format!("{value:?} {:?}", folders.collect::<Vec<_>>())
    };
    let key = format!("{} {}", declared(slot), declared("formats"));
    if let Some(found) = known.get(&key) {
        let found = found.clone();
        check.inputs.extend(found.inputs);
        check.diagnostics.extend(found.diagnostics);
        check.warnings.extend(found.warnings);
        return found.value;
    }
    let before = (check.inputs.len(), check.diagnostics.len(), check.warnings.len());
    let value = read(check);
    let found = Read {
        value: value.clone(),
        inputs: check.inputs[before.0..].to_vec(),
        diagnostics: check.diagnostics[before.1..].to_vec(),
        warnings: check.warnings[before.2..].to_vec(),
    };
    known.insert(key, found);
    value
}

/// The paths of all values within `value` that have no parts.
fn leaves(value: Option<&serde_json::Value>, at: Vec<Step>) -> Vec<Vec<Step>> {
    match value {
        Some(serde_json::Value::Object(map)) => {
            let below = |(key, value)| leaves(Some(value), [&at[..], &[Step::Key(String::clone(key))]].concat());
            map.iter().flat_map(below).collect()
        }
        Some(serde_json::Value::Array(list)) => {
            let below = |(i, value)| leaves(Some(value), [&at[..], &[Step::Index(i)]].concat());
            list.iter().enumerate().flat_map(below).collect()
        }
        _ => vec![at],
    }
}
