//! A YAML file: its values, and where each of them stands.
//!
//! serde-saphyr gives the values, with aliases and merge keys resolved; saphyr gives the locations in the same text. What
//! deserialises a value only knows the path to it (`transfer.type`), and [`Document::location`] finds the text for the
//! path.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use serde_json::Value;

use crate::{
    braces::guarded,
    diagnostic::{Diagnostic, Diagnostics, Kind, Location},
    files::read_text_up_to,
    limits::{MAX_STRING_BYTES, MAX_YAML_BYTES, thousands},
    source_tree::{SourceSpan, SourceText, SpanEntry, SpanTree},
    step::Step,
    yaml::{not_yaml, too_long, type_first, yaml_value},
};

/// A YAML file, parsed but not yet understood; once composed, with what it includes.
#[derive(Clone, Debug)]
pub struct Document {
    /// The file, as messages name it.
    pub file: PathBuf,
    /// Its contents; in every map `type` comes first.
    pub value: Value,
    /// Where they were written.
    pub root: SpanTree,
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
        Self::parse(file, &read_text_up_to(file, MAX_YAML_BYTES as u64)?)
    }

    /// Parses the text of `file`.
    ///
    /// # Errors
    ///
    /// If it is no YAML.
    pub fn parse(file: &Path, text: &str) -> Result<Self, Diagnostics> {
        Self::parse_as(SourceText::new(file, text), text)
    }

    /// Parses a text whose lines no message shows.
    ///
    /// # Errors
    ///
    /// If it is no YAML.
    pub fn parse_hidden(file: &Path, text: &str) -> Result<Self, Diagnostics> {
        Self::parse_as(SourceText::hidden(file), text)
    }

    fn parse_as(whole: Arc<SourceText>, text: &str) -> Result<Self, Diagnostics> {
        if let Some(diagnostic) = too_long(&whole.file, text) {
            return Err(diagnostic.into());
        }
        let text = &guarded(text);
        let value = yaml_value(text).map_err(|error| not_yaml(&whole, error))?;
        Ok(Self { file: whole.file.clone(), value: type_first(value), root: SpanTree::of_yaml(&whole, text) })
    }

    /// The text at `path`, or at the nearest part of the path that is in the file: a merged value has no place of its own. A
    /// value from an option, and one that an option made what it is, is at that option.
    pub fn location(&self, path: &[Step], at: At) -> Location {
        self.span(path, at).location()
    }

    /// The same, not yet put into words.
    pub fn span(&self, path: &[Step], at: At) -> &SourceSpan {
        let (mut node, mut span) = (&self.root, &self.root.span);
        for (i, step) in path.iter().enumerate() {
            let Some(part) = node.part(step) else { break };
            span = if i + 1 == path.len() && at == At::Key { &part.key } else { &part.node.span };
            node = &part.node;
        }
        span
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

    /// The value at `path`, to change it.
    pub fn get_mut(&mut self, path: &[Step]) -> Option<&mut Value> {
        path.iter().try_fold(&mut self.value, |value, step| step.get_mut(value))
    }

    /// Takes a key of the whole out, with its places.
    pub fn take(&mut self, key: &str) -> Option<(Value, SpanEntry)> {
        let value = self.value.as_object_mut()?.shift_remove(key)?;
        Some((value, self.root.take(&Step::Key(key.into()))))
    }

    /// A diagnostic for each key and each text that can be no path, name or pattern: it is longer, or has a zero character.
    pub fn long_texts(&self) -> Diagnostics {
        let mut diagnostics = Diagnostics::default();
        long_texts(&self.value, &self.root, &mut diagnostics);
        diagnostics
    }

    /// A diagnostic at `path`.
    pub fn diagnostic(&self, path: &[Step], at: At, message: impl Into<String>) -> Diagnostic {
        Diagnostic::new(Kind::BadPipeline, message).at(self.location(path, at))
    }
}

fn long_texts(value: &Value, node: &SpanTree, diagnostics: &mut Diagnostics) {
    let check = |what: &str, text: &str, span: &SourceSpan| {
        let (found, most) = (thousands(text.len()), thousands(MAX_STRING_BYTES));
        let message = format!("{what} has {found} bytes, expected {most} at most");
        let diagnostic = Diagnostic::new(Kind::BadPipeline, message).at(span.location());
        if text.contains('\0') {
            let diagnostic = Diagnostic::new(Kind::BadPipeline, format!("{what} has a zero character"));
            return Some(diagnostic.at(span.location()).hint("no path and no name can have it; leave it out"));
        }
        (text.len() > MAX_STRING_BYTES).then(|| diagnostic.hint("no path and no name is longer; write a shorter one"))
    };
    match value {
        Value::String(text) => diagnostics.extend(check("the text", text, &node.span)),
        Value::Object(map) => {
            for (key, value) in map {
                let part = node.part(&Step::Key(key.clone()));
                diagnostics.extend(check("the key", key, part.map_or(&node.span, |part| &part.key)));
                long_texts(value, part.map_or(node, |part| &part.node), diagnostics);
            }
        }
        Value::Array(list) => {
            for (i, value) in list.iter().enumerate() {
                long_texts(value, node.part(&Step::Index(i)).map_or(node, |part| &part.node), diagnostics);
            }
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn location(text: &str, keys: &[&str], at: At) -> (usize, usize, usize) {
        let document = Document::parse(Path::new("a.yaml"), text).unwrap();
        let path: Vec<_> = keys.iter().map(|key| Step::parse(key)).collect();
        match document.location(&path, at) {
            Location::Span { line, column, length, .. } => (line, column as usize, length as usize),
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

    #[test]
    fn texts_that_no_path_and_no_name_can_be_are_found_at_their_places() {
        let long = "x".repeat(4097);
        let document = Document::parse(Path::new("a.yaml"), &format!("a: [y,\n  {long}]\n? {long}\n: 1\n")).unwrap();
        let found: Vec<_> = document.long_texts().list.iter().map(|one| one.to_string()).collect();
        assert_eq!(found.len(), 2, "{found:?}");
        assert!(found[0].starts_with("a.yaml:2:3: the text has 4,097 bytes, expected 4,096 at most"), "{found:?}");
        assert!(found[1].starts_with("a.yaml:3:3: the key has 4,097 bytes"), "{found:?}");
    }

    #[test]
    fn texts_that_ask_for_more_than_a_file_may_are_told_the_limit() {
        let told = |text: &str| Document::parse(Path::new("a.yaml"), text).unwrap_err().to_string();
        let aliases: String =
            (1..10).map(|i| format!("a{i}: &a{i} [{}]\n", vec![format!("*a{}", i - 1); 10].join(", "))).collect();
        let deep = "more than 64 deep";
        for (text, expected) in [
            (format!("a0: &a0 [x]\n{aliases}"), "250,000 values"),
            (format!("a: {}", "[".repeat(100_000)), deep),
            (format!("a: {}1{}", "[".repeat(100), "]".repeat(100)), deep),
            ((0..200).map(|i| format!("{}a:\n", " ".repeat(i))).collect(), deep),
            (format!("a: [{}]", "1, ".repeat(300_000)), "250,000 values"),
            (format!("# {}\n", "x".repeat(5 << 20)), "4,194,304 at most"),
            ("a: 1e999\n".into(), "expected a finite number"),
            ("a: [.inf]\n".into(), "expected a finite number"),
        ] {
            let found = told(&text);
            assert!(found.contains(expected) && found.contains("hint: "), "{found}");
            assert!(found.starts_with("error: a.yaml"), "{found}");
        }
    }
}
