//! `{target}`, `{matrix}` and `{name}` in the names of files, and where they have to be.

use indexmap::IndexMap;
use mimesh_document::{
    At, Document, Step,
    diagnostic::{Diagnostic, Diagnostics, Kind, Location},
    path,
    paths::stem,
    source_tree::SourceSpan,
};
use serde_json::Value;

use crate::{compose::Variant, placeholder::placeholders};

/// The name of a file that a run writes.
#[derive(Clone, Debug)]
pub(super) struct OutputPattern {
    span: SourceSpan,
    /// With variables, but its placeholders as they are.
    pattern: String,
    /// The number of the run.
    run: usize,
}

/// Files and patterns that one slot may name.
const MAX_FILES: usize = 1000;

/// What the name is of one of several that is the only one.
const ALONE: &str = "default";

/// Puts names into the paths of `variant`, the run of number `run`; gives those that it writes to. `declared` says whether the
/// file has `targets` and a `matrix`, which may be empty.
pub(super) fn fill(
    document: &mut Document,
    variant: &Variant,
    run: usize,
    declared: [bool; 2],
    diagnostics: &mut Diagnostics,
) -> Vec<OutputPattern> {
    let or_alone = |name: &Option<String>, declared: bool| name.clone().or_else(|| declared.then(|| ALONE.to_owned()));
    let whole = Some(variant.name.clone()).filter(|name| !name.is_empty());
    let names = [
        ("target", or_alone(&variant.target, declared[0]), "targets"),
        ("matrix", or_alone(&variant.matrix, declared[1]), "matrix"),
        ("name", or_alone(&whole, declared[0] || declared[1]), "targets` or `matrix"),
    ];
    let mut written = Vec::new();
    for slot in ["markers", "truth", "keep_correspondence", "output"] {
        let slot = path([slot]);
        let within = |step: Step| [&slot[..], &[step]].concat();
        let at: Vec<Vec<Step>> = match document.get(&slot) {
            Some(Value::Array(list)) => (0..list.len()).map(|i| within(Step::Index(i))).collect(),
            Some(Value::Object(map)) => map.keys().map(|key| within(Step::Key(key.clone()))).collect(),
            _ => vec![slot.clone()],
        };
        if at.len() > MAX_FILES {
            let message = format!("{} files or patterns, expected {MAX_FILES} at most", at.len());
            let hint = "name them by one pattern, e.g. `out/{pose}.obj`";
            diagnostics.push(document.diagnostic(&slot, At::Value, message).hint(hint));
            if let Some(value) = document.get_mut(&slot) {
                *value = Value::Array(vec![]);
            }
            continue;
        }
        for at in at {
            let Some(Value::String(pattern)) = document.get(&at).cloned() else { continue };
            let span = document.span(&at, At::Value).clone();
            let mut text = pattern.clone();
            for (placeholder, name, key) in &names {
                let written = format!("{{{placeholder}}}");
                match name {
                    Some(name) => text = text.replace(&written, name),
                    None if placeholders(&pattern).contains(placeholder) => {
                        let message = format!("`{written}` without `{key}`");
                        let diagnostic =
                            Diagnostic::new(Kind::BadPipeline, message).at(span.within(&written).location());
                        diagnostics.push(diagnostic.hint("remove it; it tells several runs apart"));
                        text = text.replace(&written, placeholder);
                    }
                    None => {}
                }
            }
            if let Some(value) = document.get_mut(&at) {
                *value = Value::String(text);
            }
            if slot == path(["output"]) || slot == path(["keep_correspondence"]) {
                written.push(OutputPattern { span, pattern, run });
            }
        }
    }
    written
}

/// Patterns by which several runs would write the same file.
pub(super) fn needed(written: &[OutputPattern], variants: &[Variant]) -> Vec<Diagnostic> {
    let mut diagnostics = Vec::new();
    if variants.len() < 2 {
        return diagnostics;
    }
    // The runs of each pattern, in the order of the file.
    let mut groups: IndexMap<(Location, &str), Vec<&Variant>> = IndexMap::new();
    for one in written {
        groups.entry((one.span.location(), &one.pattern)).or_default().push(&variants[one.run]);
    }
    for ((location, pattern), runs) in groups {
        let names = placeholders(pattern);
        let differ = |of: fn(&Variant) -> &Option<String>| runs.iter().any(|run| of(run) != of(runs[0]));
        let lacks = |name: &str| !names.contains(&name) && !names.contains(&"name");
        let target = differ(|run| &run.target) && lacks("target");
        let matrix = differ(|run| &run.matrix) && lacks("matrix");
        let (needs, why) = match (target, matrix) {
            (true, true) => ("{name}", "targets and combinations"),
            (true, false) => ("{target}", "targets"),
            (false, true) => ("{matrix}", "combinations"),
            (false, false) => ("", ""),
        };
        if !needs.is_empty() {
            let message = format!("there are several {why}, so the name of what is written needs `{needs}`");
            let hint = format!("e.g. `{}`", with(pattern, needs));
            diagnostics.push(Diagnostic::new(Kind::BadPipeline, message).at(location).hint(hint));
        }
    }
    diagnostics
}

/// `pattern` with a placeholder in the name of its file, or of its folder if files are told apart by pose.
fn with(pattern: &str, placeholder: &str) -> String {
    let (folder, file) = pattern.rsplit_once('/').map_or(("", pattern), |(folder, file)| (folder, file));
    let slash = if folder.is_empty() { "" } else { "/" };
    if file.contains("{pose}") {
        return format!("{folder}{slash}{placeholder}/{file}");
    }
    let stem = stem(file.as_ref());
    let rest = file.strip_prefix(stem.as_str()).unwrap_or_default();
    format!("{folder}{slash}{stem}-{placeholder}{rest}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hints_put_the_placeholder_where_it_tells_files_apart() {
        assert_eq!(with("out/{pose}.obj", "{target}"), "out/{target}/{pose}.obj");
        assert_eq!(with("out/camel.glb", "{matrix}"), "out/camel-{matrix}.glb");
        assert_eq!(with("camel.glb", "{name}"), "camel-{name}.glb");
    }
}
