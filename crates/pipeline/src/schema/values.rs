//! Walks a value along with its schema: numbers out of their range, and settings that name files.

use std::path::{Path, PathBuf};

use mimesh_document::{At, Diagnostics, Document, Step, paths::from_base};
use serde_json::Value;

use super::{SchemaNode, words::violated_range};

/// A setting that names a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileSetting {
    /// Its path in the document.
    pub path: Vec<Step>,
    /// The file, as the setting spells it.
    pub file: PathBuf,
}

/// Adds a diagnostic for each number at or within `path` that is out of its range; `root` is the schema of the whole document.
pub fn check_ranges(root: SchemaNode<'_>, document: &Document, path: &[Step], diagnostics: &mut Diagnostics) {
    let (Some(value), Some(node)) = (document.get(path), root.at(&document.value, path)) else {
        return;
    };
    visit(node, value, &mut path.to_vec(), &mut |node, value, path| {
        let Some(expected) = value.as_f64().and_then(|number| violated_range(node.schema(), number)) else { return };
        let key = path.iter().rev().find(|step| matches!(step, Step::Key(_))).map(Step::to_string).unwrap_or_default();
        diagnostics.push(document.diagnostic(path, At::Value, format!("`{key}`: expected {expected}, found {value}")));
    });
}

/// The settings within `value`, whose schema is `node`, that name files; words of commands where there is such a file.
pub fn file_settings(node: SchemaNode<'_>, value: &Value) -> Vec<FileSetting> {
    let mut found = of_files(node, value);
    found.extend(words_of_commands(node, value).into_iter().filter(|word| word.file.is_file()));
    found
}

fn of_files(node: SchemaNode<'_>, value: &Value) -> Vec<FileSetting> {
    let mut found = Vec::new();
    visit(node, value, &mut vec![], &mut |node, value, path| {
        if let Some(text) = value.as_str().filter(|_| node.is_file()) {
            found.push(FileSetting { path: path.to_vec(), file: text.into() });
        }
    });
    found
}

/// The words of commands within `value` that may be files; a program without a folder is one that the system finds.
fn words_of_commands(node: SchemaNode<'_>, value: &Value) -> Vec<FileSetting> {
    let mut found = Vec::new();
    visit(node, value, &mut vec![], &mut |node, value, path| {
        let Some(words) = value.as_array().filter(|_| node.is_command()) else { return };
        let texts = words.iter().enumerate().filter_map(|(i, word)| Some((i, word.as_str()?)));
        let may_be_file =
            |&(i, text): &(usize, &str)| !text.is_empty() && (i > 0 || Path::new(text).components().count() > 1);
        found.extend(texts.filter(may_be_file).map(|(i, text)| FileSetting {
            path: path.iter().cloned().chain([Step::Index(i)]).collect(),
            file: text.into(),
        }));
    });
    found
}

/// Makes the paths of all files that settings of `document` name relative to the current folder.
///
/// A path is relative to the folder of the file that names it. Returns the settings with their paths as they are now.
pub fn resolve_files(document: &mut Document) -> Vec<FileSetting> {
    let mut settings = of_files(SchemaNode::pipeline(), &document.value);
    let words = words_of_commands(SchemaNode::pipeline(), &document.value).into_iter();
    settings.extend(words.filter(|word| from_base(document.folder(&word.path), &word.file).is_file()));
    for FileSetting { path, file } in &mut settings {
        if !file.as_os_str().is_empty() {
            *file = from_base(document.folder(path), file);
        }
        // A program without a folder would be searched elsewhere.
        if path.last() == Some(&Step::Index(0)) && file.components().count() == 1 {
            *file = Path::new(".").join(&file);
        }
        if let Some(value) = document.get_mut(path) {
            *value = file.to_string_lossy().into();
        }
    }
    settings
}

/// Calls `see` for `value` and every value within it that the schema knows.
pub(super) fn visit(
    node: SchemaNode<'_>,
    value: &Value,
    path: &mut Vec<Step>,
    see: &mut impl FnMut(SchemaNode<'_>, &Value, &[Step]),
) {
    see(node, value, path);
    let entries: Vec<(Step, &Value)> = match value {
        Value::Object(map) => map.iter().map(|(key, value)| (Step::Key(key.clone()), value)).collect(),
        Value::Array(list) => list.iter().enumerate().map(|(i, value)| (Step::Index(i), value)).collect(),
        _ => vec![],
    };
    for (step, inner) in entries {
        let Some(entry) = node.entry(&step, Some(value)) else { continue };
        path.push(step);
        visit(entry, inner, path, see);
        path.pop();
    }
}
