//! `.cons`: a line with the number of pairs, then a pair `source, target` of vertices a line, counted from 0.

use std::path::Path;

use super::{
    Entry, MarkerFile,
    text::{shorten, without_mark},
};
use crate::{
    core::mesh::SurfacePoint,
    diagnostic::Kind,
    diagnostic::{Diagnostic, Diagnostics, Location, Result},
};

/// Parses the text of `file`; blank lines are passed over.
///
/// # Errors
///
/// All lines that are not understood, or a count that is not that of the pairs.
pub fn parse(file: &Path, text: &str) -> Result<MarkerFile> {
    let mut diagnostics = Vec::new();
    let location = |line: usize| Location::Line { file: file.into(), line };
    let mut lines = without_mark(text)
        .lines()
        .enumerate()
        .map(|(i, line)| (i + 1, line.trim()))
        .filter(|(_, line)| !line.is_empty());
    let (first, head) = lines.next().unwrap_or((1, ""));
    let count = head.parse::<usize>().ok();
    if count.is_none() {
        let found = if head.is_empty() { "nothing".into() } else { format!("`{}`", shorten(head)) };
        let message = format!("expected the number of pairs, found {found}");
        let hint = match pair(head) {
            Ok(_) => format!("the count is missing: put a line `{}` before this one", 1 + lines.clone().count()),
            Err(_) => "the first line of a .cons is the number of pairs that follow".into(),
        };
        diagnostics.push(Diagnostic::new(Kind::BadData, message).at(location(first)).hint(hint));
    }
    let mut entries = Vec::new();
    let mut pairs = 0;
    for (line, text) in lines {
        pairs += 1;
        match pair(text) {
            Ok([source, target]) => {
                let vertex = SurfacePoint::Vertex;
                entries.push(Entry { location: Some(location(line)), ..Entry::new(vertex(source), vertex(target)) });
            }
            Err(hint) => diagnostics.push(
                Diagnostic::new(Kind::BadData, format!("expected `source, target`, found `{}`", shorten(text)))
                    .at(location(line))
                    .hint(hint),
            ),
        }
    }
    if let Some(count) = count.filter(|count| *count != pairs) {
        let message = format!("the first line says {count} pairs, found {pairs}");
        let hint = "correct the count, or find the pairs that are missing";
        diagnostics.push(Diagnostic::new(Kind::BadData, message).at(location(first)).hint(hint));
    }
    if diagnostics.is_empty() {
        Ok(MarkerFile { entries, ..MarkerFile::default() })
    } else {
        Err(Diagnostics { diagnostics })
    }
}

/// The text of a file with `pairs` of vertices, which [`parse`] reads back.
pub fn write(pairs: impl ExactSizeIterator<Item = (u32, u32)>) -> String {
    let count = pairs.len();
    let lines: String = pairs.map(|(source, target)| format!("{source}, {target}\n")).collect();
    format!("{count}\n{lines}")
}

/// The two numbers of a line, or the way out.
fn pair(text: &str) -> std::result::Result<[u32; 2], String> {
    let words: Vec<&str> =
        text.split(|c: char| c == ',' || c.is_whitespace()).filter(|word| !word.is_empty()).collect();
    let commas = text.matches(',').count();
    if let ([source, target], true) = (&words[..], commas < 2)
        && let (Ok(source), Ok(target)) = (source.parse(), target.parse())
        && !text.ends_with(',')
        && !text.starts_with(',')
    {
        return Ok([source, target]);
    }
    let numbers: Vec<&str> = text.split(|c: char| !c.is_ascii_digit()).filter(|word| !word.is_empty()).collect();
    let whole = numbers.len() == 2 && !text.contains(['.', '-']);
    Err(match () {
        () if text.starts_with(['#', '%']) || text.starts_with("//") => {
            "a .cons has no room for remarks: remove the line, or use a .yaml, which has notes".into()
        }
        () if whole && text.ends_with([',', ';']) => {
            format!("remove the `{}` at the end of the line", &text[text.len() - 1..])
        }
        () if whole && (commas > 1 || text.contains([';', ':', '/', '|', '=', '>', '(', '[', '{'])) => {
            format!("put nothing but a comma between the two numbers: `{}, {}`", numbers[0], numbers[1])
        }
        () if words.iter().all(|word| word.parse::<f64>().is_ok_and(|x| x.fract() == 0.0 && x >= 0.0))
            && words.len() == 2 =>
        {
            "vertices are whole numbers: write them without decimals".into()
        }
        () if words.len() == 6 && words.iter().all(|word| word.parse::<f64>().is_ok()) => {
            "positions go into a file a side, e.g. a .csv with `name, x, y, z`".into()
        }
        () => "each line pairs a vertex of the source with one of the target, counted from 0, e.g. `750, 3386`".into(),
    })
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
        assert_eq!(file.entries[1].location, Some(Location::Line { file: "m.cons".into(), line: 4 }));
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
    fn usual_slips_have_their_own_way_out() {
        let hint = |text: &str| read(text).unwrap_err().diagnostics[0].hint.clone().unwrap();
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
    fn marks_and_line_ends_of_other_systems_are_passed_over() {
        assert_eq!(read("\u{feff}1\r\n1, 2\r\n").unwrap().entries.len(), 1);
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
            let file = read(&write(pairs.iter().copied())).unwrap();
            let back: Vec<_> = file.entries.iter().map(|e| (e.source, e.target)).collect();
            let expected: Vec<_> = pairs.iter().map(|&(s, t)| (SurfacePoint::Vertex(s), Some(SurfacePoint::Vertex(t)))).collect();
            prop_assert_eq!(back, expected);
        }
    }
}
