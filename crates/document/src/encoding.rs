//! Texts that are not in UTF-8: where they are not, and what they probably are.

use crate::limits::thousands;

/// Why bytes are no UTF-8 text.
#[derive(Debug, PartialEq, Eq)]
pub struct NotText {
    /// What is wrong, and where.
    pub message: String,
    /// The way out.
    pub hint: &'static str,
}

/// The text in `bytes`.
///
/// # Errors
///
/// If they are no UTF-8, with the encoding that they probably have.
pub fn utf8(bytes: Vec<u8>) -> Result<String, NotText> {
    let Some(encoding) = other_encoding(&bytes) else {
        return String::from_utf8(bytes).map_err(|error| invalid(error.as_bytes(), error.utf8_error().valid_up_to()));
    };
    let hint = "save it as UTF-8: in an editor by `Save with encoding`, or by `iconv -f UTF-16 -t UTF-8 OLD > NEW`";
    Err(NotText { message: format!("the text is {encoding}, expected UTF-8"), hint })
}

/// The Unicode encoding of `bytes`, if it is another than UTF-8.
fn other_encoding(bytes: &[u8]) -> Option<&'static str> {
    match bytes {
        [0xff, 0xfe, 0, 0, ..] | [0, 0, 0xfe, 0xff, ..] => Some("UTF-32"),
        [0xff, 0xfe, ..] => Some("UTF-16 (little-endian, with a byte order mark)"),
        [0xfe, 0xff, ..] => Some("UTF-16 (big-endian, with a byte order mark)"),
        // Letters of ASCII have a zero byte each.
        [a, 0, b, 0, c, 0, ..] if [a, b, c].iter().all(|byte| byte.is_ascii() && **byte != 0) => {
            Some("UTF-16 (little-endian)")
        }
        [0, a, 0, b, 0, c, ..] if [a, b, c].iter().all(|byte| byte.is_ascii() && **byte != 0) => {
            Some("UTF-16 (big-endian)")
        }
        _ => None,
    }
}

/// What is wrong with `bytes`, which are UTF-8 before `offset` alone.
fn invalid(bytes: &[u8], offset: usize) -> NotText {
    let line = bytes[..offset].iter().filter(|byte| **byte == b'\n').count() + 1;
    let place = format!("byte 0x{:02x} at offset {} (line {})", bytes[offset], thousands(offset), thousands(line));
    let is_control = |byte: &u8| *byte < 0x20 && !b"\t\n\r\x0c".contains(byte);
    let (guess, hint) = match bytes.iter().any(is_control) {
        true => ("a binary file", "name a text file"),
        false => (
            "probably Latin-1 or Windows-1252",
            "save it as UTF-8: in an editor by `Save with encoding`, or by `iconv -f WINDOWS-1252 -t UTF-8 OLD > NEW`",
        ),
    };
    NotText { message: format!("not UTF-8 text: {place}; {guess}"), hint }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(bytes: &[u8]) -> String {
        utf8(bytes.to_vec()).unwrap_err().message
    }

    #[test]
    fn encodings_are_told_by_name_and_bytes_by_their_place() {
        assert_eq!(utf8(b"gr\xc3\xbc".to_vec()).unwrap(), "grü");
        assert_eq!(
            told(b"a: 1\nb: gr\xfc\xdfe\n"),
            "not UTF-8 text: byte 0xfc at offset 10 (line 2); probably Latin-1 or Windows-1252"
        );
        assert!(told(b"\xff\xfea\0").starts_with("the text is UTF-16 (little-endian, with a byte order mark)"));
        assert!(told(b"\xfe\xff\0a").starts_with("the text is UTF-16 (big-endian, with a byte order mark)"));
        assert!(told(b"a\0:\0 \0").starts_with("the text is UTF-16 (little-endian)"));
        assert!(told(b"\x89PNG\r\n\x1a\n\0\0").ends_with("a binary file"), "{}", told(b"\x89PNG\x1a\0"));
    }
}
