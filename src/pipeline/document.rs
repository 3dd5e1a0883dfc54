//! A YAML file: its values, and where each of them stands.
//!
//! serde-saphyr gives the values, with aliases and merge keys resolved; saphyr gives the places of the same text. What
//! deserialises a value only knows the path to it (`transfer.type`), and [`Document::place`] finds the text for the
//! path.

use std::{
    fmt,
    path::{Path, PathBuf},
    sync::Arc,
};

use serde_json::{Map, Value};

use super::places::{Node, Span, Spot, Text};
use crate::{
    diagnostic::Kind,
    diagnostic::{Diagnostic, Diagnostics, Location, read_text},
};

/// A YAML file, parsed but not yet understood; once composed, with what it includes.
#[derive(Clone, Debug)]
pub struct Document {
    /// The file, as messages name it.
    pub file: PathBuf,
    /// Its contents; in every map `type` comes first.
    pub value: Value,
    /// Where they were written.
    pub(super) root: Node,
}

/// One step of a path through a document.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Step {
    /// Into a map.
    Key(String),
    /// Into a list, from 0.
    Index(usize),
}

/// What to point at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum At {
    /// The key of the last step.
    Key,
    /// The value.
    Value,
}

impl Document {
    /// Reads a file.
    ///
    /// # Errors
    ///
    /// If it cannot be read, or is no YAML.
    pub fn read(file: &Path) -> Result<Self, Diagnostics> {
        Self::parse(file, &read_text(file)?)
    }

    /// Parses the text of `file`.
    ///
    /// # Errors
    ///
    /// If it is no YAML.
    pub fn parse(file: &Path, text: &str) -> Result<Self, Diagnostics> {
        let whole = Text::new(file, text);
        let text = &guarded(text);
        let value = yaml_value(text).map_err(|error| not_yaml(&whole, error))?;
        Ok(Self { file: file.into(), value: type_first(value), root: Node::of_yaml(&whole, text) })
    }

    /// The text at `path`, or at the nearest part of the path that is in the file: a merged value has no place of its own. A
    /// value from an option, and one that an option made what it is, is at that option.
    pub fn location(&self, path: &[Step], at: At) -> Location {
        self.spot(path, at).location()
    }

    /// The same, not yet put into words.
    pub(super) fn spot(&self, path: &[Step], at: At) -> &Spot {
        let (mut node, mut spot) = (&self.root, &self.root.spot);
        for (i, step) in path.iter().enumerate() {
            let Some(part) = node.part(step) else { break };
            spot = if i + 1 == path.len() && at == At::Key { &part.key } else { &part.node.spot };
            node = &part.node;
        }
        spot
    }

    /// The folder that a relative path at `path` begins at: that of the file in which its beginning was written.
    pub fn folder(&self, path: &[Step]) -> &Arc<Path> {
        let mut node = &self.root;
        for step in path {
            let Some(part) = node.part(step) else { break };
            node = &part.node;
        }
        &node.folder
    }

    /// The value at `path`.
    pub fn get(&self, path: &[Step]) -> Option<&Value> {
        path.iter().try_fold(&self.value, |value, step| step.get(value))
    }

    /// Takes a key of the whole out, with its places.
    pub(super) fn take(&mut self, key: &str) -> Option<(Value, super::places::Part)> {
        let value = self.value.as_object_mut()?.shift_remove(key)?;
        Some((value, self.root.take(&Step::Key(key.into()))))
    }

    /// A diagnostic at `path`.
    pub fn diagnostic(&self, path: &[Step], at: At, message: impl Into<String>) -> Diagnostic {
        Diagnostic::new(Kind::BadPipeline, message).at(self.location(path, at))
    }
}

/// The diagnostic of a text that is no YAML, in words of someone who writes it and with a way out that fits.
fn not_yaml(text: &Arc<Text>, error: serde_saphyr::Error) -> Diagnostic {
    let error = error.without_snippet();
    let mut told = error.to_string();
    let mut location = Location::File(text.file.clone());
    if let Some(at) = error.location().filter(|at| at.line() > 0) {
        let (line, column) = (at.line() as usize, at.column() as usize);
        if let Some(end) = told.find(&format!(" at line {line}, column {column}")) {
            told.truncate(end);
        }
        location = Spot::Text(text.clone(), Span { line, column: column.max(1) - 1, length: 1 }).location();
    }
    let (message, hint) = if let Some(rest) = told.strip_prefix("duplicate mapping key: ") {
        let key = rest.split(',').next().unwrap_or(rest);
        (format!("the key `{key}` stands here a second time"), "remove one of the two")
    } else if told.starts_with("multiple YAML documents") {
        ("a second document begins here".into(), "remove the line `---` and what follows it; one file is one pipeline")
    } else if told.contains("tab") {
        (told, "indent with blanks")
    } else if told.contains("unknown anchor") {
        (
            "`*` at the beginning of a value refers to an anchor, and there is none of this name".into(),
            "put a glob that begins with `*` in quotes: `\"*.obj\"`",
        )
    } else {
        (told, "a text with `:`, `#` or `{…}` in it needs quotes, and lines of one map the same indentation")
    };
    Diagnostic::new(Kind::BadPipeline, format!("not valid YAML: {message}")).at(location).hint(hint)
}

/// The value of a YAML text, with aliases and merge keys resolved.
///
/// # Errors
///
/// If it is no YAML.
pub fn yaml_value(text: &str) -> Result<Value, serde_saphyr::Error> {
    let options = serde_saphyr::options! { strict_booleans: true, with_snippet: false };
    Ok(unguarded(serde_saphyr::from_str_with_options::<Value>(&guarded(text), options)?))
}

/// What stands for the braces of `{pose}` while it passes through YAML: a private character for each, so that columns stay.
const GUARDS: [char; 2] = ['\u{e000}', '\u{e001}'];

/// `text` in which `{pose}` and `${name}` are no YAML maps, so that they need no quotes: `[out/{pose}.obj, ${all}]`.
fn guarded(text: &str) -> String {
    const PLACEHOLDERS: [&str; 4] = ["pose", "target", "matrix", "name"];
    let mut result = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(open) = rest.find('{') {
        let (before, from) = rest.split_at(open);
        result += before;
        let inside = from[1..].split_once('}').map(|(inside, _)| inside);
        let named = |c: char| c.is_alphanumeric() || "_-:.".contains(c);
        let stands = |inside: &str| match before.ends_with('$') {
            true => inside.chars().all(named),
            false => PLACEHOLDERS.contains(&inside),
        };
        match inside.filter(|inside| stands(inside)) {
            Some(inside) => {
                result.push(GUARDS[0]);
                result += inside;
                result.push(GUARDS[1]);
                rest = &from[inside.len() + 2..];
            }
            None => {
                result.push('{');
                rest = &from[1..];
            }
        }
    }
    result + rest
}

/// `text` with its braces as they were written.
pub(super) fn restored(text: &str) -> String {
    text.replace(GUARDS[0], "{").replace(GUARDS[1], "}")
}

fn unguarded(value: Value) -> Value {
    match value {
        Value::String(text) => Value::String(restored(&text)),
        Value::Array(list) => Value::Array(list.into_iter().map(unguarded).collect()),
        Value::Object(map) => {
            Value::Object(map.into_iter().map(|(key, value)| (restored(&key), unguarded(value))).collect())
        }
        other => other,
    }
}

/// A path of keys and list indices, from text: `["metrics", "0", "type"]`.
pub fn path<const N: usize>(keys: [&str; N]) -> Vec<Step> {
    keys.into_iter().map(Step::parse).collect()
}

impl Step {
    /// A step as text says it; digits are an index.
    pub fn parse(text: &str) -> Self {
        text.parse().map_or_else(|_| Self::Key(text.into()), Self::Index)
    }

    /// The value one step into `value`.
    pub fn get<'v>(&self, value: &'v Value) -> Option<&'v Value> {
        match self {
            Self::Key(key) => value.get(key),
            Self::Index(index) => value.get(index),
        }
    }

    /// The value one step into `value`, to change it.
    pub fn get_mut<'v>(&self, value: &'v mut Value) -> Option<&'v mut Value> {
        match self {
            Self::Key(key) => value.get_mut(key),
            Self::Index(index) => value.get_mut(index),
        }
    }
}

impl fmt::Display for Step {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Key(key) => f.write_str(key),
            Self::Index(index) => write!(f, "{index}"),
        }
    }
}

/// `value` with the key `type` first in every map, so that typetag needs no buffer and errors keep their path.
pub fn type_first(value: Value) -> Value {
    match value {
        Value::Object(mut map) => {
            let tag = map.shift_remove("type").map(|tag| ("type".to_owned(), tag));
            let others = map.into_iter().map(|(key, value)| (key, type_first(value)));
            Value::Object(tag.into_iter().chain(others).collect::<Map<_, _>>())
        }
        Value::Array(list) => Value::Array(list.into_iter().map(type_first).collect()),
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn location(text: &str, keys: &[&str], at: At) -> (usize, usize, usize) {
        let document = Document::parse(Path::new("a.yaml"), text).unwrap();
        let path: Vec<_> = keys.iter().map(|key| Step::parse(key)).collect();
        match document.location(&path, at) {
            Location::Span { line, column, length, .. } => (line, column, length),
            other => panic!("expected a span, found {other:?}"),
        }
    }

    #[test]
    fn keys_and_values_are_found_in_both_notations() {
        let text = "# first\nsource: { rest: a.obj, poses: [b, cc] }\ntransfer:\n  type: gradient\n";
        assert_eq!(location(text, &["source"], At::Key), (2, 1, 6));
        assert_eq!(location(text, &["source", "rest"], At::Value), (2, 17, 5));
        assert_eq!(location(text, &["source", "poses", "1"], At::Value), (2, 35, 2));
        assert_eq!(location(text, &["transfer", "type"], At::Value), (4, 9, 8));
        assert_eq!(location(text, &["transfer", "type"], At::Key), (4, 3, 4));
    }

    #[test]
    fn the_pose_needs_no_quotes_in_a_list() {
        let text = "output: [out/{pose}.obj, all.glb]\ntruth: {pose}.ply\n";
        let document = Document::parse(Path::new("a.yaml"), text).unwrap();
        assert_eq!(document.value["output"][0], "out/{pose}.obj");
        assert_eq!(document.value["truth"], "{pose}.ply");
        assert_eq!(location(text, &["output", "1"], At::Value), (1, 26, 7));
    }

    #[test]
    fn variables_need_no_quotes_and_other_maps_stay_maps() {
        let text = "a: [${x}/{target}.obj, { b: {pose: 1} }, ${env:HOME}]\nc: ${y}\n";
        let document = Document::parse(Path::new("a.yaml"), text).unwrap();
        let expected = r#"{"a":["${x}/{target}.obj",{"b":{"pose":1}},"${env:HOME}"],"c":"${y}"}"#;
        assert_eq!(document.value.to_string(), expected);
        assert_eq!(location(text, &["a", "1", "b"], At::Value), (1, 29, 8));
    }

    #[test]
    fn what_is_not_in_the_file_is_at_its_nearest_parent() {
        let text = "source: { rest: a.obj }\n";
        assert_eq!(location(text, &["source", "poses", "3"], At::Value).0, 1);
        assert_eq!(location(text, &["target"], At::Value), (1, 1, 6 + 17));
    }

    #[test]
    fn values_of_a_merged_map_are_at_the_map_that_merges() {
        let text = "base: &b { type: x, k: 1 }\nother: { <<: *b, l: 2 }\n";
        let document = Document::parse(Path::new("a.yaml"), text).unwrap();
        assert_eq!(document.value["other"]["k"], 1);
        assert_eq!(location(text, &["other", "k"], At::Value).0, 2);
    }

    #[test]
    fn no_is_a_text_and_type_comes_first() {
        let document = Document::parse(Path::new("a.yaml"), "a: no\ntype: x\n").unwrap();
        assert_eq!(document.value.to_string(), r#"{"type":"x","a":"no"}"#);
    }

    #[test]
    fn frequent_slips_are_told_in_words_of_the_file() {
        let told = |text: &str| {
            let text = Document::parse(Path::new("a.yaml"), text).unwrap_err().to_string();
            let (first, last) = (text.lines().next().unwrap(), text.lines().last().unwrap());
            format!("{}|{}", first.trim_start_matches("error: a.yaml:"), last.trim_start_matches(['=', ' ']))
        };
        let tabs = told("a:\n\tb: 1\n");
        assert!(tabs.contains("tabs") && tabs.ends_with("|hint: indent with blanks"), "{tabs}");
        assert_eq!(
            told("a: 1\na: 2\n"),
            "2:1: not valid YAML: the key `a` stands here a second time|hint: remove one of the two"
        );
        assert!(told("a: 1\n---\na: 2\n").starts_with("3:1: not valid YAML: a second document begins here|"));
        assert!(told("a: *.obj\n").ends_with("|hint: put a glob that begins with `*` in quotes: `\"*.obj\"`"));
    }

    #[test]
    fn broken_yaml_is_told_with_its_line() {
        let failure = Document::parse(Path::new("a.yaml"), "a: 1\nb: [1, 2\n").unwrap_err();
        let text = failure.to_string();
        assert!(text.starts_with("error: a.yaml:") && text.contains("not valid YAML"), "{text}");
    }
}
