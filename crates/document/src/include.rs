//! `include`: files that a document is merged over.

use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::{
    describe::describe,
    diagnostic::{Diagnostic, Diagnostics, Location, Result},
    document::{At, Document},
    merge::merge_into,
    paths,
    step::{Step, path},
};

/// Reads `file` and what it includes, laid over each other; gives the included files too, in the order they are laid.
///
/// However files include each other, the result is that of all of them in one list: a file lies over what it includes, and
/// of two in a list the second over the first.
///
/// # Errors
///
/// Files that cannot be read or are no YAML, all of them; files that include themselves.
pub fn read(file: &Path) -> Result<(Document, Vec<PathBuf>)> {
    let own = Document::read(file)?;
    let mut reader = Reader { layers: vec![], diagnostics: vec![] };
    reader.layers(own, &mut vec![file.into()]);
    if !reader.diagnostics.is_empty() {
        return Err(Diagnostics { list: reader.diagnostics });
    }
    let mut files: Vec<PathBuf> = Vec::new();
    for layer in &reader.layers {
        if layer.file != file && !files.contains(&layer.file) {
            files.push(layer.file.clone());
        }
    }
    let mut layers = reader.layers.into_iter();
    let mut whole = layers.next().unwrap_or(Document::parse(file, "{}")?);
    layers.for_each(|own| merge_into(&mut whole, own));
    whole.file = file.into();
    Ok((whole, files))
}

struct Reader {
    layers: Vec<Document>,
    diagnostics: Vec<Diagnostic>,
}

impl Reader {
    /// Adds what `own` includes and then itself; `chain` leads to it.
    fn layers(&mut self, mut own: Document, chain: &mut Vec<PathBuf>) {
        for (at, name) in self.names(&own) {
            let file = paths::from_base(own.folder(&at), Path::new(&name));
            if chain.iter().any(|other| paths::identity(other) == paths::identity(&file)) {
                let shown: Vec<_> = chain.iter().chain([&file]).map(|file| file.display().to_string()).collect();
                let message = format!("files include each other in a circle: {}", shown.join(" includes "));
                self.diagnostics.push(own.diagnostic(&at, At::Value, message).hint("remove one of these includes"));
                continue;
            }
            match Document::read(&file) {
                Ok(included) if included.value.is_object() => {
                    chain.push(file);
                    self.layers(included, chain);
                    chain.pop();
                }
                Ok(included) => {
                    let message = "expected a mapping of keys";
                    self.diagnostics.push(included.diagnostic(&[], At::Value, message));
                }
                // That it is not there is said where it is named.
                Err(failure) => {
                    self.diagnostics.extend(failure.list.into_iter().map(|diagnostic| match &diagnostic.location {
                        Some(Location::File(_)) => {
                            let message = format!("{}: {}", diagnostic.message, file.display());
                            Diagnostic { message, ..diagnostic }.at(own.location(&at, At::Value))
                        }
                        _ => diagnostic,
                    }))
                }
            }
        }
        if own.value.is_object() {
            own.take("include");
        }
        self.layers.push(own);
    }

    /// The files that `document` includes, and where it says so.
    fn names(&mut self, document: &Document) -> Vec<(Vec<Step>, String)> {
        let at = path(["include"]);
        let items: Vec<(Vec<Step>, &Value)> = match document.get(&at) {
            None => return vec![],
            Some(Value::Array(list)) => {
                list.iter().enumerate().map(|(i, item)| ([&at[..], &[Step::Index(i)]].concat(), item)).collect()
            }
            Some(one) => vec![(at, one)],
        };
        let mut names = Vec::new();
        for (at, item) in items {
            match item {
                Value::String(name) if name.contains("${") => {
                    let hint = "write the path; files are included before variables are known";
                    self.diagnostics
                        .push(document.diagnostic(&at, At::Value, "a variable cannot be included").hint(hint));
                }
                Value::String(name) if !name.is_empty() => names.push((at, name.clone())),
                other => {
                    let message =
                        format!("`include`: expected a path or a sequence of paths, found {}", describe(other));
                    self.diagnostics
                        .push(document.diagnostic(&at, At::Value, message).hint("e.g. `include: base.yaml`"));
                }
            }
        }
        names
    }
}
