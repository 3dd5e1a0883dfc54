//! Texts of marker files: errors in them, their lines, and numbers as people write them.

use std::path::Path;

use nalgebra::Point3;

use mimesh_core::mesh::bounding_box;
use mimesh_document::{Diagnostic, Kind, Location, Result};

/// Barycentric coordinates may miss their sum of 1 by this, as they are rounded in files.
const SUM_TOLERANCE: f64 = 1e-6;
/// Barycentric coordinates on an edge may be rounded below zero by this.
const NEGATIVE_TOLERANCE: f64 = -1e-9;
/// Messages quote this many characters of a text at most.
const MAX_QUOTED: usize = 40;

/// A part of a file that is not understood.
#[derive(Clone, Debug, PartialEq)]
pub struct ParseError {
    /// The expected and the found value.
    pub message: String,
    /// The way out.
    pub hint: String,
}

impl ParseError {
    /// An error with its way out.
    pub fn new(message: impl Into<String>, hint: impl Into<String>) -> Self {
        Self { message: message.into(), hint: hint.into() }
    }

    /// The error as a diagnostic in a file of data.
    pub fn at(self, location: Location) -> Diagnostic {
        Diagnostic::new(Kind::BadData, self.message).at(location).hint(self.hint)
    }
}

/// Reads the text of `file` without its byte order mark.
///
/// # Errors
///
/// If it cannot be read, or is not UTF-8.
pub fn read(file: &Path) -> Result<String> {
    let text = mimesh_document::files::read_text(file)?;
    Ok(strip_bom(&text).to_owned())
}

/// `text` without the byte order mark that some editors put before it.
pub fn strip_bom(text: &str) -> &str {
    text.strip_prefix('\u{feff}').unwrap_or(text)
}

/// The beginning of `text`, as messages quote it.
pub fn shorten(text: &str) -> String {
    match text.char_indices().nth(MAX_QUOTED) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.into(),
    }
}

/// `text` between backticks as messages quote it, or `nothing`.
pub fn quoted(text: &str) -> String {
    if text.is_empty() { "nothing".into() } else { format!("`{}`", shorten(text)) }
}

/// ` (line 7)`, or nothing if the line is not known.
pub fn in_line(location: Option<&Location>) -> String {
    match location {
        Some(Location::Line { line, .. } | Location::Span { line, .. }) => format!(" (line {line})"),
        _ => String::new(),
    }
}

/// The beginnings of the lines of a text.
#[derive(Clone, Debug)]
pub struct Lines {
    beginnings: Vec<usize>,
}

impl Lines {
    /// The lines of `text`.
    pub fn new(text: &str) -> Self {
        let after_breaks = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n').map(|(i, _)| i + 1);
        Self { beginnings: std::iter::once(0).chain(after_breaks).collect() }
    }

    /// The line, from 1, of the byte `offset`.
    pub fn line(&self, offset: usize) -> usize {
        self.beginnings.partition_point(|beginning| *beginning <= offset)
    }
}

/// Parses a finite number.
///
/// # Errors
///
/// If `text` is no number, or not finite.
pub fn number(text: &str) -> std::result::Result<f64, ParseError> {
    let hint = match text.parse::<f64>() {
        Ok(value) if value.is_finite() => return Ok(value),
        Ok(_) => "give the point a finite position, or remove it".into(),
        Err(_) if is_decimal_comma(text) => format!("write decimals with a point: `{}`", text.replace(',', ".")),
        Err(_) => "coordinates are numbers such as `0.25` or `-1e-3`".into(),
    };
    Err(ParseError { message: format!("expected a number, found {}", quoted(text)), hint })
}

/// Parses the number of a vertex or a triangle, which `kind` names.
///
/// # Errors
///
/// If `text` is no whole number from 0.
pub fn index(text: &str, kind: &str) -> std::result::Result<u32, ParseError> {
    if let Ok(index) = text.parse() {
        return Ok(index);
    }
    let hint = match text.parse::<f64>() {
        Ok(value) if value < 0.0 => "numbers count from 0; no vertex and no triangle has a negative one".into(),
        Ok(value) if value.fract() == 0.0 && value <= f64::from(u32::MAX) => {
            format!("write it without decimals: `{value:.0}`")
        }
        Ok(_) => format!("a {kind} has a whole number; a place between them is given by x, y and z"),
        Err(_) if is_decimal_comma(text) => format!("a {kind} has a whole number, without a decimal comma"),
        Err(_) => format!("a {kind} has a whole number from 0"),
    };
    Err(ParseError { message: format!("expected the number of a {kind}, found {}", quoted(text)), hint })
}

/// Whether `text` is a number with a comma in place of the decimal point.
fn is_decimal_comma(text: &str) -> bool {
    text.matches(',').count() == 1 && text.replace(',', ".").parse::<f64>().is_ok()
}

/// Three barycentric coordinates of a point in its triangle.
///
/// # Errors
///
/// In words, if there are not three, their sum is not 1, or one is negative.
pub fn barycentric(values: &[f64]) -> std::result::Result<[f64; 3], String> {
    let Ok(values) = <[f64; 3]>::try_from(values) else {
        return Err(format!("expected three barycentric coordinates, found {}", values.len()));
    };
    let sum: f64 = values.iter().sum();
    if sum.is_nan() || (sum - 1.0).abs() > SUM_TOLERANCE {
        return Err(format!("barycentric coordinates sum to {sum}, expected 1"));
    }
    match values.iter().find(|value| **value < NEGATIVE_TOLERANCE) {
        Some(value) => Err(format!("barycentric coordinate {value} is negative: the point lies outside the triangle")),
        None => Ok(values),
    }
}

/// The bounding box of `positions` in words.
pub fn extent(positions: &[Point3<f64>]) -> String {
    let (low, high) = bounding_box(positions);
    let axes = ["x", "y", "z"].into_iter().enumerate();
    let ranges: Vec<_> = axes.map(|(k, axis)| format!("{axis} {} to {}", rounded(low[k]), rounded(high[k]))).collect();
    ranges.join(", ")
}

/// `value` with three digits or so.
pub fn rounded(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let magnitude = value.abs().log10().floor() as i32;
    if !(-5..9).contains(&magnitude) {
        return format!("{value:.2e}");
    }
    let digits = (2 - magnitude).clamp(0, 8) as usize;
    let text = format!("{value:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_report_decimal_commas_and_what_is_no_number() {
        assert_eq!(number("-1e-3"), Ok(-1e-3));
        assert_eq!(number("1,5").unwrap_err().hint, "write decimals with a point: `1.5`");
        assert_eq!(number("nan").unwrap_err().hint, "give the point a finite position, or remove it");
        assert_eq!(number("x").unwrap_err().message, "expected a number, found `x`");
        assert_eq!(number("").unwrap_err().message, "expected a number, found nothing");
    }

    #[test]
    fn numbers_of_vertices_are_whole() {
        assert_eq!(index("7", "vertex"), Ok(7));
        assert_eq!(index("7.0", "vertex").unwrap_err().hint, "write it without decimals: `7`");
        assert_eq!(index("-7", "vertex").unwrap_err().message, "expected the number of a vertex, found `-7`");
        assert!(index("0.5", "vertex").unwrap_err().hint.contains("x, y and z"));
    }

    #[test]
    fn lines_are_found_by_their_bytes() {
        let lines = Lines::new("a\n\nbc\r\nd");
        assert_eq!([0, 1, 2, 3, 4, 7, 8].map(|offset| lines.line(offset)), [1, 1, 2, 3, 3, 4, 4]);
    }

    #[test]
    fn numbers_in_messages_have_three_digits() {
        let texts = [0.0, 1.0, 0.96592, -3.0, 109.4, 12345.6, 1e-7].map(rounded);
        assert_eq!(texts, ["0", "1", "0.966", "-3", "109", "12346", "1.00e-7"]);
    }
}
