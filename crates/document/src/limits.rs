//! How much is read and made of what strangers write, so that a small file cannot ask for endless work.
//!
//! Files in use are far below all of them.

/// Bytes of a YAML file.
pub const MAX_YAML_BYTES: usize = 4 << 20;

/// Values in a YAML text, with those that its aliases repeat.
pub const MAX_YAML_VALUES: usize = 250_000;

/// Mappings and sequences within each other in a YAML text.
pub const MAX_YAML_DEPTH: usize = 64;

/// Bytes of a text file of another notation.
pub const MAX_TEXT_BYTES: u64 = 256 << 20;

/// Bytes of one text of a pipeline, and of a key: no path, no name and no pattern is longer.
pub const MAX_STRING_BYTES: usize = 4096;

/// Files that are included, each as often as it is.
pub const MAX_INCLUDES: usize = 1000;

/// Bytes of all files that are included, each as often as it is.
pub const MAX_INCLUDED_BYTES: usize = 32 << 20;

/// Files that include each other in a row.
pub const MAX_INCLUDE_DEPTH: usize = 64;

/// Variables that use each other in a row.
pub const MAX_VARIABLE_DEPTH: usize = 64;

/// Values, and kilobytes of texts, that variables put into one run.
pub const MAX_EXPANDED: usize = 250_000;

/// Diagnostics that are kept: more of them have one cause.
pub const MAX_DIAGNOSTICS: usize = 10_000;

/// Steps of a path of keys, as `transfer.deformer.lambda` has three.
pub const MAX_PATH_STEPS: usize = 64;

/// Characters of a line that a message shows, and of a message.
pub const MAX_SHOWN: usize = 1000;

/// A number with commas between thousands.
pub fn thousands(number: usize) -> String {
    let digits = number.to_string();
    let mut result = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            result.push(',');
        }
        result.push(digit);
    }
    result
}

/// `text` on one line, with escapes in place of characters that steer a terminal: names in messages come from strangers' files.
pub fn on_one_line(text: &str) -> std::borrow::Cow<'_, str> {
    if !text.contains(char::is_control) {
        return text.into();
    }
    let shown = |c: char| if c.is_control() { c.escape_default().to_string() } else { c.to_string() };
    text.chars().map(shown).collect::<String>().into()
}

/// `text` with escapes in place of characters that steer a terminal; lines stay.
pub fn without_controls(text: &str) -> std::borrow::Cow<'_, str> {
    let steers = |c: char| c.is_control() && !matches!(c, '\n' | '\t');
    if !text.contains(steers) {
        return text.into();
    }
    let shown = |c: char| if steers(c) { c.escape_default().to_string() } else { c.to_string() };
    text.chars().map(shown).collect::<String>().into()
}

/// `text`, of which the middle is left out if it is longer than a message can be.
pub fn shortened(text: &str) -> std::borrow::Cow<'_, str> {
    const END: usize = 200;
    let count = text.len();
    if count <= MAX_SHOWN {
        return text.into();
    }
    let start: String = text.chars().take(MAX_SHOWN - END).collect();
    let end: Vec<char> = text.chars().rev().take(END).collect();
    let shown = start.len() + end.iter().map(|c| c.len_utf8()).sum::<usize>();
    if shown >= count {
        return text.into();
    }
    let end: String = end.into_iter().rev().collect();
    format!("{start}… ({} bytes) …{end}", thousands(count - shown)).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_in_a_text_steers_the_terminal() {
        assert_eq!(on_one_line("é: 1"), "é: 1");
        assert_eq!(on_one_line("a\nerror: b\u{1b}[2J\u{9b}\u{7}"), "a\\nerror: b\\u{1b}[2J\\u{9b}\\u{7}");
        assert_eq!(without_controls("a\n\tb\r\u{1b}"), "a\n\tb\\r\\u{1b}");
    }

    #[test]
    fn long_texts_are_cut_in_the_middle() {
        assert_eq!(shortened("short"), "short");
        let long = format!("begin{}end", "é".repeat(100_000));
        let cut = shortened(&long);
        assert!(cut.starts_with("begin") && cut.ends_with("end") && cut.len() < 3000, "{cut}");
        assert!(cut.contains("bytes"), "{cut}");
        assert_eq!(thousands(1_234_567), "1,234,567");
    }
}
