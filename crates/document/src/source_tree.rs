//! Where the values of a document were written: a tree beside the tree of values, which goes along when values of several
//! files, of options and of variables are put together.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use saphyr::{LoadableYamlNode, MarkedYaml, Scalar, YamlData};

use crate::{braces::restored, diagnostic::Location, step::Step};

/// The text of a file.
#[derive(Debug)]
pub struct SourceText {
    /// The file, as messages name it.
    pub file: PathBuf,
    /// Its folder, which relative paths in it begin at.
    pub folder: Arc<Path>,
    /// Its lines.
    pub lines: Vec<String>,
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
    pub parts: Vec<SpanEntry>,
}

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
        Arc::new(Self { file: file.into(), folder, lines: text.lines().map(str::to_owned).collect() })
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
                let line = text.lines.get(span.line.max(1) - 1).cloned().unwrap_or_default();
                let rest = line.chars().skip(span.column).collect::<String>().trim_end().chars().count();
                Location::Span {
                    file: text.file.clone(),
                    line: span.line.max(1),
                    column: small(span.column + 1),
                    length: small(span.length.clamp(1, rest.max(1))),
                    text: line.into(),
                }
            }
        }
    }

    /// The first place of `part` in a value written here, the value itself where it is written in other characters.
    pub fn within(&self, part: &str) -> Self {
        let Self::Text(text, span) = self else { return self.clone() };
        let line = text.lines.get(span.line.max(1) - 1).map_or("", String::as_str);
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
        Self { span, folder, parts: vec![] }
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
            _ => vec![],
        };
        Self { span: at(yaml), folder: text.folder.clone(), parts }
    }

    /// Whether it, a part of it, or a key was written at `place`.
    pub fn has(&self, location: &Location) -> bool {
        self.span.location() == *location
            || self.parts.iter().any(|part| part.key.location() == *location || part.node.has(location))
    }

    /// A part, if it has a place of its own.
    pub fn part(&self, step: &Step) -> Option<&SpanEntry> {
        self.parts.iter().find(|part| part.step == *step)
    }

    /// A part, to change it; one that has no place of its own gets that of the whole.
    pub fn part_mut(&mut self, step: &Step) -> &mut SpanEntry {
        let i = self.parts.iter().position(|part| part.step == *step).unwrap_or_else(|| {
            let node = Self::leaf(self.span.clone(), self.folder.clone());
            self.parts.push(SpanEntry { step: step.clone(), key: self.span.clone(), node });
            self.parts.len() - 1
        });
        &mut self.parts[i]
    }

    /// Takes a part out; one that has no place of its own comes with that of the whole.
    pub fn take(&mut self, step: &Step) -> SpanEntry {
        self.part_mut(step);
        let i = self.parts.iter().position(|part| part.step == *step).unwrap_or_default();
        self.parts.remove(i)
    }

    /// Puts a part in the place of the one of its step, or beside the others.
    pub fn put(&mut self, part: SpanEntry) {
        match self.parts.iter_mut().find(|other| other.step == part.step) {
            Some(other) => *other = part,
            None => self.parts.push(part),
        }
    }
}
