//! Where the values of a document were written: a tree beside the tree of values, which goes along when values of several
//! files, of options and of variables are put together.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use indexmap::IndexMap;
use saphyr::{LoadableYamlNode, MarkedYaml, Scalar, YamlData};

use crate::{braces::restored, diagnostic::Location, limits::MAX_SHOWN, step::Step};

/// The text of a file.
#[derive(Debug)]
pub struct SourceText {
    /// The file, as messages name it.
    pub file: PathBuf,
    /// Its folder, which relative paths in it begin at.
    pub folder: Arc<Path>,
    /// Its lines.
    pub lines: Vec<String>,
    /// Whether messages may show its lines.
    pub is_shown: bool,
}

/// Line from 1, column from 0 and length, in characters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Span {
    /// The line.
    pub line: usize,
    /// The first character.
    pub column: usize,
    /// How many, at least 1.
    pub length: usize,
}

/// A place in what the user wrote.
#[derive(Clone, Debug)]
pub enum SourceSpan {
    /// In a file.
    Text(Arc<SourceText>, Span),
    /// A file as a whole.
    File(Arc<SourceText>),
    /// In a setting beside the files.
    Setting(Arc<str>),
    /// An argument of the host program.
    Argument(Arc<str>),
}

/// Where a value was written, and its parts.
#[derive(Clone, Debug)]
pub struct SpanTree {
    /// The value's place.
    pub span: SourceSpan,
    /// The folder that it begins at, if it is a relative path.
    pub folder: Arc<Path>,
    /// What is in it; what YAML merges into it with `<<` has no place of its own.
    pub parts: Parts,
}

/// The parts of a value, each found by its step.
#[derive(Clone, Debug, Default)]
pub struct Parts(IndexMap<Step, SpanEntry>);

/// A key or an item with its value.
#[derive(Clone, Debug)]
pub struct SpanEntry {
    /// The key, or the number of the item.
    pub step: Step,
    /// The key's place.
    pub key: SourceSpan,
    /// The value's.
    pub node: SpanTree,
}

impl SourceText {
    /// The text of `file`.
    pub fn new(file: &Path, text: &str) -> Arc<Self> {
        let folder = file.parent().unwrap_or(Path::new("")).into();
        let lines = text.lines().map(str::to_owned).collect();
        Arc::new(Self { file: file.into(), folder, lines, is_shown: true })
    }

    /// The text of `file`, which messages do not show: nobody wrote it for the pipeline.
    pub fn hidden(file: &Path) -> Arc<Self> {
        let folder = file.parent().unwrap_or(Path::new("")).into();
        Arc::new(Self { file: file.into(), folder, lines: vec![], is_shown: false })
    }

    /// A line from 1, if messages may show it and it is not too long for that.
    fn shown_line(&self, line: usize) -> Option<&str> {
        let line = self.lines.get(line.max(1) - 1).map(String::as_str)?;
        (self.is_shown && line.len() <= MAX_SHOWN).then_some(line)
    }
}

impl Span {
    fn new(yaml: &MarkedYaml<'_>) -> Self {
        let (start, end) = (yaml.span.start, yaml.span.end);
        let length = if end.line() == start.line() { end.col().saturating_sub(start.col()) } else { usize::MAX };
        Self { line: start.line(), column: start.col(), length: length.max(1) }
    }
}

impl SourceSpan {
    /// As a diagnostic tells it; marks of a value that goes on in the next line end with the line.
    pub fn location(&self) -> Location {
        match self {
            Self::Setting(option) => Location::Setting(option.to_string()),
            Self::Argument(argument) => Location::Argument(argument.to_string()),
            Self::File(text) => Location::File(text.file.clone()),
            Self::Text(text, span) => {
                let line = text.shown_line(span.line);
                let rest = line.map_or(usize::MAX, |line| {
                    line.chars().skip(span.column).collect::<String>().trim_end().chars().count()
                });
                // Of a line that is not shown the length of the rest is not known.
                let length = if line.is_none() && span.length == usize::MAX { 1 } else { span.length };
                Location::Span {
                    file: text.file.clone(),
                    line: span.line.max(1),
                    column: small(span.column + 1),
                    length: small(length.clamp(1, rest.max(1))),
                    text: line.unwrap_or_default().into(),
                }
            }
        }
    }

    /// Whether [`location`](Self::location) gives `place`.
    pub fn is_at(&self, place: &Location) -> bool {
        let may_be = match (self, place) {
            (Self::Text(text, span), Location::Span { file, line, column, .. }) => {
                *line == span.line.max(1) && *column == small(span.column + 1) && text.file == *file
            }
            (Self::Text(..), _) => false,
            _ => true,
        };
        may_be && self.location() == *place
    }

    /// The first place of `part` in a value written here, the value itself where it is written in other characters.
    pub fn within(&self, part: &str) -> Self {
        let Self::Text(text, span) = self else { return self.clone() };
        let line = text.shown_line(span.line).unwrap_or_default();
        let from = line.char_indices().nth(span.column).map_or(line.len(), |(i, _)| i);
        match line[from..].find(part) {
            Some(at) => {
                let column = span.column + line[from..from + at].chars().count();
                Self::Text(text.clone(), Span { column, length: part.chars().count(), ..*span })
            }
            None => self.clone(),
        }
    }
}

/// A column as messages have it; a line of more characters is cut.
fn small(column: usize) -> u32 {
    u32::try_from(column).unwrap_or(u32::MAX)
}

impl SpanTree {
    /// The places of a YAML text.
    pub fn of_yaml(text: &Arc<SourceText>, yaml: &str) -> Self {
        match MarkedYaml::load_from_str(yaml).ok().as_deref() {
            Some([first, ..]) => Self::new(text, first),
            _ => Self::leaf(SourceSpan::File(text.clone()), text.folder.clone()),
        }
    }

    /// Of a value whose parts have no places of their own.
    pub fn leaf(span: SourceSpan, folder: Arc<Path>) -> Self {
        Self { span, folder, parts: Parts::default() }
    }

    fn new(text: &Arc<SourceText>, yaml: &MarkedYaml<'_>) -> Self {
        let at = |yaml: &MarkedYaml<'_>| SourceSpan::Text(text.clone(), Span::new(yaml));
        let parts = match &yaml.data {
            YamlData::Mapping(map) => map
                .iter()
                .filter_map(|(key, value)| {
                    let name = match &key.data {
                        YamlData::Value(Scalar::String(name)) => restored(name),
                        YamlData::Value(Scalar::Integer(number)) => number.to_string(),
                        _ => return None,
                    };
                    Some(SpanEntry { step: Step::Key(name), key: at(key), node: Self::new(text, value) })
                })
                .collect(),
            YamlData::Sequence(list) => {
                let part = |(i, value): (usize, &MarkedYaml<'_>)| SpanEntry {
                    step: Step::Index(i),
                    key: at(value),
                    node: Self::new(text, value),
                };
                list.iter().enumerate().map(part).collect()
            }
            YamlData::Tagged(_, inner) => Self::new(text, inner).parts,
            _ => Parts::default(),
        };
        Self { span: at(yaml), folder: text.folder.clone(), parts }
    }

    /// Whether it, a part of it, or a key was written at `place`.
    pub fn has(&self, location: &Location) -> bool {
        self.span.is_at(location)
            || self.parts.into_iter().any(|part| part.key.is_at(location) || part.node.has(location))
    }

    /// A part, if it has a place of its own.
    pub fn part(&self, step: &Step) -> Option<&SpanEntry> {
        self.parts.0.get(step)
    }

    /// A part, to change it; one that has no place of its own gets that of the whole.
    pub fn part_mut(&mut self, step: &Step) -> &mut SpanEntry {
        let Self { span, folder, parts } = self;
        parts.0.entry(step.clone()).or_insert_with(|| {
            let node = Self::leaf(span.clone(), folder.clone());
            SpanEntry { step: step.clone(), key: span.clone(), node }
        })
    }

    /// Takes a part out; one that has no place of its own comes with that of the whole.
    pub fn take(&mut self, step: &Step) -> SpanEntry {
        self.parts.0.swap_remove(step).unwrap_or_else(|| {
            let node = Self::leaf(self.span.clone(), self.folder.clone());
            SpanEntry { step: step.clone(), key: self.span.clone(), node }
        })
    }

    /// Puts a part in the place of the one of its step, or beside the others.
    pub fn put(&mut self, part: SpanEntry) {
        self.parts.0.insert(part.step.clone(), part);
    }
}

impl FromIterator<SpanEntry> for Parts {
    fn from_iter<I: IntoIterator<Item = SpanEntry>>(parts: I) -> Self {
        Self(parts.into_iter().map(|part| (part.step.clone(), part)).collect())
    }
}

impl<'a> IntoIterator for &'a Parts {
    type Item = &'a SpanEntry;
    type IntoIter = indexmap::map::Values<'a, Step, SpanEntry>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.values()
    }
}
