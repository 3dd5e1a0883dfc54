//! What all notations share: texts without their byte order mark, and numbers as people write them.

use std::path::Path;

use crate::diagnostic::{self, Diagnostic, Location, Result};

/// What is wrong with a word, and the way out.
#[derive(Clone, Debug, PartialEq)]
pub struct Wrong {
    /// Expected and found.
    pub message: String,
    /// The way out.
    pub hint: String,
}

impl Wrong {
    /// As a diagnostic in a file of data.
    pub fn at(self, location: Location) -> Diagnostic {
        Diagnostic::new(crate::diagnostic::Kind::BadData, self.message).at(location).hint(self.hint)
    }
}

/// The text of `file`, without the mark that some editors put before it.
///
/// # Errors
///
/// If it cannot be read.
pub fn read(file: &Path) -> Result<String> {
    let text = diagnostic::read_text(file)?;
    Ok(match text.strip_prefix('\u{feff}') {
        Some(rest) => rest.to_owned(),
        None => text,
    })
}

/// `text` without its byte order mark.
pub fn without_mark(text: &str) -> &str {
    text.strip_prefix('\u{feff}').unwrap_or(text)
}

/// The beginning of `text`, as messages quote it.
pub fn shorten(text: &str) -> String {
    match text.char_indices().nth(40) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.into(),
    }
}

/// A finite number.
///
/// # Errors
///
/// What it is instead.
pub fn number(text: &str) -> std::result::Result<f64, Wrong> {
    let message = if text.is_empty() {
        "expected a number, found nothing".into()
    } else {
        format!("expected a number, found `{}`", shorten(text))
    };
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(_) => Err(Wrong { message, hint: "give the point a finite place, or remove it".into() }),
        Err(_) if is_decimal_comma(text) => {
            let hint = format!("write decimals with a point: `{}`", text.replace(',', "."));
            Err(Wrong { message, hint })
        }
        Err(_) => Err(Wrong { message, hint: "coordinates are numbers such as `0.25` or `-1e-3`".into() }),
    }
}

/// The number of a vertex or a triangle.
///
/// # Errors
///
/// What it is instead.
pub fn index(text: &str, what: &str) -> std::result::Result<u32, Wrong> {
    text.parse().map_err(|_| {
        let found = if text.is_empty() { "nothing".into() } else { format!("`{}`", shorten(text)) };
        let hint = match text.parse::<f64>() {
            Ok(value) if value < 0.0 => "the first one is 0; negative numbers count nothing here".into(),
            Ok(value) if value.fract() == 0.0 && value <= f64::from(u32::MAX) => {
                format!("write it without decimals: `{value:.0}`")
            }
            Ok(_) => format!("a {what} has a whole number; a place between them is given by x, y and z"),
            Err(_) if is_decimal_comma(text) => format!("a {what} has a whole number, without a decimal comma"),
            Err(_) => format!("a {what} has a whole number from 0"),
        };
        Wrong { message: format!("expected the number of a {what}, found {found}"), hint }
    })
}

/// Whether `text` is a number with a comma in place of the decimal point.
fn is_decimal_comma(text: &str) -> bool {
    text.matches(',').count() == 1 && text.replace(',', ".").parse::<f64>().is_ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_tell_decimal_commas_and_what_is_no_number() {
        assert_eq!(number("-1e-3"), Ok(-1e-3));
        let hint = |text: &str| number(text).unwrap_err().hint;
        assert_eq!(hint("1,5"), "write decimals with a point: `1.5`");
        assert_eq!(hint("nan"), "give the point a finite place, or remove it");
        assert_eq!(number("x").unwrap_err().message, "expected a number, found `x`");
    }

    #[test]
    fn numbers_of_vertices_are_whole() {
        assert_eq!(index("7", "vertex"), Ok(7));
        assert_eq!(index("7.0", "vertex").unwrap_err().hint, "write it without decimals: `7`");
        assert_eq!(index("-7", "vertex").unwrap_err().message, "expected the number of a vertex, found `-7`");
        assert!(index("0.5", "vertex").unwrap_err().hint.contains("x, y and z"));
    }
}
