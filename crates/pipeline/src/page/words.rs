//! Names and sentences in a page: lines break between words and at separators, never in mid-word.

use maud::{Markup, PreEscaped, html};

/// The separators in names after which a line may break.
const SEPARATORS: [char; 8] = ['_', '-', '.', '/', '\\', ':', '=', ','];

/// The blank at which no line breaks.
const NO_BREAK: char = '\u{a0}';

/// Longer pieces of a name, in characters, are cut off with an ellipsis where there is no room for them.
const MAX_PIECE: usize = 20;

/// Returns a name, e.g. of a pose or a file, that breaks at its separators.
///
/// A value stays with its percent sign. A long piece without a separator is cut off where there is no room, and has its whole text as a title.
pub fn name(text: &str) -> Markup {
    let text = &text.replace(" %", "\u{a0}%");
    let pieces = pieces(text);
    html! {
        @for (k, piece) in pieces.iter().enumerate() {
            @if k > 0 && !pieces[k - 1].ends_with(char::is_whitespace) { wbr; }
            @if piece.chars().count() > MAX_PIECE {
                span.long title=(piece) { (piece) }
            } @else {
                (piece)
            }
        }
    }
}

/// Returns a sentence, in which names in backticks are code.
pub fn prose(text: &str) -> Markup {
    let parts: Vec<&str> = text.split('`').collect();
    // A lone backtick is none of a pair.
    if parts.len().is_multiple_of(2) {
        return name(text);
    }
    html! {
        @for (k, part) in parts.iter().enumerate() {
            @if k % 2 == 1 { code { (name(part)) } } @else { (name(part)) }
        }
    }
}

/// Returns what is kept on one line, e.g. a value with its unit.
pub fn together(text: &str) -> Markup {
    PreEscaped(html! { (text) }.into_string().replace(' ', "\u{a0}"))
}

/// Returns the pieces of a text between which a line may break, each with the blank or the separator at its end.
fn pieces(text: &str) -> Vec<&str> {
    let mut pieces = Vec::new();
    let mut start = 0;
    let mut before = None;
    let mut letters = text.char_indices().peekable();
    while let Some((at, letter)) = letters.next() {
        let next = letters.peek().map(|(_, next)| *next);
        if ends_piece(before, letter, next) {
            let end = at + letter.len_utf8();
            pieces.push(&text[start..end]);
            start = end;
        }
        before = Some(letter);
    }
    if start < text.len() {
        pieces.push(&text[start..]);
    }
    pieces
}

/// Whether a line may break behind `letter`: a blank, or a separator with a part of a name on each side.
fn ends_piece(before: Option<char>, letter: char, next: Option<char>) -> bool {
    if letter == NO_BREAK {
        return false;
    }
    if letter.is_whitespace() {
        return true;
    }
    let (Some(before), Some(next)) = (before, next) else { return false };
    // Digits on both sides make a number, as 0.5 or 10,000.
    let is_number = ['.', ','].contains(&letter) && before.is_ascii_digit() && next.is_ascii_digit();
    // The dashes of a flag, as --out, stay with its name.
    let is_flag = letter == '-' && !before.is_alphanumeric();
    SEPARATORS.contains(&letter) && !before.is_whitespace() && next.is_alphanumeric() && !is_number && !is_flag
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_break_behind_separators_and_never_within_numbers_or_words() {
        let all = |text| pieces(text).join("|");
        assert_eq!(all("left_front_leg-01.obj"), "left_|front_|leg-|01.|obj");
        assert_eq!(all("../out/a b"), "../|out/|a |b");
        assert_eq!(all("0.5 to -10,000 %"), "0.5 |to |-10,000 |%");
        assert_eq!(all("a --out-dir"), "a |--out-|dir");
        assert_eq!(name("12 %").into_string(), "12\u{a0}%");
        assert_eq!(all("_private and é_ä_"), "_private |and |é_|ä_");
        assert_eq!(all(""), "");
    }

    #[test]
    fn a_long_piece_has_a_title_and_a_name_in_backticks_is_code() {
        let long = "a".repeat(30);
        assert!(name(&long).into_string().contains(&format!("title=\"{long}\"")));
        assert_eq!(name("a_<b").into_string(), "a_&lt;b");
        assert_eq!(name("a_b").into_string(), "a_<wbr>b");
        assert_eq!(prose("see `a_b`: x").into_string(), "see <code>a_<wbr>b</code>: x");
        assert_eq!(prose("one ` alone").into_string(), "one ` alone");
        assert_eq!(together("12 %").into_string(), "12\u{a0}%");
    }
}
