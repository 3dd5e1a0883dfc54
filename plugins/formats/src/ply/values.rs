//! The numbers of a PLY one after another, whatever its encoding.

use std::path::Path;

use mimesh_core::{Error, Result};

use super::{
    Encoding,
    header::{Element, Header, Scalar},
};
use crate::names::shown;

/// Walks over the numbers after a header. Entries of a text may take several lines, or share one.
pub struct Values<'a> {
    path: &'a Path,
    bytes: &'a [u8],
    at: usize,
    encoding: Encoding,
    /// The line of the byte at hand, in a text.
    line: usize,
}

impl<'a> Values<'a> {
    /// The numbers of `bytes` after `header`.
    pub fn new(path: &'a Path, bytes: &'a [u8], header: &Header) -> Self {
        Self { path, bytes, at: header.end, encoding: header.encoding, line: header.lines + 1 }
    }

    /// The next number, which is of `entry` of `element`.
    ///
    /// # Errors
    ///
    /// [`Error::File`] if there is none.
    pub fn next(&mut self, scalar: Scalar, element: &str, entry: usize) -> Result<f64> {
        if self.encoding == Encoding::Ascii {
            return self.word(element, entry);
        }
        let size = scalar.size();
        let Some(bytes) = self.bytes.get(self.at..self.at + size) else {
            return Err(self.wrong(format!("the file ends in {element} {entry} (from 0)")));
        };
        self.at += size;
        let mut ordered = [0; 8];
        ordered[..size].copy_from_slice(bytes);
        if self.encoding == Encoding::BinaryBigEndian {
            ordered[..size].reverse();
        }
        let [a, b, c, d, ..] = ordered;
        Ok(match scalar {
            Scalar::I8 => f64::from(a as i8),
            Scalar::U8 => f64::from(a),
            Scalar::I16 => f64::from(i16::from_le_bytes([a, b])),
            Scalar::U16 => f64::from(u16::from_le_bytes([a, b])),
            Scalar::I32 => f64::from(i32::from_le_bytes([a, b, c, d])),
            Scalar::U32 => f64::from(u32::from_le_bytes([a, b, c, d])),
            Scalar::F32 => f64::from(f32::from_le_bytes([a, b, c, d])),
            Scalar::F64 => f64::from_le_bytes(ordered),
        })
    }

    /// Checks that the entries of `element` can be in what is left of the file, before room is made for them.
    ///
    /// # Errors
    ///
    /// [`Error::File`] with both counts.
    pub fn check_room(&self, element: &Element) -> Result<()> {
        // In a text a number takes a digit and a blank; the last blank may be missing.
        let least = |scalar: Scalar| if self.encoding == Encoding::Ascii { 2 } else { scalar.size() };
        let least: usize = element.properties.iter().map(|p| least(p.list.unwrap_or(p.scalar))).sum();
        let left = self.bytes.len() - self.at;
        if element.count.saturating_mul(least) <= left.saturating_add(1) {
            return Ok(());
        }
        let Element { name, count, .. } = element;
        Err(self.wrong(format!(
            "the header counts {count} {name} entries of at least {least} bytes each, the file has {left} bytes for them"
        )))
    }

    /// Checks that nothing is left; bytes that are no entries are a warning.
    ///
    /// # Errors
    ///
    /// [`Error::File`] if numbers follow in a text: its entries are more, or have more numbers, than its header says.
    pub fn finish(mut self, warnings: &mut Vec<String>) -> Result<()> {
        let line = self.line;
        if self.encoding == Encoding::Ascii {
            self.skip_blanks();
        }
        match self.bytes.len() - self.at {
            0 => {}
            _ if self.encoding == Encoding::Ascii && self.line == line => {
                return Err(self.wrong("the entries have more numbers than the header has properties".into()));
            }
            _ if self.encoding == Encoding::Ascii && self.word("", 0).is_ok() => {
                return Err(self.wrong("the file has more entries than the header counts".into()));
            }
            left => warnings.push(format!(
                "{left} bytes after the last entry are not read: if the header's counts are too low, entries are missing"
            )),
        }
        Ok(())
    }

    fn skip_blanks(&mut self) {
        while let Some(byte) = self.bytes.get(self.at).filter(|byte| byte.is_ascii_whitespace() || **byte == 0) {
            let ends_line = *byte == b'\n' || (*byte == b'\r' && self.bytes.get(self.at + 1) != Some(&b'\n'));
            self.line += usize::from(ends_line);
            self.at += 1;
        }
    }

    fn word(&mut self, element: &str, entry: usize) -> Result<f64> {
        self.skip_blanks();
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        let word = &rest[..length];
        if word.is_empty() {
            return Err(self.wrong(format!("the file ends in {element} {entry} (from 0)")));
        }
        let text = std::str::from_utf8(word).unwrap_or_default();
        // Old C libraries write 1.#QNAN and -1.#IND for what is no number.
        let number = if text.contains('#') { Some(f64::NAN) } else { text.parse().ok() };
        let number = number.ok_or_else(|| {
            let word = String::from_utf8_lossy(word);
            self.wrong(format!("`{}` of {element} {entry} (from 0) is no number", shown(&word)))
        })?;
        self.at += length;
        Ok(number)
    }

    /// The error `message` at the byte at hand.
    pub fn wrong(&self, message: String) -> Error {
        let hint = "the file is damaged or cut short: export it again";
        let message = format!("not a PLY: {message}");
        match self.encoding {
            Encoding::Ascii => Error::line(self.path, self.line, message, hint),
            _ => Error::file(self.path, message, hint),
        }
    }
}
