//! JSON texts as values, with messages for frequent slips.

use jsonc_parser::{
    ParseOptions,
    ParseStringErrorKind::UnterminatedStringLiteral,
    ast::{Object, Value},
    common::Ranged,
    errors::ParseErrorKind,
    parse_to_ast,
};

use crate::text::{ParseError, shorten};

/// An error at a byte of the text.
type Located = (usize, ParseError);

/// Parses `text`; no name comes twice in a mapping.
///
/// # Errors
///
/// The first place that is no JSON, as a byte of the text, and what was expected and found there.
pub fn parse(text: &str) -> Result<Value<'_>, Located> {
    let options = ParseOptions {
        allow_comments: false,
        allow_loose_object_property_names: false,
        allow_trailing_commas: false,
        allow_missing_commas: false,
        allow_single_quoted_strings: false,
        allow_hexadecimal_numbers: false,
        allow_unary_plus_numbers: true,
        allow_bare_decimal_point_numbers: true,
        allow_non_finite_numbers: false,
        allow_extended_string_escapes: false,
    };
    let result = parse_to_ast(text, &Default::default(), &options)
        .map_err(|error| explain(text, error.kind(), error.range().start))?;
    let value = result.value.ok_or_else(|| not_a_value(text, text.len()))?;
    check_names(&value)?;
    Ok(value)
}

/// The value in words, for messages.
pub fn describe(value: &Value<'_>) -> String {
    match value {
        Value::NumberLit(number) => number.value.into(),
        Value::StringLit(string) => format!("the string `{}`", shorten(&string.value)),
        Value::BooleanLit(boolean) => boolean.value.to_string(),
        Value::NullKeyword(_) => "null".into(),
        Value::Array(array) if array.elements.len() < 9 && array.elements.iter().all(is_number) => {
            let items: Vec<_> = array.elements.iter().map(describe).collect();
            format!("[{}]", items.join(", "))
        }
        Value::Array(array) => format!("a sequence of {}", array.elements.len()),
        Value::Object(object) => {
            let keys: Vec<_> = object.properties.iter().take(4).map(|property| property.name.as_str()).collect();
            format!("a mapping with the keys {}", shorten(&keys.join(", ")))
        }
    }
}

/// Whether `value` is written as a number.
pub fn is_number(value: &Value<'_>) -> bool {
    matches!(value, Value::NumberLit(_))
}

/// The value as a finite number.
pub fn number(value: &Value<'_>) -> Option<f64> {
    value.as_number_lit()?.value.parse().ok().filter(|number: &f64| number.is_finite())
}

/// Whether `value` is a number without decimals and exponent.
pub fn is_whole(value: &Value<'_>) -> bool {
    value.as_number_lit().is_some_and(|number| !number.value.contains(['.', 'e', 'E']))
}

/// The value as the number of a vertex or a triangle.
pub fn index(value: &Value<'_>) -> Option<u32> {
    let number = number(value).filter(|_| is_whole(value))?;
    (0.0..=f64::from(u32::MAX)).contains(&number).then_some(number as u32)
}

/// The value of the first key of `object` that is one of `keys`, compared without case, dashes and blanks.
pub fn get<'v, 't>(object: &'v Object<'t>, keys: &[&str]) -> Option<&'v Value<'t>> {
    let property =
        object.properties.iter().find(|property| keys.contains(&normalized(property.name.as_str()).as_str()))?;
    Some(&property.value)
}

/// `key` as it is compared: in lower case, without dashes and blanks.
pub fn normalized(key: &str) -> String {
    key.chars().filter(|c| !"_- ".contains(*c)).collect::<String>().to_lowercase()
}

/// Checks that no mapping in `value` has a name twice.
fn check_names(value: &Value<'_>) -> Result<(), Located> {
    match value {
        Value::Array(array) => array.elements.iter().try_for_each(check_names),
        Value::Object(object) => {
            let mut seen = std::collections::HashSet::new();
            for property in &object.properties {
                let name = property.name.as_str();
                if !seen.insert(name) {
                    let message = format!("the name `{}` comes a second time", shorten(name));
                    return Err((property.start(), ParseError::new(message, "give each point its own name")));
                }
                check_names(&property.value)?;
            }
            Ok(())
        }
        _ => Ok(()),
    }
}

/// The error of the parser at byte `at` in words, with a way out.
fn explain(text: &str, kind: &ParseErrorKind, at: usize) -> Located {
    use ParseErrorKind::*;
    let (expected, hint) = match kind {
        TrailingCommasNotAllowed => {
            let end = next_sign(text, at + 1);
            return unexpected(text, end, "a value behind the comma", "remove the comma behind the last value");
        }
        ExpectedComma => return missing_comma(text, at),
        MultipleRootJsonValues => ("the end", "remove what follows the points"),
        ExpectedStringObjectProperty | UnexpectedTokenInObject => ("a name in quotes", EXAMPLE),
        ExpectedColonAfterObjectKey => ("`:` behind the name", EXAMPLE),
        UnterminatedArray => return unexpected(text, text.len(), "`]`", CUT_SHORT),
        UnterminatedObject => return unexpected(text, text.len(), "`}`", CUT_SHORT),
        String(UnterminatedStringLiteral) => ("a quote at the end of the string", "close the string with a quote"),
        String(_) => ("`\\n`, `\\u00e9` or the like in the string", "write a backslash as `\\\\`"),
        NestingDepthExceeded => ("a few levels", "points are sequences or mappings of a few levels"),
        CommentsNotAllowed | UnterminatedCommentBlock => ("a value", "JSON has no comments: remove them"),
        NonFiniteNumbersNotAllowed
        | HexadecimalNumbersNotAllowed
        | ExpectedDigit
        | ExpectedDigitFollowingNegativeSign
        | ExpectedPlusMinusOrDigitInNumberLiteral => return not_a_number(text, at),
        _ => return not_a_value(text, at),
    };
    unexpected(text, at, expected, hint)
}

const CUT_SHORT: &str = "the file is empty or cut short: save it again";
const EXAMPLE: &str = "e.g. `\"nose\": [0.1, 0.2, 0.3]`";

fn unexpected(text: &str, at: usize, expected: &str, hint: &str) -> Located {
    (at, ParseError::new(format!("not valid JSON: expected {expected}, found {}", found(text, at)), hint))
}

/// The error of two values without a comma between them, the first of which ends at byte `end`.
fn missing_comma(text: &str, end: usize) -> Located {
    let next = next_sign(text, end);
    if next == end && text[..end].ends_with(|c: char| c.is_alphanumeric() || c == '.') {
        return not_a_number(text, end);
    }
    unexpected(text, next, "`,`", "a comma is missing here, or before")
}

/// The error of a word around byte `at` that begins like a number and is none.
fn not_a_number(text: &str, at: usize) -> Located {
    let begin = text[..at].char_indices().rfind(|(_, c)| is_delimiter(*c)).map_or(0, |(i, c)| i + c.len_utf8());
    unexpected(text, begin, "a number", "numbers are e.g. `12` or `-0.5`, without a zero before other digits")
}

/// The error of a place where a value is expected and something else stands.
fn not_a_value(text: &str, at: usize) -> Located {
    let hint = match text[at..].chars().next() {
        None => CUT_SHORT,
        Some('N' | 'I') => "JSON has no NaN and Infinity: give the point a position, or remove it",
        Some(',') => "a value is missing between two commas",
        Some(';') => "separate values by commas",
        Some('#' | '/') => "JSON has no comments: remove them",
        Some('\'') => "put strings between double quotes",
        _ => "values are numbers, strings in double quotes, sequences and mappings",
    };
    unexpected(text, at, "a value", hint)
}

/// The first byte from `at` that is no blank.
fn next_sign(text: &str, at: usize) -> usize {
    text.len() - text[at..].trim_start().len()
}

/// The word or sign at byte `at`, for messages.
fn found(text: &str, at: usize) -> String {
    let rest = &text[at..];
    let Some(first) = rest.chars().next() else { return "the end of the file".into() };
    match rest.split(is_delimiter).next().filter(|word| !word.is_empty()) {
        Some(word) => format!("`{}`", shorten(word)),
        None => format!("`{first}`"),
    }
}

fn is_delimiter(c: char) -> bool {
    c.is_whitespace() || ",:;[]{}".contains(c)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// The line, the message and the hint of the error in `text`.
    fn error(text: &str) -> (usize, String, String) {
        let (at, error) = parse(text).unwrap_err();
        let line = crate::text::Lines::new(text).line(at);
        (line, error.message.trim_start_matches("not valid JSON: ").into(), error.hint)
    }

    #[test]
    fn slips_of_people_are_reported_with_their_lines() {
        for (text, expected) in [
            ("[\n[1, 2],\n]", "3: expected a value behind the comma, found `]`"),
            ("{\"a\": 1,}", "1: expected a value behind the comma, found `}`"),
            ("[1; 2]", "1: expected a value, found `;`"),
            ("[1\n2]", "2: expected `,`, found `2`"),
            ("{\"a\": 1\n\"b\": 2}", "2: expected `,`, found `\"b\"`"),
            ("{a: 1}", "1: expected a name in quotes, found `a`"),
            ("{\"a\": 1]", "1: expected a name in quotes, found `]`"),
            ("{\"a\" 1}", "1: expected `:` behind the name, found `1`"),
            ("{\"a\": }", "1: expected a value, found `}`"),
            ("[1,\n, 2]", "2: expected a value, found `,`"),
            ("[NaN]", "1: expected a value, found `NaN`"),
            ("[-Infinity]", "1: expected a number, found `-Infinity`"),
            ("[1.2.3]", "1: expected a number, found `1.2.3`"),
            ("[0x1]", "1: expected a number, found `0x1`"),
            ("[1, 1e]", "1: expected a number, found `1e`"),
            ("[1, é]", "1: expected a value, found `é`"),
            ("\n[1", "2: expected `]`, found the end of the file"),
            ("[\n{\"a\": [1]", "2: expected `}`, found the end of the file"),
            ("{\"a\":", "1: expected a value, found the end of the file"),
            ("{\"a\": 1, \"a\": 2}", "1: the name `a` comes a second time"),
            ("[1] [2]", "1: expected the end, found `[`"),
            ("[1 /* one */]", "1: expected a value, found `/*`"),
            ("[\"a\\q\"]", "1: expected `\\n`, `\\u00e9` or the like in the string, found `\\q\"`"),
            ("[\"\\ud83d\"]", "1: expected `\\n`, `\\u00e9` or the like in the string, found `\\ud83d\"`"),
            ("[\n\"a]", "2: expected a quote at the end of the string, found `\"a`"),
            ("", "1: expected a value, found the end of the file"),
        ] {
            let (line, message, _) = error(text);
            assert_eq!(format!("{line}: {message}"), expected, "{text}");
        }
        assert_eq!(error(&"[".repeat(1000)).1, "expected a few levels, found `[`");
        assert_eq!(error("[1; 2]").2, "separate values by commas");
        assert!(error("['a']").2.contains("double quotes"));
        assert!(error("[1] # ears").2.contains("remove"));
    }

    #[test]
    fn numbers_are_whole_as_they_are_written() {
        let value = parse("[1, 1.0, +2, .5, 1e2, -3, 4294967296, 1e999, \"\\u00e9\\ud83d\\ude00\"]").unwrap();
        let items = &value.as_array().unwrap().elements;
        let numbers: Vec<_> = items.iter().map(number).collect();
        let finite = [1.0, 1.0, 2.0, 0.5, 100.0, -3.0, 4294967296.0].map(Some);
        assert_eq!(numbers[..7], finite);
        assert_eq!(numbers[7..], [None, None]);
        let indices: Vec<_> = items.iter().map(index).collect();
        assert_eq!(indices, [Some(1), None, Some(2), None, None, None, None, None, None]);
        assert_eq!(describe(&items[8]), "the string `é😀`");
    }

    /// Whether the two parsers read the same.
    fn same(value: &Value<'_>, other: &serde_json::Value) -> bool {
        match (value, other) {
            (Value::NumberLit(_), serde_json::Value::Number(b)) => number(value) == b.as_f64(),
            (Value::StringLit(a), serde_json::Value::String(b)) => a.value == *b,
            (Value::BooleanLit(a), serde_json::Value::Bool(b)) => a.value == *b,
            (Value::NullKeyword(_), serde_json::Value::Null) => true,
            (Value::Array(a), serde_json::Value::Array(b)) => {
                a.elements.len() == b.len() && a.elements.iter().zip(b).all(|(a, b)| same(a, b))
            }
            (Value::Object(a), serde_json::Value::Object(b)) => {
                let pairs = a.properties.iter().zip(b);
                a.properties.len() == b.len()
                    && pairs.into_iter().all(|(a, (key, b))| a.name.as_str() == key && same(&a.value, b))
            }
            _ => false,
        }
    }

    proptest! {
        #[test]
        fn no_text_makes_the_reader_panic(text in "([\\[\\]{},:;\"'\\\\#/*uéN \n]|[0-9.eE+-]{1,4}|null|true){0,30}") {
            let _ = parse(&text);
        }

        #[test]
        fn output_of_serde_is_read_alike(
            map in prop::collection::btree_map(".{0,6}", (any::<i32>(), -1e9..1e9f64, prop::option::of(".{0,6}"), any::<bool>()), 0..5)
        ) {
            let written = serde_json::json!([map]);
            let text = serde_json::to_string_pretty(&written).unwrap();
            prop_assert!(same(&parse(&text).unwrap(), &written));
        }
    }
}
