//! References from a glTF: data in the reference itself, or a file beside the glTF.

use std::borrow::Cow;

use base64::{Engine, engine::general_purpose::STANDARD};

/// The data that `uri` holds itself; `None` if it holds none.
///
/// # Errors
///
/// What is wrong with the base64.
pub fn data(uri: &str) -> Option<Result<Vec<u8>, String>> {
    let data = uri.strip_prefix("data:")?;
    let Some((_, text)) = data.split_once(";base64,") else { return Some(Err("is not base64".into())) };
    Some(STANDARD.decode(text).map_err(|problem| format!("is not base64: {problem}")))
}

/// Whether `uri` names a file beside the glTF: it neither holds the data itself nor leads elsewhere.
pub fn is_file(uri: &str) -> bool {
    !uri.is_empty() && !uri.starts_with("data:") && !uri.contains("://")
}

/// A relative URI as a path: `%20` is a space.
pub fn decoded(uri: &str) -> Cow<'_, str> {
    if !uri.contains('%') {
        return uri.into();
    }
    let mut bytes = Vec::new();
    let mut rest = uri.as_bytes();
    while let [first, tail @ ..] = rest {
        let escaped = tail.get(..2).and_then(|hex| std::str::from_utf8(hex).ok());
        match escaped.and_then(|hex| u8::from_str_radix(hex, 16).ok()) {
            Some(byte) if *first == b'%' => {
                bytes.push(byte);
                rest = &tail[2..];
            }
            _ => {
                bytes.push(*first);
                rest = tail;
            }
        }
    }
    String::from_utf8_lossy(&bytes).into_owned().into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percent_signs_stand_for_bytes() {
        assert_eq!(decoded("a b.bin"), "a b.bin");
        assert_eq!(decoded("a%20b%C3%A9.bin"), "a bé.bin");
        assert_eq!(decoded("100%.bin%4"), "100%.bin%4");
    }

    #[test]
    fn data_stands_in_the_reference() {
        assert_eq!(data("data:application/octet-stream;base64,AAEC").unwrap().unwrap(), [0, 1, 2]);
        assert_eq!(data("data:text/plain,abc").unwrap().unwrap_err(), "is not base64");
        assert!(data("a.bin").is_none());
    }
}
