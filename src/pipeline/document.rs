//! A YAML file: its values, and where each of them stands.
//!
//! serde-saphyr gives the values, with aliases and merge keys resolved; saphyr gives the places of the same text. What
//! deserialises a value only knows the path to it (`transfer.type`), and [`Document::place`] finds the text for the
//! path.

use std::{
    fmt,
    path::{Path, PathBuf},
};

use saphyr::{LoadableYamlNode, MarkedYaml, Scalar, YamlData};
use serde_json::{Map, Value};

use crate::{
    mistake::{Failure, Mistake, Place, read_text},
    status::Status,
};

/// A YAML file, parsed but not yet understood.
#[derive(Clone, Debug)]
pub struct Document {
    /// The file, as messages name it.
    pub file: PathBuf,
    /// Its contents; in every map `type` comes first.
    pub value: Value,
    /// Values that options replaced: their paths and the options.
    pub overrides: Vec<(Vec<Step>, String)>,
    lines: Vec<String>,
    root: Option<Node>,
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

/// Where a value stands, and its parts.
#[derive(Clone, Debug)]
struct Node {
    span: Span,
    parts: Vec<(Step, Span, Node)>,
}

/// Line from 1, column from 0 and length, in characters.
#[derive(Clone, Copy, Debug)]
struct Span {
    line: usize,
    column: usize,
    length: usize,
}

impl Document {
    /// Reads a file.
    ///
    /// # Errors
    ///
    /// If it cannot be read, or is no YAML.
    pub fn read(file: &Path) -> Result<Self, Failure> {
        Self::parse(file, &read_text(file)?)
    }

    /// Parses the text of `file`.
    ///
    /// # Errors
    ///
    /// If it is no YAML.
    pub fn parse(file: &Path, text: &str) -> Result<Self, Failure> {
        let lines: Vec<String> = text.lines().map(str::to_owned).collect();
        let text = &guarded(text);
        let value = yaml_value(text).map_err(|error| not_yaml(file, &lines, error))?;
        let root = MarkedYaml::load_from_str(text).ok().and_then(|documents| documents.first().map(Node::new));
        Ok(Self { file: file.into(), value: type_first(value), overrides: vec![], lines, root })
    }

    /// The text at `path`, or at the nearest part of the path that is in the file: a merged or included value has no
    /// place of its own. A value from an option, and one that an option made what it is, is at that option.
    pub fn place(&self, path: &[Step], at: At) -> Place {
        let mut option = self.overrides.iter().rev().find(|(overridden, _)| path.starts_with(overridden));
        let mut node = self.root.as_ref();
        let mut span = node.map(|node| node.span);
        for (i, step) in path.iter().enumerate() {
            let part = node.and_then(|node| node.parts.iter().find(|(part, ..)| part == step));
            let Some((_, key, value)) = part else {
                let within = |overridden: &[Step]| overridden.starts_with(&path[..=i]);
                option = option.or_else(|| self.overrides.iter().rev().find(|(overridden, _)| within(overridden)));
                break;
            };
            span = Some(if i + 1 == path.len() && at == At::Key { *key } else { value.span });
            node = Some(value);
        }
        match (option, span) {
            (Some((_, option)), _) => Place::Option(option.clone()),
            (None, Some(span)) => span_place(&self.file, &self.lines, span),
            (None, None) => Place::File(self.file.clone()),
        }
    }

    /// A mistake at `path`.
    pub fn mistake(&self, path: &[Step], at: At, message: impl Into<String>) -> Mistake {
        Mistake::new(Status::BadPipeline, message).at(self.place(path, at))
    }
}

/// The mistake of a text that is no YAML, in words of someone who writes it and with a way out that fits.
fn not_yaml(file: &Path, lines: &[String], error: serde_saphyr::Error) -> Mistake {
    let error = error.without_snippet();
    let mut told = error.to_string();
    let mut place = Place::File(file.into());
    if let Some(at) = error.location().filter(|at| at.line() > 0) {
        let (line, column) = (at.line() as usize, at.column() as usize);
        if let Some(end) = told.find(&format!(" at line {line}, column {column}")) {
            told.truncate(end);
        }
        place = span_place(file, lines, Span { line, column: column.max(1) - 1, length: 1 });
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
        (told, "a `:` or `#` inside a text needs quotes, and lines of one map the same indentation")
    };
    Mistake::new(Status::BadPipeline, format!("not valid YAML: {message}")).at(place).hint(hint)
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

/// `{pose}` as it passes through YAML, in as many characters: a private character for each brace.
const GUARDED_POSE: &str = "\u{e000}pose\u{e001}";

/// `text` in which `{pose}` is no YAML map, so that it needs no quotes: `[out/{pose}.obj, out/all.glb]`.
fn guarded(text: &str) -> String {
    text.replace("{pose}", GUARDED_POSE)
}

/// `value` with `{pose}` as it was written.
fn unguarded(value: Value) -> Value {
    let restore = |text: String| text.replace(GUARDED_POSE, "{pose}");
    match value {
        Value::String(text) => Value::String(restore(text)),
        Value::Array(list) => Value::Array(list.into_iter().map(unguarded).collect()),
        Value::Object(map) => {
            Value::Object(map.into_iter().map(|(key, value)| (restore(key), unguarded(value))).collect())
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

impl Node {
    fn new(yaml: &MarkedYaml<'_>) -> Self {
        let span = Span::new(yaml);
        let parts = match &yaml.data {
            YamlData::Mapping(map) => map
                .iter()
                .filter_map(|(key, value)| {
                    let YamlData::Value(Scalar::String(name)) = &key.data else { return None };
                    Some((Step::Key(name.to_string()), Span::new(key), Self::new(value)))
                })
                .collect(),
            YamlData::Sequence(list) => {
                list.iter().enumerate().map(|(i, value)| (Step::Index(i), Span::new(value), Self::new(value))).collect()
            }
            YamlData::Tagged(_, inner) => Self::new(inner).parts,
            _ => vec![],
        };
        Self { span, parts }
    }
}

impl Span {
    fn new(yaml: &MarkedYaml<'_>) -> Self {
        let (start, end) = (yaml.span.start, yaml.span.end);
        let length = if end.line() == start.line() { end.col().saturating_sub(start.col()) } else { usize::MAX };
        Self { line: start.line(), column: start.col(), length: length.max(1) }
    }
}

/// The place of a span; marks of a value that goes on in the next line end with the line.
fn span_place(file: &Path, lines: &[String], span: Span) -> Place {
    let text = lines.get(span.line.max(1) - 1).cloned().unwrap_or_default();
    let rest = text.chars().skip(span.column).collect::<String>().trim_end().chars().count();
    Place::Span {
        file: file.into(),
        line: span.line.max(1),
        column: span.column + 1,
        length: span.length.clamp(1, rest.max(1)),
        text: text.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(text: &str, keys: &[&str], at: At) -> (usize, usize, usize) {
        let document = Document::parse(Path::new("a.yaml"), text).unwrap();
        let path: Vec<_> = keys.iter().map(|key| Step::parse(key)).collect();
        match document.place(&path, at) {
            Place::Span { line, column, length, .. } => (line, column, length),
            other => panic!("expected a span, found {other:?}"),
        }
    }

    #[test]
    fn keys_and_values_are_found_in_both_notations() {
        let text = "# first\nsource: { rest: a.obj, poses: [b, cc] }\ntransfer:\n  type: gradient\n";
        assert_eq!(place(text, &["source"], At::Key), (2, 1, 6));
        assert_eq!(place(text, &["source", "rest"], At::Value), (2, 17, 5));
        assert_eq!(place(text, &["source", "poses", "1"], At::Value), (2, 35, 2));
        assert_eq!(place(text, &["transfer", "type"], At::Value), (4, 9, 8));
        assert_eq!(place(text, &["transfer", "type"], At::Key), (4, 3, 4));
    }

    #[test]
    fn the_pose_needs_no_quotes_in_a_list() {
        let text = "output: [out/{pose}.obj, all.glb]\ntruth: {pose}.ply\n";
        let document = Document::parse(Path::new("a.yaml"), text).unwrap();
        assert_eq!(document.value["output"][0], "out/{pose}.obj");
        assert_eq!(document.value["truth"], "{pose}.ply");
        assert_eq!(place(text, &["output", "1"], At::Value), (1, 26, 7));
    }

    #[test]
    fn what_is_not_in_the_file_is_at_its_nearest_parent() {
        let text = "source: { rest: a.obj }\n";
        assert_eq!(place(text, &["source", "poses", "3"], At::Value).0, 1);
        assert_eq!(place(text, &["target"], At::Value), (1, 1, 6 + 17));
    }

    #[test]
    fn values_of_a_merged_map_are_at_the_map_that_merges() {
        let text = "base: &b { type: x, k: 1 }\nother: { <<: *b, l: 2 }\n";
        let document = Document::parse(Path::new("a.yaml"), text).unwrap();
        assert_eq!(document.value["other"]["k"], 1);
        assert_eq!(place(text, &["other", "k"], At::Value).0, 2);
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
