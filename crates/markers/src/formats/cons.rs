//! `.cons`: a line with the number of pairs, then a pair `source, target` of vertices a line, counted from 0.

use std::path::Path;

use mimesh_core::mesh::MeshPoint;
use mimesh_document::{Diagnostics, Location, Result};

use crate::{
    model::{MarkerFile, MarkerPair},
    text::{ParseError, quoted, strip_bom},
};

/// Parses the text of `file`; blank lines are skipped.
///
/// # Errors
///
/// All lines that are not understood, and a count that is not that of the pairs.
pub fn parse(file: &Path, text: &str) -> Result<MarkerFile> {
    let mut diagnostics = Diagnostics::default();
    let lines = strip_bom(text).lines().map(str::trim).zip(1..);
    let mut lines = lines
        .filter(|(text, _)| !text.is_empty())
        .map(|(text, line)| (text, Location::Line { file: file.into(), line }));
    let (head, first) = lines.next().unwrap_or(("", Location::Line { file: file.into(), line: 1 }));
    let lines: Vec<_> = lines.collect();
    let expected = count(head, lines.len());
    if let Err(error) = &expected {
        diagnostics.push(error.clone().at(first.clone()));
    }
    let found = lines.len();
    let mut markers = MarkerFile::default();
    for (text, location) in lines {
        match pair(text) {
            Ok([source, target]) => {
                let pair = MarkerPair::new(MeshPoint::Vertex(source), MeshPoint::Vertex(target));
                markers.pairs.push(MarkerPair { location: Some(location), ..pair });
            }
            Err(error) => diagnostics.push(error.at(location)),
        }
    }
    if let Ok(expected) = expected
        && expected != found
    {
        let message = format!("the first line counts {expected} pairs, found {found}");
        diagnostics.push(ParseError::new(message, "correct the count, or find the pairs that are missing").at(first));
    }
    diagnostics.into_result().map(|()| markers)
}

/// The text of a file with `pairs` of vertices, which [`parse`] reads back.
pub fn write(pairs: impl ExactSizeIterator<Item = (u32, u32)>) -> String {
    let count = pairs.len();
    let lines: String = pairs.map(|(source, target)| format!("{source}, {target}\n")).collect();
    format!("{count}\n{lines}")
}

/// The number of pairs in the first line, which `pairs` lines follow.
fn count(head: &str, pairs: usize) -> std::result::Result<usize, ParseError> {
    head.parse().map_err(|_| {
        let hint = match pair(head) {
            Ok(_) => format!("the count is missing: put a line `{}` before this one", 1 + pairs),
            Err(_) => "the first line of a .cons is the number of pairs that follow".into(),
        };
        ParseError::new(format!("expected the number of pairs, found {}", quoted(head)), hint)
    })
}

/// The two vertices of a line.
fn pair(text: &str) -> std::result::Result<[u32; 2], ParseError> {
    let words: Vec<&str> =
        text.split(|c: char| c == ',' || c.is_whitespace()).filter(|word| !word.is_empty()).collect();
    if let [source, target] = words[..]
        && let (Ok(source), Ok(target)) = (source.parse(), target.parse())
        && text.matches(',').count() < 2
        && !text.starts_with(',')
        && !text.ends_with(',')
    {
        return Ok([source, target]);
    }
    Err(ParseError::new(format!("expected `source, target`, found {}", quoted(text)), way_out(text, &words)))
}

/// The way out for a line that is no pair.
fn way_out(text: &str, words: &[&str]) -> String {
    if text.starts_with(['#', '%']) || text.starts_with("//") {
        return "a .cons has no room for remarks: remove the line, or use a .yaml, which has notes".into();
    }
    let numbers: Vec<&str> = text.split(|c: char| !c.is_ascii_digit()).filter(|word| !word.is_empty()).collect();
    if let [source, target] = numbers[..]
        && !text.contains(['.', '-'])
    {
        if text.ends_with([',', ';']) {
            return format!("remove the `{}` at the end of the line", &text[text.len() - 1..]);
        }
        if text.matches(',').count() > 1 || text.contains([';', ':', '/', '|', '=', '>', '(', '[', '{']) {
            return format!("put nothing but a comma between the two numbers: `{source}, {target}`");
        }
    }
    let values: Vec<f64> = words.iter().filter_map(|word| word.parse().ok()).collect();
    let hint = match values.len() {
        2 if words.len() == 2 && values.iter().all(|value| value.fract() == 0.0 && *value >= 0.0) => {
            "vertices are whole numbers: write them without decimals"
        }
        6 if words.len() == 6 => "positions go into a file for each mesh, e.g. a .csv with `name, x, y, z`",
        _ => "each line pairs a vertex of the source with one of the target, counted from 0, e.g. `750, 3386`",
    };
    hint.into()
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
        let points: Vec<_> = file.pairs.iter().map(|e| (e.source.unwrap(), e.target)).collect();
        let vertex = MeshPoint::Vertex;
        assert_eq!(points, [(vertex(750), Some(vertex(3386))), (vertex(524), Some(vertex(3737)))]);
        assert_eq!(file.pairs[1].location, Some(Location::Line { file: "m.cons".into(), line: 4 }));
    }

    #[test]
    fn every_bad_line_is_reported() {
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
    fn usual_slips_have_their_own_way_out() {
        let hint = |text: &str| read(text).unwrap_err().list[0].hint.clone().unwrap();
        assert_eq!(hint("1, 2\n3, 4\n"), "the count is missing: put a line `2` before this one");
        assert_eq!(hint("1\n1, 2,\n"), "remove the `,` at the end of the line");
        for text in ["1\n1;2", "1\n1:2", "1\n(1, 2)", "1\n1,,2", "1\n1 => 2"] {
            assert_eq!(hint(text), "put nothing but a comma between the two numbers: `1, 2`", "{text}");
        }
        assert_eq!(hint("1\n1.0, 2.0"), "vertices are whole numbers: write them without decimals");
        assert!(hint("1\n# ears\n1, 2").contains("no room for remarks"));
        assert!(hint("1\n0.1 0.2 0.3 1 2 3").contains(".csv"));
    }

    #[test]
    fn marks_and_line_ends_of_other_systems_are_skipped() {
        assert_eq!(read("\u{feff}1\r\n1, 2\r\n").unwrap().pairs.len(), 1);
    }

    #[test]
    fn an_empty_file_is_reported() {
        let text = read(" \n\n").unwrap_err().to_string();
        assert!(text.starts_with("error: m.cons:1: expected the number of pairs, found nothing\n"), "{text}");
    }

    #[test]
    fn a_wrong_count_is_reported_with_both_numbers() {
        let text = read("3\n1, 2\n").unwrap_err().to_string();
        assert!(text.starts_with("error: m.cons:1: the first line counts 3 pairs, found 1"), "{text}");
    }

    proptest! {
        #[test]
        fn no_text_makes_the_reader_panic(text in ".{0,20}(\n[0-9a-z, .-]{0,12}){0,6}") {
            let _ = read(&text);
        }

        #[test]
        fn pairs_come_back_as_written(pairs in prop::collection::vec(any::<(u32, u32)>(), 0..20)) {
            let file = read(&write(pairs.iter().copied())).unwrap();
            let back: Vec<_> = file.pairs.iter().map(|e| (e.source.unwrap(), e.target)).collect();
            let expected: Vec<_> = pairs.iter().map(|&(s, t)| (MeshPoint::Vertex(s), Some(MeshPoint::Vertex(t)))).collect();
            prop_assert_eq!(back, expected);
        }
    }
}
