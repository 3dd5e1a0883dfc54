//! Text in UTF-16, as some programs on Windows write it.

use std::borrow::Cow;

/// The sentence about a text that was not UTF-8.
pub const NOTE: &str = "the file is UTF-16 text: it is read, and results are written as UTF-8";

/// The text as UTF-8, if `bytes` are UTF-16 of either order, with a byte order mark or without one.
///
/// Without a mark a text is known by its first two characters, which are ASCII in all formats here.
pub fn from_utf16(bytes: &[u8]) -> Option<Vec<u8>> {
    let (skipped, unit): (usize, fn([u8; 2]) -> u16) = match bytes {
        [0xff, 0xfe, ..] => (2, u16::from_le_bytes),
        [0xfe, 0xff, ..] => (2, u16::from_be_bytes),
        [a, 0, b, 0, ..] if *a > 0 && *b > 0 => (0, u16::from_le_bytes),
        [0, a, 0, b, ..] if *a > 0 && *b > 0 => (0, u16::from_be_bytes),
        _ => return None,
    };
    let units = bytes[skipped..].chunks_exact(2).map(|pair| unit([pair[0], pair[1]]));
    let text: String = char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)).collect();
    Some(text.into_bytes())
}

/// The text as UTF-8 and the warnings about that.
pub fn utf8(bytes: Cow<'_, [u8]>) -> (Cow<'_, [u8]>, Vec<String>) {
    match from_utf16(&bytes) {
        Some(text) => (text.into(), vec![NOTE.into()]),
        None => (bytes, Vec::new()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_orders_are_known_with_a_mark_and_without() {
        let text = "v 0 ü😀\n";
        let bytes = |mark: bool, order: fn(u16) -> [u8; 2]| -> Vec<u8> {
            let mark = mark.then_some(0xfeff_u16);
            mark.into_iter().chain(text.encode_utf16()).flat_map(order).collect()
        };
        for mark in [true, false] {
            for order in [u16::to_le_bytes as fn(u16) -> [u8; 2], u16::to_be_bytes] {
                assert_eq!(from_utf16(&bytes(mark, order)).unwrap(), text.as_bytes());
            }
        }
        for other in [&b""[..], b"v 0 0 0\n", b"\xef\xbb\xbfv", b"glTF", &[0; 8], b"v\0"] {
            assert_eq!(from_utf16(other), None);
        }
    }
}
