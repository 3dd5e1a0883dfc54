//! `.cons`: a line with the number of pairs, then a pair `source, target` of vertices a line, counted from 0.

use std::path::Path;

use super::{Entry, MarkerFile};
use crate::{
    core::mesh::SurfacePoint,
    mistake::{Failure, Mistake, Place, Result},
    status::Status,
};

/// Parses the text of `file`; blank lines are passed over.
///
/// # Errors
///
/// All lines that are not understood, or a count that is not that of the pairs.
pub fn parse(file: &Path, text: &str) -> Result<MarkerFile> {
    let mut mistakes = Vec::new();
    let place = |line: usize| Place::Line { file: file.into(), line };
    let mut lines = text.lines().enumerate().map(|(i, line)| (i + 1, line.trim())).filter(|(_, line)| !line.is_empty());
    let (first, head) = lines.next().unwrap_or((1, ""));
    let count = head.parse::<usize>().ok();
    if count.is_none() {
        let found = if head.is_empty() { "nothing".into() } else { format!("`{}`", shorten(head)) };
        let message = format!("expected the number of pairs, found {found}");
        mistakes.push(
            Mistake::new(Status::BadData, message)
                .at(place(first))
                .hint("the first line of a .cons is the number of pairs that follow"),
        );
    }
    let mut entries = Vec::new();
    let mut pairs = 0;
    for (line, text) in lines {
        pairs += 1;
        match pair(text) {
            Some([source, target]) => entries.push(Entry {
                name: None,
                source: SurfacePoint::Vertex(source),
                target: Some(SurfacePoint::Vertex(target)),
                note: None,
                place: Some(place(line)),
            }),
            None => mistakes.push(
                Mistake::new(Status::BadData, format!("expected `source, target`, found `{}`", shorten(text)))
                    .at(place(line))
                    .hint("each line pairs a vertex of the source with one of the target, counted from 0, e.g. `750, 3386`"),
            ),
        }
    }
    if let Some(count) = count.filter(|count| *count != pairs) {
        let message = format!("the first line says {count} pairs, found {pairs}");
        let hint = "correct the count, or find the pairs that are missing";
        mistakes.push(Mistake::new(Status::BadData, message).at(place(first)).hint(hint));
    }
    if mistakes.is_empty() { Ok(MarkerFile { entries, ..MarkerFile::default() }) } else { Err(Failure { mistakes }) }
}

fn pair(text: &str) -> Option<[u32; 2]> {
    let mut words = text.split(|c: char| c == ',' || c.is_whitespace()).filter(|word| !word.is_empty());
    let pair = [words.next()?.parse().ok()?, words.next()?.parse().ok()?];
    words.next().is_none().then_some(pair)
}

fn shorten(text: &str) -> String {
    match text.char_indices().nth(40) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.into(),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn read(text: &str) -> Result<MarkerFile> {
        parse(Path::new("m.cons"), text)
    }

    #[test]
    fn pairs_are_read_with_commas_or_without() {
        let file = read("2\n750, 3386\n\n524 3737\n").unwrap();
        let points: Vec<_> = file.entries.iter().map(|e| (e.source, e.target)).collect();
        let vertex = SurfacePoint::Vertex;
        assert_eq!(points, [(vertex(750), Some(vertex(3386))), (vertex(524), Some(vertex(3737)))]);
        assert_eq!(file.entries[1].place, Some(Place::Line { file: "m.cons".into(), line: 4 }));
    }

    #[test]
    fn every_bad_line_is_told() {
        let text = read("two\n1, 2\n1, x\n-1, 2\n1, 2, 3\n").unwrap_err().to_string();
        let first_lines: Vec<_> = text.lines().filter(|line| line.starts_with("error")).collect();
        assert_eq!(
            first_lines,
            [
                "error: m.cons:1: expected the number of pairs, found `two`",
                "error: m.cons:3: expected `source, target`, found `1, x`",
                "error: m.cons:4: expected `source, target`, found `-1, 2`",
                "error: m.cons:5: expected `source, target`, found `1, 2, 3`",
            ]
        );
    }

    #[test]
    fn an_empty_file_is_told() {
        let text = read(" \n\n").unwrap_err().to_string();
        assert!(text.starts_with("error: m.cons:1: expected the number of pairs, found nothing\n"), "{text}");
    }

    #[test]
    fn a_wrong_count_is_told_with_both_numbers() {
        let text = read("3\n1, 2\n").unwrap_err().to_string();
        assert!(text.starts_with("error: m.cons:1: the first line says 3 pairs, found 1"), "{text}");
    }

    proptest! {
        #[test]
        fn no_text_makes_the_reader_panic(text in ".{0,20}(\n[0-9a-z, .-]{0,12}){0,6}") {
            let _ = read(&text);
        }

        #[test]
        fn pairs_come_back_as_written(pairs in prop::collection::vec(any::<(u32, u32)>(), 0..20)) {
            let lines: String = pairs.iter().map(|(s, t)| format!("{s}, {t}\n")).collect();
            let file = read(&format!("{}\n{lines}", pairs.len())).unwrap();
            let back: Vec<_> = file.entries.iter().map(|e| (e.source, e.target)).collect();
            let expected: Vec<_> = pairs.iter().map(|&(s, t)| (SurfacePoint::Vertex(s), Some(SurfacePoint::Vertex(t)))).collect();
            prop_assert_eq!(back, expected);
        }
    }
}
