//! `matrix`: keys to vary with their values, and a run for every combination.

use mimesh_document::{
    At, Document, Step, describe,
    diagnostic::{Diagnostic, Diagnostics, Kind, Location},
    overrides::{put, split},
    path,
    source_tree::SpanEntry,
};
use serde_json::Value;

use crate::{
    compose::{names, targets::node_at},
    schema::{PipelineShapes, is_of_whole_file},
};

/// More runs than this are taken for a slip.
pub(super) const MAX_RUNS: usize = 10_000;

/// Keys that vary at once.
const MAX_KEYS: usize = 64;

/// One key of `matrix` with its values.
#[derive(Debug)]
pub(super) struct Axis {
    /// The key as it is written, e.g. `transfer.deformer.lambda`.
    pub key: String,
    /// Its path.
    pub path: Vec<Step>,
    /// What it is called in names.
    short: String,
    /// The values, where they were written, and what they are called.
    values: Vec<(Value, SpanEntry, String)>,
}

impl Axis {
    /// The place of its key.
    pub fn location(&self) -> Option<Location> {
        self.values.first().map(|(_, at, _)| at.key.location())
    }

    /// Whether its values and those at `path` replace each other.
    pub fn overlaps(&self, path: &[Step]) -> bool {
        path.starts_with(&self.path) || self.path.starts_with(path)
    }
}

/// A value for each key.
#[derive(Clone, Debug, Default)]
pub(super) struct Combination {
    /// The number of the value of each axis.
    picks: Vec<usize>,
    /// Its name, empty without a matrix.
    pub name: String,
    /// Keys and values.
    pub values: Vec<(String, Value)>,
    /// What the values are called.
    pub shown: Vec<String>,
}

/// Takes `matrix` out of the pipeline; `None` if it has none.
pub(super) fn take(document: &mut Document, diagnostics: &mut Diagnostics) -> Option<Vec<Axis>> {
    let at = path(["matrix"]);
    let Some(map) = document.get(&at)?.as_object() else {
        let message =
            format!("`matrix`: expected a mapping of keys and sequences, found {}", describe(document.get(&at)?));
        let hint = "e.g. `matrix: { transfer.deformer.lambda: [0.1, 0.5, 5] }`";
        diagnostics.push(document.diagnostic(&at, At::Value, message).hint(hint));
        document.take("matrix");
        return Some(vec![]);
    };
    let runs =
        map.values().filter_map(Value::as_array).try_fold(1usize, |runs, list| runs.checked_mul(list.len().max(1)));
    let too_many = match runs {
        _ if map.len() > MAX_KEYS => Some(format!("{} keys, expected {MAX_KEYS} at most", map.len())),
        Some(runs) if runs <= MAX_RUNS => None,
        _ => Some(format!("more than {MAX_RUNS} combinations")),
    };
    if let Some(message) = too_many {
        diagnostics.push(document.diagnostic(&at, At::Key, message).hint("vary fewer keys at once, or fewer values"));
        document.take("matrix");
        return Some(vec![]);
    }
    let short = names::short(&map.keys().cloned().collect::<Vec<_>>());
    let mut axes = Vec::new();
    for ((key, value), short) in map.iter().zip(short) {
        let at = [&at[..], &[Step::Key(key.clone())]].concat();
        let mut report = |at: &[Step], point, message: String, hint: &str| {
            diagnostics.push(document.diagnostic(at, point, message).hint(hint));
        };
        let Some(path) = split(key) else {
            report(
                &at,
                At::Key,
                format!("`{key}` is no path of keys"),
                "keys are joined by single dots, e.g. `source.rest`",
            );
            continue;
        };
        if let Some(Step::Key(first)) = path.first()
            && is_of_whole_file(first)
        {
            report(
                &at,
                At::Key,
                format!("`{first}` cannot vary"),
                "a matrix varies the keys of single runs, e.g. `transfer.type`",
            );
            continue;
        }
        let list = match value {
            Value::Array(list) if !list.is_empty() => list,
            Value::Array(_) => {
                report(
                    &at,
                    At::Value,
                    format!("`{key}`: the sequence of values is empty"),
                    "remove the key, or name values",
                );
                continue;
            }
            // Values that are set beside the file may be anything, too.
            other => {
                let hint = format!("put one value into a sequence as well: `{key}: [{}]`", plain(other));
                report(
                    &at,
                    At::Value,
                    format!("`{key}`: expected a sequence of values, found {}", describe(other)),
                    &hint,
                );
                continue;
            }
        };
        let mut values: Vec<(Value, SpanEntry, String)> = Vec::new();
        for (i, (value, name)) in list.iter().zip(names::of_values(list)).enumerate() {
            let at = [&at[..], &[Step::Index(i)]].concat();
            if values.iter().any(|(other, ..)| other == value) {
                report(
                    &at,
                    At::Value,
                    format!("`{key}`: {} stands here a second time", plain(value)),
                    "remove one of the two",
                );
            }
            let key = document.span(&at[..at.len() - 1], At::Key).clone();
            values.push((value.clone(), SpanEntry { step: Step::Index(0), key, node: node_at(document, &at) }, name));
        }
        axes.push(Axis { key: key.clone(), path, short, values });
    }
    document.take("matrix");
    Some(axes)
}

/// All combinations of values; the last key varies fastest.
pub(super) fn combinations(axes: &[Axis]) -> Vec<Combination> {
    let mut all = vec![Combination::default()];
    for axis in axes {
        let with = |one: &Combination| {
            let one = one.clone();
            axis.values.iter().enumerate().map(move |(i, (value, _, shown))| {
                let mut one = one.clone();
                one.picks.push(i);
                let comma = if one.name.is_empty() { "" } else { "," };
                one.name += &format!("{comma}{}={shown}", axis.short);
                one.values.push((axis.key.clone(), value.clone()));
                one.shown.push(shown.clone());
                one
            })
        };
        all = all.iter().flat_map(with).collect();
    }
    all
}

/// Puts the values of one combination into a pipeline.
pub(super) fn apply(document: &mut Document, axes: &[Axis], combination: &Combination) -> Vec<Diagnostic> {
    let mut diagnostics = Vec::new();
    for (axis, &pick) in axes.iter().zip(&combination.picks) {
        let (value, from, _) = &axis.values[pick];
        let location = from.key.location();
        if let Err(problem) = put(document, &axis.path, value.clone(), from.clone(), &PipelineShapes) {
            let hint = problem.list.map(|list| format!("vary the whole sequence, `{list}`")).unwrap_or_default();
            diagnostics.push(Diagnostic::new(Kind::BadPipeline, problem.message).at(location).hint(hint));
        }
    }
    diagnostics
}

/// A value in one line, without quotes where it needs none.
fn plain(value: &Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), str::to_owned)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn axes(text: &str) -> (Vec<Axis>, Vec<String>) {
        let mut document = Document::parse(Path::new("p.yaml"), text).unwrap();
        let mut diagnostics = Diagnostics::default();
        let axes = take(&mut document, &mut diagnostics).unwrap();
        let first = |diagnostic: &Diagnostic| diagnostic.to_string().lines().next().unwrap_or_default().to_owned();
        (axes, diagnostics.list.iter().map(first).collect())
    }

    #[test]
    fn combinations_are_all_pairs_and_the_last_key_varies_fastest() {
        let (axes, diagnostics) = axes("matrix: { a.lambda: [0.1, 5], b.sampling: [x, y, z] }\n");
        assert!(diagnostics.is_empty());
        let names: Vec<_> = combinations(&axes).into_iter().map(|one| one.name).collect();
        assert_eq!(
            names,
            [
                "lambda=0.1,sampling=x",
                "lambda=0.1,sampling=y",
                "lambda=0.1,sampling=z",
                "lambda=5,sampling=x",
                "lambda=5,sampling=y",
                "lambda=5,sampling=z"
            ]
        );
    }

    #[test]
    fn without_a_key_there_is_one_combination_without_a_name() {
        let (axes, _) = axes("matrix: {}\n");
        assert_eq!(combinations(&axes).iter().map(|one| one.name.as_str()).collect::<Vec<_>>(), [""]);
    }

    #[test]
    fn values_go_to_their_paths_and_keep_their_places() {
        let (axes, _) = axes("matrix: { transfer.k: [1, 2] }\n");
        let mut document = Document::parse(Path::new("q.yaml"), "transfer: { type: x }\n").unwrap();
        let second = &combinations(&axes)[1];
        assert!(apply(&mut document, &axes, second).is_empty());
        assert_eq!(document.value.to_string(), r#"{"transfer":{"type":"x","k":2}}"#);
        let location = |at| document.location(&path(["transfer", "k"]), at).to_string();
        assert_eq!([location(At::Value), location(At::Key)], ["p.yaml:1:27", "p.yaml:1:11"]);
    }

    #[test]
    fn what_is_no_list_of_different_values_is_told() {
        let text = "matrix: { a: 5, b: [], c: [1, 1], targets.x: [1], d..e: [1] }\n";
        assert_eq!(
            axes(text).1,
            [
                "p.yaml:1:14: `a`: expected a sequence of values, found 5",
                "p.yaml:1:20: `b`: the sequence of values is empty",
                "p.yaml:1:31: `c`: 1 stands here a second time",
                "p.yaml:1:35: `targets` cannot vary",
                "p.yaml:1:51: `d..e` is no path of keys",
            ]
        );
    }
}
