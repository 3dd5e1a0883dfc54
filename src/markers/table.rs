//! Points as tables: a line a point, values separated by commas, semicolons, tabs or blanks; a line of headings may precede.
//!
//! Without headings the columns are `name, x, y, z`, `name, vertex`, `x, y, z` or Wrap's `triangle, u, v`.

use std::{collections::HashMap, path::Path};

use nalgebra::Point3;

use super::{
    points::{NamedPoint, PointFile, Spot, Triple},
    text::{Wrong, index, number, shorten},
    write::Written,
};
use crate::diagnostic::{Diagnostic, Diagnostics, Location, Result};

/// Parses the text of `file`; blank lines and lines that begin with `#` are passed over.
///
/// # Errors
///
/// All that is wrong, each with its line.
pub fn parse(file: &Path, text: &str) -> Result<PointFile> {
    let location = |line: usize| Location::Line { file: file.into(), line };
    let mut lines: Vec<(usize, &str)> = text.lines().enumerate().map(|(i, line)| (i + 1, line.trim())).collect();
    lines.retain(|(_, line)| !line.is_empty() && !line.starts_with('#'));
    let Some(&(first, head)) = lines.first() else {
        return Ok(PointFile { file: file.into(), ..PointFile::default() });
    };
    let separator = Separator::of(head);
    let head = separator.split(head);
    let headings: Vec<Option<Column>> = head.iter().map(|word| Column::of(word)).collect();
    let titled = headings.iter().flatten().any(|column| ![Column::Name, Column::Number].contains(column))
        && head.iter().all(|word| word.parse::<f64>().is_err());
    let columns = if titled {
        lines.remove(0);
        headings
    } else {
        let found = untitled(&lines, separator);
        found.map_err(|wrong| Diagnostics::from(wrong.at(location(first))))?
    };
    let has = |column: Column| columns.contains(&Some(column));
    let spatial = has(Column::X) && has(Column::Y) && has(Column::Z);
    let on_triangles = has(Column::Triangle) && has(Column::U) && has(Column::V);
    if !(spatial || on_triangles || has(Column::Vertex)) {
        let message = format!("expected the columns x, y, z or vertex, found {}", shorten(&head.join(", ")));
        return Err(Wrong { message, hint: "e.g. `name,x,y,z` or `name,vertex`".into() }.at(location(first)).into());
    }
    let mut diagnostics: Vec<Diagnostic> = Vec::new();
    let mut result = PointFile { file: file.into(), ..PointFile::default() };
    let mut seen = HashMap::new();
    for (line, text) in lines {
        let cells = separator.split(text);
        match row(&columns, &cells, spatial) {
            Ok((name, spot)) => {
                let before = name.clone().and_then(|name| seen.insert(name, line));
                if let (Some(name), Some(before)) = (&name, before) {
                    let message = format!("another point is called {name} (line {before})");
                    diagnostics.push(Wrong { message, hint: "give each its own name".into() }.at(location(line)));
                }
                result.points.push(NamedPoint { name, spot, location: location(line) });
            }
            Err(wrong) => {
                let wrong = if titled { wrong } else { separator.explain(wrong, text, cells.len(), columns.len()) };
                diagnostics.push(wrong.at(location(line)));
            }
        }
    }
    if diagnostics.is_empty() { Ok(result) } else { Err(Diagnostics { diagnostics }) }
}

/// The text of a file with `points`: name, x, y and z.
pub fn write(points: &[Written]) -> String {
    let row = |Written { name, position: p, .. }: &Written| format!("{},{},{},{}\n", quote(name), p.x, p.y, p.z);
    std::iter::once("name,x,y,z\n".to_owned()).chain(points.iter().map(row)).collect()
}

/// A cell: in quotes where it has to be; a line break inside a name becomes a blank.
fn quote(text: &str) -> String {
    let text: String =
        text.chars().map(|c| if c.is_control() || c == '\u{2028}' || c == '\u{2029}' { ' ' } else { c }).collect();
    let plain = text.trim() == text && !text.contains([',', ';', '"', '\t', '#']) && !text.is_empty();
    if plain { text } else { format!("\"{}\"", text.replace('"', "\"\"")) }
}

/// What a column holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Column {
    Name,
    /// A name, where no column has a better one.
    Number,
    X,
    Y,
    Z,
    Vertex,
    Triangle,
    U,
    V,
}

impl Column {
    fn of(heading: &str) -> Option<Self> {
        let plain: String =
            heading.chars().filter(|c| c.is_alphanumeric() || *c == '-').collect::<String>().to_lowercase();
        Some(match plain.as_str() {
            "name" | "label" | "identifier" | "landmark" => Self::Name,
            "id" | "point" | "rowname" | "---" => Self::Number,
            "x" | "px" | "p0" | "tx" | "posx" | "positionx" | "locationx" | "locx" => Self::X,
            "y" | "py" | "p1" | "ty" | "posy" | "positiony" | "locationy" | "locy" => Self::Y,
            "z" | "pz" | "p2" | "tz" | "posz" | "positionz" | "locationz" | "locz" => Self::Z,
            "vertex" | "vertexindex" | "index" | "vertexid" | "ptnum" | "pointnumber" => Self::Vertex,
            "triangle" | "triangleindex" | "face" | "prim" | "primnum" => Self::Triangle,
            "u" | "b1" | "bary1" | "b0" => Self::U,
            "v" | "b2" | "bary2" => Self::V,
            _ => return None,
        })
    }
}

/// The columns of a table without headings, from its number of columns and what is in them.
fn untitled(lines: &[(usize, &str)], separator: Separator) -> std::result::Result<Vec<Option<Column>>, Wrong> {
    let rows: Vec<Vec<String>> = lines.iter().map(|(_, line)| separator.split(line)).collect();
    let count = rows.iter().map(Vec::len).max().unwrap_or(0);
    // The commonest width is meant; rows of another are told one by one.
    let width =
        (1..=count.min(12)).max_by_key(|width| rows.iter().filter(|row| row.len() == *width).count()).unwrap_or(count);
    let all = |columns: &[Column]| Ok(columns.iter().copied().map(Some).collect());
    match width {
        1 if rows.iter().any(|row| row[0].parse::<u32>().is_ok()) => all(&[Column::Vertex]),
        2 => all(&[Column::Name, Column::Vertex]),
        3 => {
            let triple = |row: &Vec<String>| {
                let [a, b, c] = &row[..] else { return None };
                let numbers = [a.parse().ok()?, b.parse().ok()?, c.parse().ok()?];
                Some(Triple { numbers, whole: a.parse::<u32>().is_ok() })
            };
            let triples: Vec<_> = rows.iter().filter_map(triple).collect();
            if Triple::are_triangles(triples.iter()) {
                all(&[Column::Triangle, Column::U, Column::V])
            } else {
                all(&[Column::X, Column::Y, Column::Z])
            }
        }
        4 => all(&[Column::Name, Column::X, Column::Y, Column::Z]),
        _ => Err(Wrong {
            message: format!("expected `name, x, y, z` or `name, vertex`, found `{}`", shorten(lines[0].1)),
            hint: if separator == Separator::Comma && [7, 8].contains(&width) {
                "are decimals written with commas? write them with points".into()
            } else {
                "put a line of headings first, e.g. `name,x,y,z`".into()
            },
        }),
    }
}

fn row(
    columns: &[Option<Column>],
    cells: &[String],
    spatial: bool,
) -> std::result::Result<(Option<String>, Spot), Wrong> {
    if cells.len() != columns.len() {
        let hint = if cells.last().is_some_and(String::is_empty) && cells.len() == columns.len() + 1 {
            "remove the separator at the end of the line"
        } else {
            "each line has as many values as the first; put names with separators in quotes"
        };
        let message =
            format!("expected {} values, found {}: `{}`", columns.len(), cells.len(), shorten(&cells.join(", ")));
        return Err(Wrong { message, hint: hint.into() });
    }
    let cell = |column: Column| {
        let at = columns.iter().position(|c| *c == Some(column));
        at.map_or("", |at| cells[at].as_str())
    };
    let value = |column: Column| number(cell(column));
    let names = [cell(Column::Name), cell(Column::Number)].into_iter();
    let name = names.filter(|name| !name.is_empty()).map(str::to_owned).next();
    let spot = if columns.contains(&Some(Column::Triangle)) && columns.contains(&Some(Column::U)) {
        let triangle = index(cell(Column::Triangle), "triangle")?;
        let triple = Triple { numbers: [f64::from(triangle), value(Column::U)?, value(Column::V)?], whole: true };
        let hint = "a line is a triangle and the coordinates of its first and second corner".to_owned();
        triple.triangle().map_err(|message| Wrong { message, hint })?
    } else if spatial {
        Spot::Position(Point3::new(value(Column::X)?, value(Column::Y)?, value(Column::Z)?))
    } else {
        Spot::Vertex(index(cell(Column::Vertex), "vertex")?)
    };
    Ok((name, spot))
}

/// What stands between values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Separator {
    Comma,
    Semicolon,
    Tab,
    Blanks,
}

impl Separator {
    /// That of a line: semicolons and tabs come before commas, which may stand in numbers.
    fn of(line: &str) -> Self {
        let quoted_out: String = line.split('"').step_by(2).collect();
        match () {
            () if quoted_out.contains(';') => Self::Semicolon,
            () if quoted_out.contains('\t') => Self::Tab,
            () if quoted_out.contains(',') => Self::Comma,
            () => Self::Blanks,
        }
    }

    fn split(self, line: &str) -> Vec<String> {
        let separates = |c: char| match self {
            Self::Comma => c == ',',
            Self::Semicolon => c == ';',
            Self::Tab => c == '\t',
            Self::Blanks => c.is_whitespace(),
        };
        let mut cells = vec![String::new()];
        // Blanks around a cell go, those between quotes stay.
        let mut kept = vec![0];
        let mut quoted = false;
        let mut chars = line.chars().peekable();
        while let Some(c) = chars.next() {
            let last = cells.len() - 1;
            match c {
                '"' if quoted && chars.peek() == Some(&'"') => {
                    chars.next();
                    cells[last].push('"');
                }
                '"' if quoted => {
                    quoted = false;
                    kept[last] = cells[last].len();
                }
                '"' if cells[last].trim().is_empty() => {
                    quoted = true;
                    cells[last].clear();
                }
                c if separates(c) && !quoted => {
                    if self != Self::Blanks || !cells[last].is_empty() {
                        cells.push(String::new());
                        kept.push(0);
                    }
                }
                c if c.is_whitespace() && !quoted && cells[last].is_empty() => {}
                c => cells[last].push(c),
            }
        }
        for (cell, kept) in cells.iter_mut().zip(kept) {
            let end = cell.trim_end().len().max(kept);
            cell.truncate(end);
        }
        cells
    }

    /// `wrong` with a better hint, where a comma that separates may be a decimal comma.
    fn explain(self, wrong: Wrong, line: &str, cells: usize, columns: usize) -> Wrong {
        if self == Self::Comma && (line.contains(';') || (cells > columns && cells >= 2 * columns - 1)) {
            let hint = "are decimals written with commas? write them with points, and one separator between values";
            return Wrong { hint: hint.into(), ..wrong };
        }
        wrong
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn read(text: &str) -> Result<PointFile> {
        parse(Path::new("m.csv"), text)
    }

    fn spots(text: &str) -> Vec<(Option<String>, Spot)> {
        read(text).unwrap_or_else(|failure| panic!("{failure}")).points.into_iter().map(|p| (p.name, p.spot)).collect()
    }

    fn told(text: &str) -> Vec<String> {
        let text = read(text).unwrap_err().to_string();
        text.lines().map(|line| line.trim_start_matches("error: m.csv:").trim().to_owned()).collect()
    }

    fn named(name: &str, x: f64, y: f64, z: f64) -> (Option<String>, Spot) {
        (Some(name.into()), Spot::Position(Point3::new(x, y, z)))
    }

    #[test]
    fn every_separator_is_read_with_headings_and_without() {
        let expected = [named("nose", 1.0, 2.5, -3.0), named("left, ear", 0.0, 1e-3, 7.0)];
        for text in [
            "name,x,y,z\nnose,1,2.5,-3\n\"left, ear\",0,1e-3,7\n",
            "nose,1,2.5,-3\r\n\"left, ear\", 0, 1e-3, 7\r\n",
            "nose;1;2.5;-3\nleft, ear;0;1e-3;7",
            "nose\t1\t2.5\t-3\n# a remark\n\nleft, ear\t0\t1e-3\t7",
            "nose 1  2.5 -3\n\"left, ear\" 0 1e-3 7",
            "P[z];id;Label;P[x];P[y]\n-3;0;nose;1;2.5\n7;1;left, ear;0;1e-3",
        ] {
            assert_eq!(spots(text), expected, "{text}");
        }
    }

    #[test]
    fn vertices_and_triangles_are_read() {
        let name = |name: &str| Some(name.to_owned());
        assert_eq!(spots("nose,7\near,8\n"), [(name("nose"), Spot::Vertex(7)), (name("ear"), Spot::Vertex(8))]);
        assert_eq!(spots("---,Identifier,VertexIndex\nRow_0,nose,7\n"), [(name("nose"), Spot::Vertex(7))]);
        assert_eq!(spots("7\n8\n"), [(None, Spot::Vertex(7)), (None, Spot::Vertex(8))]);
        assert_eq!(spots("42, 0.25, 0.5\n1337, 0, 1\n")[0], (None, Spot::Triangle(42, [0.25, 0.5, 0.25])));
        assert_eq!(spots("0.5, 0.25, 0.5\n")[0], (None, Spot::Position(Point3::new(0.5, 0.25, 0.5))));
    }

    #[test]
    fn every_wrong_line_is_told_with_a_way_out() {
        assert_eq!(
            told("nose;1,5;2;3\near;1;2;3;\neye;1;2\nnose;a;2;3\nb;1;2;3\nb;1;2;4\n"),
            [
                "1: expected a number, found `1,5`",
                "hint: write decimals with a point: `1.5`",
                "2: expected 4 values, found 5: `ear, 1, 2, 3, `",
                "hint: remove the separator at the end of the line",
                "3: expected 4 values, found 3: `eye, 1, 2`",
                "hint: each line has as many values as the first; put names with separators in quotes",
                "4: expected a number, found `a`",
                "hint: coordinates are numbers such as `0.25` or `-1e-3`",
                "6: another point is called b (line 5)",
                "hint: give each its own name",
            ]
        );
        assert_eq!(
            told("nose,1,5,2,5,3,5\n"),
            [
                "1: expected `name, x, y, z` or `name, vertex`, found `nose,1,5,2,5,3,5`",
                "hint: are decimals written with commas? write them with points",
            ]
        );
        assert_eq!(told("name,x,y\na,1,2\n")[0], "1: expected the columns x, y, z or vertex, found name, x, y");
        assert_eq!(told("nose,7.5\n")[0], "1: expected the number of a vertex, found `7.5`");
    }

    proptest! {
        #[test]
        fn no_text_makes_the_reader_panic(text in "([a-z]{1,3}|[0-9.,;é\t\" -]|\n|name|vertex|x,y,z){0,40}") {
            let _ = read(&text);
        }

        #[test]
        fn points_come_back_as_written(
            points in prop::collection::vec(("[ -~é]{0,8}", prop::array::uniform3(-1e9..1e9f64)), 1..8),
        ) {
            let written: Vec<Written> = points
                .iter()
                .enumerate()
                .map(|(i, (name, at))| Written { name: format!("{name}{i}"), position: Point3::from(*at), ..Written::default() })
                .collect();
            let text = write(&written);
            let expected: Vec<_> = written.iter().map(|w| (Some(w.name.clone()), Spot::Position(w.position))).collect();
            prop_assert_eq!(spots(&text), expected, "{}", text);
        }
    }
}
