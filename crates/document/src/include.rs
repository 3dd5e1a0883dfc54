//! `include`: files that a document is merged over.

use std::{
    collections::HashMap,
    path::{Path, PathBuf},
    sync::Arc,
};

use serde_json::Value;

use crate::{
    describe::describe,
    diagnostic::{Diagnostic, Diagnostics, Location, Result},
    document::{At, Document},
    files::read_text_up_to,
    limits::{MAX_INCLUDE_DEPTH, MAX_INCLUDED_BYTES, MAX_INCLUDES, MAX_YAML_BYTES, thousands},
    merge::merge_into,
    paths,
    step::{Step, path},
};

/// Reads `file` and what it includes, laid over each other; gives the included files too, in the order they are laid.
///
/// However files include each other, the result is that of all of them in one list: a file lies over what it includes, and
/// of two in a list the second over the first.
///
/// A file may include any regular file. Of those that lie elsewhere than below the folder of `file`, messages show no lines.
///
/// # Errors
///
/// Files that cannot be read or are no YAML, all of them; files that include themselves, and more than there may be.
pub fn read(file: &Path) -> Result<(Document, Vec<PathBuf>)> {
    let own = Document::read(file)?;
    let mut reader = Reader::new(file);
    reader.layers(Arc::new(own), &mut vec![(file.into(), paths::identity(file))]);
    if !reader.diagnostics.is_empty() {
        return Err(Diagnostics { list: reader.diagnostics });
    }
    let mut files: Vec<PathBuf> = Vec::new();
    for layer in &reader.layers {
        if layer.file != file && !files.contains(&layer.file) {
            files.push(layer.file.clone());
        }
    }
    let mut layers = reader.layers.into_iter().map(|layer| without_include(&layer));
    let mut whole = layers.next().unwrap_or(Document::parse(file, "{}")?);
    layers.for_each(|own| merge_into(&mut whole, own));
    whole.file = file.into();
    Ok((whole, files))
}

fn without_include(layer: &Document) -> Document {
    let mut own = layer.clone();
    if own.value.is_object() {
        own.take("include");
    }
    own
}

struct Reader {
    /// The folder of the file that all others are included by, without links.
    folder: Option<PathBuf>,
    /// What is laid over each other; a file that is included several times is several of them.
    layers: Vec<Arc<Document>>,
    /// The files that were read, by their names, each with its size.
    known: HashMap<PathBuf, (Arc<Document>, usize)>,
    /// How many were included so far, and their bytes.
    count: usize,
    bytes: usize,
    /// Whether there are more than there may be: what follows needs no diagnostic.
    is_full: bool,
    diagnostics: Vec<Diagnostic>,
}

impl Reader {
    fn new(file: &Path) -> Self {
        let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        Self {
            folder: folder.canonicalize().ok(),
            layers: vec![],
            known: HashMap::new(),
            count: 0,
            bytes: 0,
            is_full: false,
            diagnostics: vec![],
        }
    }

    /// Adds what `own` includes and then itself; `chain` leads to it, by names and by what the system takes them for.
    fn layers(&mut self, own: Arc<Document>, chain: &mut Vec<(PathBuf, PathBuf)>) {
        for (at, name) in self.names(&own) {
            if self.is_full {
                return;
            }
            let file = paths::from_base(own.folder(&at), Path::new(&name));
            let identity = paths::identity(&file);
            if chain.iter().any(|(_, other)| *other == identity) {
                let shown: Vec<_> =
                    chain.iter().map(|(name, _)| name).chain([&file]).map(|file| file.display().to_string()).collect();
                let message = format!("files include each other in a circle: {}", shown.join(" includes "));
                self.diagnostics.push(own.diagnostic(&at, At::Value, message).hint("remove one of these includes"));
                continue;
            }
            if let Some(message) = self.too_many(chain.len()) {
                let hint = "include each file once, in one list: `include: [a.yaml, b.yaml]`";
                self.diagnostics.push(own.diagnostic(&at, At::Value, message).hint(hint));
                self.is_full = true;
                return;
            }
            self.count += 1;
            match self.document(&file) {
                Ok(included) if included.value.is_object() => {
                    chain.push((file, identity));
                    self.layers(included, chain);
                    chain.pop();
                }
                Ok(included) => {
                    let message = "expected a mapping of keys";
                    let hint =
                        "is it the file that is meant? an included file has keys of a pipeline, e.g. `transfer: …`";
                    self.diagnostics.push(included.diagnostic(&[], At::Value, message).hint(hint));
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
        self.layers.push(own);
    }

    /// Why no more can be included, if so; `depth` files lead to the next.
    fn too_many(&self, depth: usize) -> Option<String> {
        if depth > MAX_INCLUDE_DEPTH {
            return Some(format!("more than {MAX_INCLUDE_DEPTH} files include each other in a row"));
        }
        if self.count >= MAX_INCLUDES {
            let most = thousands(MAX_INCLUDES);
            return Some(format!("more than {most} files are included, each counted as often as it is"));
        }
        (self.bytes > MAX_INCLUDED_BYTES).then(|| {
            let most = thousands(MAX_INCLUDED_BYTES);
            format!("the included files have more than {most} bytes, each counted as often as it is included")
        })
    }

    /// The file `file`, which is read and parsed once.
    fn document(&mut self, file: &Path) -> Result<Arc<Document>> {
        if let Some((document, bytes)) = self.known.get(file) {
            self.bytes += bytes;
            return Ok(document.clone());
        }
        let text = read_text_up_to(file, MAX_YAML_BYTES as u64)?;
        let is_own = file.canonicalize().ok().zip(self.folder.as_ref()).is_some_and(|(f, own)| f.starts_with(own));
        let document = if is_own { Document::parse(file, &text) } else { Document::parse_hidden(file, &text) };
        let document = Arc::new(document?);
        self.bytes += text.len();
        self.known.insert(file.into(), (document.clone(), text.len()));
        Ok(document)
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

#[cfg(test)]
mod tests {
    use super::*;

    /// The error, or the value, of `p.yaml` among these files.
    fn included(files: &[(String, String)]) -> std::result::Result<Value, String> {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in files {
            let file = folder.path().join(name);
            std::fs::create_dir_all(file.parent().unwrap()).unwrap();
            std::fs::write(file, text).unwrap();
        }
        read(&folder.path().join("project/p.yaml")).map(|(whole, _)| whole.value).map_err(|error| error.to_string())
    }

    fn file(name: &str, text: &str) -> (String, String) {
        (format!("project/{name}"), text.into())
    }

    /// Files of which each includes the one before `times` times.
    fn tower(height: usize, times: usize) -> Vec<(String, String)> {
        let storey = |i: usize| match i {
            0 => file("0.yaml", "a: 1\n"),
            i => file(
                &format!("{i}.yaml"),
                &format!("include: [{}]\n", vec![format!("{}.yaml", i - 1); times].join(", ")),
            ),
        };
        (0..=height).map(storey).chain([file("p.yaml", &format!("include: {height}.yaml\nb: 2\n"))]).collect()
    }

    #[test]
    fn a_few_files_that_include_each_other_cannot_ask_for_endless_work() {
        assert_eq!(included(&tower(5, 2)).unwrap(), serde_json::json!({ "a": 1, "b": 2 }));
        let bomb = included(&tower(30, 2)).unwrap_err();
        assert!(bomb.contains("more than 1,000 files are included") && bomb.matches("error:").count() == 1, "{bomb}");
        let chain = included(&tower(300, 1)).unwrap_err();
        assert!(chain.contains("more than 64 files include each other in a row"), "{chain}");
        assert_eq!(chain.matches("error:").count(), 1, "{chain}");
    }

    #[test]
    fn of_files_elsewhere_no_line_is_shown() {
        for text in ["secret: [", "- secret\n", "secret"] {
            let here = included(&[file("p.yaml", "include: a.yaml\n"), file("a.yaml", text)]).unwrap_err();
            assert!(here.contains("secret"), "{here}");
            let files = [file("p.yaml", "include: ../a.yaml\n"), ("a.yaml".into(), text.into())];
            let elsewhere = included(&files).unwrap_err();
            assert!(elsewhere.contains("a.yaml:1:") && !elsewhere.contains("secret"), "{elsewhere}");
        }
    }
}
