//! The rows of tables, cut into cells.

use csv::{ReaderBuilder, StringRecord};

/// The sign between the values of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Separator {
    /// `,`
    Comma,
    /// `;`
    Semicolon,
    /// A tab.
    Tab,
    /// Any number of blanks.
    Blanks,
}

impl Separator {
    /// The separator of a line; semicolons and tabs come before commas, which may stand in numbers.
    pub fn of(line: &str) -> Self {
        let unquoted: String = line.split('"').step_by(2).collect();
        let separators = [(';', Self::Semicolon), ('\t', Self::Tab), (',', Self::Comma)];
        let found = separators.into_iter().find(|(sign, _)| unquoted.contains(*sign));
        found.map_or(Self::Blanks, |(_, separator)| separator)
    }

    fn sign(self) -> u8 {
        match self {
            Self::Comma => b',',
            Self::Semicolon => b';',
            Self::Tab => b'\t',
            Self::Blanks => b' ',
        }
    }
}

/// A row of a table.
#[derive(Clone, Debug, PartialEq)]
pub struct Row<'t> {
    /// The number of its line, from 1.
    pub line: usize,
    /// The text of its line.
    pub text: &'t str,
    /// The cells, at least one, without quotes and the blanks around them.
    pub cells: Vec<String>,
    /// Whether a cell goes on in the next line, since its quotes are not closed before.
    pub spans_lines: bool,
}

/// The rows in `lines`, none of which is empty.
pub fn rows<'t>(lines: &[(&'t str, usize)], separator: Separator) -> Vec<Row<'t>> {
    let mut text = String::new();
    for (line, _) in lines {
        match separator {
            Separator::Blanks => text.extend(line.chars().map(|c| if c.is_whitespace() { ' ' } else { c })),
            _ => text.push_str(line),
        }
        text.push('\n');
    }
    let mut reader = ReaderBuilder::new();
    let reader = reader.delimiter(separator.sign()).has_headers(false).flexible(true).from_reader(text.as_bytes());
    // Every text in UTF-8 is a table of records.
    let records: Vec<StringRecord> = reader.into_records().flatten().collect();
    let first_lines = records.iter().map(|record| record.position().map_or(0, |at| at.line() as usize - 1));
    let first_lines: Vec<usize> = first_lines.chain([lines.len()]).collect();
    let row = |(record, range): (&StringRecord, &[usize])| {
        let (text, line) = lines[range[0]];
        let cells = record.iter().map(trimmed).filter(|cell| separator != Separator::Blanks || !cell.is_empty());
        let mut cells: Vec<_> = cells.map(str::to_owned).collect();
        if cells.is_empty() {
            cells.push(String::new());
        }
        Row { line, text, cells, spans_lines: range[1] > range[0] + 1 }
    };
    records.iter().zip(first_lines.windows(2)).map(row).collect()
}

/// `cell` without blanks around it, and without quotes that follow a blank, which `csv` leaves.
fn trimmed(cell: &str) -> &str {
    let trimmed = cell.trim();
    let quoted = trimmed.strip_prefix('"').and_then(|cell| cell.strip_suffix('"'));
    quoted.filter(|_| cell.starts_with(char::is_whitespace)).unwrap_or(trimmed)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cells(line: &str, separator: Separator) -> Vec<String> {
        rows(&[(line, 1)], separator).remove(0).cells
    }

    #[test]
    fn cells_lose_quotes_and_the_blanks_around_them() {
        assert_eq!(cells("\"a, \"\"b\"\"\", \"c\" ,1,", Separator::Comma), ["a, \"b\"", "c", "1", ""]);
        assert_eq!(cells("\"\"\"a\"\"\"", Separator::Comma), ["\"a\""]);
        assert_eq!(cells("\"a b\"  1\u{a0}\t2", Separator::Blanks), ["a b", "1", "2"]);
        assert_eq!(cells("a b\t\t1", Separator::Tab), ["a b", "", "1"]);
        assert_eq!(cells("\"open;1", Separator::Semicolon), ["open;1"]);
        assert_eq!(cells("\"", Separator::Blanks), [""]);
    }

    #[test]
    fn rows_know_their_lines_and_whether_they_span_several() {
        let lines = [("a,1", 2), ("\"b", 5), ("c\",2", 6), ("d,3", 7)];
        let rows = rows(&lines, Separator::Comma);
        let found: Vec<_> = rows.iter().map(|row| (row.line, row.text, row.spans_lines)).collect();
        assert_eq!(found, [(2, "a,1", false), (5, "\"b", true), (7, "d,3", false)]);
    }
}
