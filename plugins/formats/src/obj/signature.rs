//! How an OBJ is known without its name.

use std::ops::Range;

use super::lexer::{Lexer, number};

/// Whether a file that begins with `start` is an OBJ: its lines have keywords of one, and some a vertex.
pub fn is_obj(start: &[u8]) -> bool {
    // The last line may be cut.
    let end = start.iter().rposition(|&b| b == b'\n' || b == b'\r').unwrap_or(start.len());
    let mut lexer = Lexer::new(&start[..end]);
    let mut vertices = 0;
    while let Some(keyword) = lexer.keyword() {
        match keyword {
            b"v" => {
                let is_number = |token: Option<Range<usize>>| token.is_some_and(|t| number(&start[t]).is_some());
                if !(is_number(lexer.token()) && is_number(lexer.token()) && is_number(lexer.token())) {
                    return false;
                }
                vertices += 1;
            }
            b"vt" | b"vn" | b"vp" | b"f" | b"fo" | b"l" | b"p" | b"o" | b"g" | b"s" | b"mg" | b"usemtl" | b"mtllib" => {
            }
            _ => return false,
        }
    }
    vertices > 0
}
