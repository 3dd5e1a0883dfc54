//! The header of a PLY: what stands in the file, in which order and as what.

use std::{collections::HashSet, path::Path};

use mimesh_core::{Error, Result};

use super::Encoding;
use crate::names::shown;

/// The header of a file.
#[derive(Debug)]
pub struct Header {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
    /// The image that faces show, if a comment names one.
    pub texture: Option<String>,
    /// Where the entries begin.
    pub end: usize,
    /// The lines before them.
    pub lines: usize,
}

/// A kind of entries.
#[derive(Debug)]
pub struct Element {
    pub name: String,
    pub count: usize,
    pub properties: Vec<Property>,
}

/// A number, or a list of numbers, of every entry.
#[derive(Debug)]
pub struct Property {
    pub name: String,
    pub scalar: Scalar,
    /// The type of the length, if it is a list.
    pub list: Option<Scalar>,
}

/// A type of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn new(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    /// The bytes of a number.
    pub fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// The number that stands for all of a colour; `None` if a colour is not stored like that.
    pub fn full(self) -> Option<f64> {
        match self {
            Self::U8 => Some(255.0),
            Self::U16 => Some(65535.0),
            Self::F32 | Self::F64 => Some(1.0),
            _ => None,
        }
    }
}

impl Header {
    /// Reads the header of `bytes`; `path` is for messages.
    ///
    /// # Errors
    ///
    /// [`Error::File`] at the line that is not understood.
    pub fn read(path: &Path, bytes: &[u8]) -> Result<Self> {
        let mut header = Self { encoding: Encoding::Ascii, elements: Vec::new(), texture: None, end: 0, lines: 0 };
        let mut has_format = false;
        // Of properties, with the number of their element.
        let mut names = HashSet::new();
        loop {
            let Some(line) = header.line(bytes) else {
                let message = if header.lines == 0 { "it does not begin with `ply`" } else { "no `end_header`" };
                return Err(damaged(path, header.lines.max(1), message));
            };
            let wrong = |message: String| damaged(path, header.lines, &message);
            let words: Vec<&str> = line.split_ascii_whitespace().collect();
            match words[..] {
                ["ply"] if header.lines == 1 => {}
                _ if header.lines == 1 => return Err(wrong("it does not begin with `ply`".into())),
                ["format", ..] if has_format => return Err(wrong("a second `format`".into())),
                ["format", _, version] if version != "1.0" && version != "1" => {
                    return Err(wrong(format!("version `{}`, expected 1.0", shown(version))));
                }
                ["format", name, _] => {
                    header.encoding =
                        Encoding::named(name).ok_or_else(|| wrong(format!("no format `{}`", shown(name))))?;
                    has_format = true;
                }
                ["comment", "TextureFile", ..] => {
                    header.texture = line.split_once("TextureFile").map(|(_, name)| name.trim().to_owned());
                }
                [] | ["comment" | "obj_info", ..] => {}
                ["element", name, count] => {
                    let name = shown(name);
                    if is_read(&name) && header.elements.iter().any(|element| element.name == name) {
                        return Err(wrong(format!("a second element `{name}`")));
                    }
                    let count = count
                        .parse()
                        .map_err(|_| wrong(format!("`{}` is no count of {name} entries", shown(count))))?;
                    header.elements.push(Element { name, count, properties: Vec::new() });
                }
                ["property", ref rest @ ..] => {
                    let property =
                        property(rest).ok_or_else(|| wrong(format!("`{}` is no property", shown(line.trim()))))?;
                    let elements = header.elements.len();
                    let Some(element) = header.elements.last_mut() else {
                        return Err(wrong("a property before any element".into()));
                    };
                    // Both are the corners of a face.
                    let name = if property.name == "vertex_index" { "vertex_indices" } else { &property.name };
                    if !names.insert((elements, name.to_owned())) && is_read(&element.name) {
                        return Err(wrong(format!(
                            "a second property `{}` of {}",
                            shown(&property.name),
                            element.name
                        )));
                    }
                    element.properties.push(property);
                }
                ["end_header"] if has_format && bytes[header.end..].starts_with(b"end_header") => {
                    return Err(wrong("a second `end_header`".into()));
                }
                ["end_header"] if has_format => return Ok(header),
                ["end_header"] => return Err(wrong("no `format`".into())),
                _ => return Err(wrong(format!("`{}` has no place in a header", shown(line.trim())))),
            }
        }
    }

    /// The next line of the header.
    fn line<'a>(&mut self, bytes: &'a [u8]) -> Option<std::borrow::Cow<'a, str>> {
        let rest = &bytes[self.end..];
        // A header ends long before this; a binary file without line ends would be one line.
        let length = rest.iter().take(1 << 16).position(|b| matches!(b, b'\n' | b'\r'))?;
        let line = rest[..length].strip_prefix(b"\xef\xbb\xbf").unwrap_or(&rest[..length]);
        let ends_in_two = rest[length..].starts_with(b"\r\n");
        self.end += length + if ends_in_two { 2 } else { 1 };
        self.lines += 1;
        Some(String::from_utf8_lossy(line))
    }
}

/// Whether entries of this name are read.
fn is_read(element: &str) -> bool {
    matches!(element, "vertex" | "face" | "tristrips")
}

fn property(words: &[&str]) -> Option<Property> {
    Some(match words {
        ["list", length, scalar, name] => {
            Property { name: (*name).into(), scalar: Scalar::new(scalar)?, list: Some(Scalar::new(length)?) }
        }
        [scalar, name] => Property { name: (*name).into(), scalar: Scalar::new(scalar)?, list: None },
        _ => return None,
    })
}

fn damaged(path: &Path, line: usize, message: &str) -> Error {
    let hint = "the file is damaged or cut short: export it again";
    Error::line(path, line, format!("not a PLY: {message}"), hint)
}
