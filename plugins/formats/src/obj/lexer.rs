//! Lines of an OBJ as keyword and tokens, with their places in the file.

use std::ops::Range;

/// Walks over the statements of an OBJ without copying any of it.
///
/// Lines end in LF, CRLF or CR; a backslash before the end of a line continues it; `#` starts a comment.
#[derive(Debug)]
pub struct Lexer<'a> {
    bytes: &'a [u8],
    at: usize,
    line: usize,
    /// Whether a statement has been begun that may not be read to its end.
    inside: bool,
}

impl<'a> Lexer<'a> {
    /// A lexer at the start of `bytes`, after a byte order mark if there is one.
    pub fn new(bytes: &'a [u8]) -> Self {
        let at = if bytes.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 };
        Self { bytes, at, line: 1, inside: false }
    }

    /// A lexer in the middle of a statement, at byte `at`; lines are counted from there.
    pub fn resume(bytes: &'a [u8], at: usize) -> Self {
        Self { bytes, at, line: 1, inside: true }
    }

    /// The line of the byte to be read next, from 1.
    pub fn line(&self) -> usize {
        self.line
    }

    /// The place of the byte to be read next.
    pub fn at(&self) -> usize {
        self.at
    }

    /// The keyword of the next statement that has one; what is left of the last one is skipped.
    pub fn keyword(&mut self) -> Option<&'a [u8]> {
        loop {
            if self.inside {
                self.skip();
                self.end_line();
            }
            if self.at >= self.bytes.len() {
                return None;
            }
            self.inside = true;
            if let Some(token) = self.token() {
                return Some(&self.bytes[token]);
            }
        }
    }

    /// The place of the next token of this statement.
    pub fn token(&mut self) -> Option<Range<usize>> {
        loop {
            match self.bytes.get(self.at)? {
                b' ' | b'\t' | 0x0b | 0x0c => self.at += 1,
                b'\\' if self.continues() => {
                    self.at += 1;
                    self.end_line();
                }
                b'\n' | b'\r' | b'#' => return None,
                _ => break,
            }
        }
        let start = self.at;
        while let Some(byte) = self.bytes.get(self.at) {
            match byte {
                b' ' | b'\t' | 0x0b | 0x0c | b'\n' | b'\r' => break,
                b'\\' if self.continues() => break,
                _ => self.at += 1,
            }
        }
        Some(start..self.at)
    }

    /// The rest of the line without blanks around it: a name, which may hold spaces and `#`.
    pub fn rest(&mut self) -> &'a [u8] {
        let range = self.rest_range();
        &self.bytes[range]
    }

    /// The place of [`rest`](Self::rest).
    pub fn rest_range(&mut self) -> Range<usize> {
        let start = self.at;
        let line = &self.bytes[start..];
        let length = line.iter().position(|b| matches!(b, b'\n' | b'\r')).unwrap_or(line.len());
        self.at += length;
        let start = start + line[..length].len() - line[..length].trim_ascii_start().len();
        start..start + self.bytes[start..self.at].trim_ascii_end().len()
    }

    /// Skips to the end of the statement.
    fn skip(&mut self) {
        while let Some(byte) = self.bytes.get(self.at) {
            match byte {
                b'\n' | b'\r' => return,
                b'#' => {
                    // A backslash in a comment is no continuation.
                    self.rest();
                    return;
                }
                b'\\' if self.continues() => {
                    self.at += 1;
                    self.end_line();
                }
                _ => self.at += 1,
            }
        }
    }

    /// Whether the line ends after the byte at hand.
    fn continues(&self) -> bool {
        matches!(self.bytes.get(self.at + 1), Some(b'\n' | b'\r'))
    }

    /// Past the end of the line, if there is one here.
    fn end_line(&mut self) {
        let length = match &self.bytes[self.at..] {
            [b'\r', b'\n', ..] => 2,
            [b'\r' | b'\n', ..] => 1,
            _ => return,
        };
        self.at += length;
        self.line += 1;
    }
}

/// A finite number.
pub fn number(token: &[u8]) -> Option<f64> {
    std::str::from_utf8(token).ok()?.parse().ok().filter(|x: &f64| x.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn statements(text: &str) -> Vec<(usize, Vec<&str>)> {
        let mut lexer = Lexer::new(text.as_bytes());
        let mut found = Vec::new();
        while let Some(keyword) = lexer.keyword() {
            let mut words = vec![std::str::from_utf8(keyword).unwrap()];
            let line = lexer.line();
            while let Some(token) = lexer.token() {
                words.push(&text[token]);
            }
            found.push((line, words));
        }
        found
    }

    #[test]
    fn lines_end_in_any_way_and_are_counted() {
        let text = "v 1 2\r\n\r\n  f 3\t4 # five\rl 6\n#\\\nv 7";
        let expected = [(1, vec!["v", "1", "2"]), (3, vec!["f", "3", "4"]), (4, vec!["l", "6"]), (6, vec!["v", "7"])];
        assert_eq!(statements(text), expected);
    }

    #[test]
    fn a_backslash_continues_a_line_and_is_part_of_a_word_elsewhere() {
        assert_eq!(statements("f 1 \\\r\n 2\\\n3\nv a\\b"), [(1, vec!["f", "1", "2", "3"]), (4, vec!["v", "a\\b"])]);
    }

    #[test]
    fn an_unread_statement_is_skipped_with_its_continuations() {
        let mut lexer = Lexer::new(b"x 1 2 \\\n 3\n\\\nf");
        assert_eq!(lexer.keyword(), Some(&b"x"[..]));
        assert_eq!(lexer.keyword(), Some(&b"f"[..]));
        assert_eq!((lexer.line(), lexer.keyword()), (4, None));
    }

    #[test]
    fn names_may_hold_spaces() {
        let mut lexer = Lexer::new(b"\xef\xbb\xbfusemtl  Material #25 \r\n");
        assert_eq!(lexer.keyword(), Some(&b"usemtl"[..]));
        assert_eq!(lexer.rest(), b"Material #25");
    }
}
