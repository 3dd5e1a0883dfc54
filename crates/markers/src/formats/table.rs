//! Points as tables: a line a point, values separated by commas, semicolons, tabs or blanks; a line of headings may precede.
//!
//! Without headings the columns are `name, x, y, z`, `name, vertex`, `x, y, z` or Wrap's `triangle, u, v`.

use std::{fmt::Write, path::Path};

use nalgebra::Point3;

use mimesh_core::mesh::MeshPoint;
use mimesh_document::{
    Diagnostics, Location, Result,
    cells::{with_formula, without_formula},
};

use super::{
    columns::{Column, Columns},
    rows::{Row, Separator, rows},
    wrap::Triple,
};
use crate::{
    points::{ExportPoint, NamedPoint, PointFile, PointPosition},
    text::{ParseError, index, number, shorten},
};

const POSITION: [Column; 3] = [Column::X, Column::Y, Column::Z];
const ON_TRIANGLE: [Column; 3] = [Column::Triangle, Column::U, Column::V];

/// Parses the text of `file`; blank lines and lines that begin with `#` are skipped.
///
/// # Errors
///
/// All that is wrong, each with its line.
pub fn parse(file: &Path, text: &str) -> Result<PointFile> {
    let mut result = PointFile::new(file);
    let lines = text.lines().zip(1..).filter(|(text, _)| !text.trim().is_empty() && !text.trim().starts_with('#'));
    let lines: Vec<(&str, usize)> = lines.map(|(text, line)| (without_blanks(text), line)).collect();
    let Some(&(head, first)) = lines.first() else { return Ok(result) };
    let location = |line| Location::Line { file: file.into(), line };
    let separator = Separator::of(head.trim());
    let rows = rows(&lines, separator);
    let mut diagnostics = Diagnostics::default();
    for row in rows.iter().filter(|row| row.spans_lines) {
        let error = ParseError::new("a quote has no end in its line", "close the quote, or remove it");
        diagnostics.push(error.at(location(row.line)));
    }
    if !diagnostics.is_empty() {
        return Err(diagnostics);
    }
    let headings = Columns::from_headings(&rows[0].cells);
    let has_headings = headings.is_some();
    let columns = match headings {
        Some(columns) => columns,
        None => Columns::from_values(&rows, separator).map_err(|error| error.at(location(first)))?,
    };
    if ![&POSITION[..], &ON_TRIANGLE, &[Column::Vertex]].into_iter().any(|needed| columns.have(needed)) {
        let found = shorten(&rows[0].cells.join(", "));
        let message = format!("expected the columns x, y, z or vertex, found {found}");
        return Err(ParseError::new(message, "e.g. `name,x,y,z` or `name,vertex`").at(location(first)).into());
    }
    for row in &rows[usize::from(has_headings)..] {
        let location = location(row.line);
        match point(&columns, &row.cells) {
            Ok((name, position)) => result.points.push(NamedPoint { name, position, location }),
            Err(error) if has_headings => diagnostics.push(error.at(location)),
            Err(error) => diagnostics.push(suspect_decimal_commas(error, separator, row, columns.len()).at(location)),
        }
    }
    diagnostics.extend(result.duplicate_names());
    diagnostics.into_result().map(|()| result)
}

/// `line` without blanks around it; a tab may be the end of an empty cell.
fn without_blanks(line: &str) -> &str {
    line.trim_matches(|c: char| c.is_whitespace() && c != '\t')
}

/// The text of a file with `points`: name, x, y and z.
pub fn write(points: &[ExportPoint]) -> String {
    let mut text = String::from("name,x,y,z\n");
    for ExportPoint { name, position: p, .. } in points {
        let _ = writeln!(text, "{},{},{},{}", cell(name), p.x, p.y, p.z);
    }
    text
}

/// A cell with `name`, in quotes where it has to be; a line break inside the name becomes a blank.
fn cell(name: &str) -> String {
    let name = name.replace(|c: char| c.is_control() || c == '\u{2028}' || c == '\u{2029}', " ");
    let name = without_formula(&name);
    let plain = name.trim() == name && !name.contains([',', ';', '"', '\t', '#']) && !name.is_empty();
    if plain { name.into_owned() } else { format!("\"{}\"", name.replace('"', "\"\"")) }
}

/// The name and the position of the point in a line.
fn point(columns: &Columns, cells: &[String]) -> std::result::Result<(Option<String>, PointPosition), ParseError> {
    check_count(columns, cells)?;
    let cell = |column| columns.cell(cells, column);
    let names = [cell(Column::Name), cell(Column::Number)];
    let name = names.into_iter().find(|name| !name.is_empty()).map(|name| with_formula(name).to_owned());
    let position = if columns.have(&[Column::Triangle, Column::U]) {
        let triangle = index(cell(Column::Triangle), "triangle")?;
        let numbers = [f64::from(triangle), number(cell(Column::U))?, number(cell(Column::V))?];
        Triple { numbers, begins_whole: true }.on_triangle()?
    } else if columns.have(&POSITION) {
        let [x, y, z] = POSITION.map(|column| number(cell(column)));
        PointPosition::InSpace(Point3::new(x?, y?, z?))
    } else {
        PointPosition::OnMesh(MeshPoint::Vertex(index(cell(Column::Vertex), "vertex")?))
    };
    Ok((name, position))
}

fn check_count(columns: &Columns, cells: &[String]) -> std::result::Result<(), ParseError> {
    if cells.len() == columns.len() {
        return Ok(());
    }
    let hint = if cells.last().is_some_and(String::is_empty) && cells.len() == columns.len() + 1 {
        "remove the separator at the end of the line"
    } else {
        "each line has as many values as the first; put names with separators in quotes, without a blank before them"
    };
    let found = shorten(&cells.join(", "));
    Err(ParseError::new(format!("expected {} values, found {}: `{found}`", columns.len(), cells.len()), hint))
}

/// `error` with a better hint, where a comma that separates may be a decimal comma.
fn suspect_decimal_commas(error: ParseError, separator: Separator, row: &Row<'_>, columns: usize) -> ParseError {
    let cells = row.cells.len();
    if separator == Separator::Comma && (row.text.contains(';') || (cells > columns && cells >= 2 * columns - 1)) {
        let hint = "are decimals written with commas? write them with points, and one separator between values";
        return ParseError { hint: hint.into(), ..error };
    }
    error
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::formats::testing::{self, vertex};

    fn read(text: &str) -> Result<PointFile> {
        parse(Path::new("m.csv"), text)
    }

    fn positions(text: &str) -> Vec<(Option<String>, PointPosition)> {
        testing::positions(read(text))
    }

    fn reported(text: &str) -> Vec<String> {
        let text = read(text).unwrap_err().to_string();
        text.lines().map(|line| line.trim_start_matches("error: m.csv:").trim().to_owned()).collect()
    }

    fn named(name: &str, x: f64, y: f64, z: f64) -> (Option<String>, PointPosition) {
        (Some(name.into()), PointPosition::InSpace(Point3::new(x, y, z)))
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
            assert_eq!(positions(text), expected, "{text}");
        }
    }

    #[test]
    fn empty_cells_at_either_end_of_a_line_with_tabs_count() {
        let expected = [named("n", 0.0, 1.0, 2.0)];
        assert_eq!(positions("name\tx\ty\tz\tnote\nn\t0\t1\t2\t\n"), expected);
        assert_eq!(positions("note\tname\tx\ty\tz\r\n\tn\t0\t1\t2\r\n"), expected);
        assert_eq!(positions("n,0,1,2\t\n"), expected, "a tab at the end separates nothing");
        assert_eq!(positions("\tn 0 1 2 \n"), expected, "nor does one at the beginning");
    }

    #[test]
    fn vertices_and_triangles_are_read() {
        let name = |name: &str| Some(name.to_owned());
        assert_eq!(positions("nose,7\near,8\n"), [(name("nose"), vertex(7)), (name("ear"), vertex(8))]);
        assert_eq!(positions("---,Identifier,VertexIndex\nRow_0,nose,7\n"), [(name("nose"), vertex(7))]);
        assert_eq!(positions("7\n8\n"), [(None, vertex(7)), (None, vertex(8))]);
        assert_eq!(
            positions("42, 0.25, 0.5\n1337, 0, 1\n")[0],
            (None, PointPosition::OnMesh(MeshPoint::Triangle(42, [0.25, 0.5, 0.25])))
        );
        assert_eq!(positions("0.5, 0.25, 0.5\n")[0], (None, PointPosition::InSpace(Point3::new(0.5, 0.25, 0.5))));
    }

    #[test]
    fn every_wrong_line_is_reported_with_a_way_out() {
        assert_eq!(
            reported("nose;1,5;2;3\near;1;2;3;\neye;1;2\nnose;a;2;3\nb;1;2;3\nb;1;2;4\n"),
            [
                "1: expected a number, found `1,5`",
                "hint: write decimals with a point: `1.5`",
                "2: expected 4 values, found 5: `ear, 1, 2, 3, `",
                "hint: remove the separator at the end of the line",
                "3: expected 4 values, found 3: `eye, 1, 2`",
                "hint: each line has as many values as the first; put names with separators in quotes, without a blank before them",
                "4: expected a number, found `a`",
                "hint: coordinates are numbers such as `0.25` or `-1e-3`",
                "6: another point is called b (line 5)",
                "hint: give each its own name",
            ]
        );
        assert_eq!(
            reported("nose,1,5,2,5,3,5\n"),
            [
                "1: expected `name, x, y, z` or `name, vertex`, found `nose,1,5,2,5,3,5`",
                "hint: are decimals written with commas? write them with points",
            ]
        );
        assert_eq!(
            reported("nose,1,2,3\n\"ear,1,2,3\neye,1,2,3\n\"tail\",1,2,3\n"),
            ["2: a quote has no end in its line", "hint: close the quote, or remove it"]
        );
        assert_eq!(reported("name,x,y\na,1,2\n")[0], "1: expected the columns x, y, z or vertex, found name, x, y");
        assert_eq!(reported("nose,7.5\n")[0], "1: expected the number of a vertex, found `7.5`");
    }

    #[test]
    fn names_are_no_formulas() {
        let point =
            |name: &str| ExportPoint { name: name.into(), position: Point3::origin(), point: MeshPoint::Vertex(0) };
        assert_eq!(write(&[point("=1+1"), point("-a,b")]), "name,x,y,z\n'=1+1,0,0,0\n\"'-a,b\",0,0,0\n");
        assert_eq!(positions("name,x,y,z\n'=1+1,0,0,0\n"), [named("=1+1", 0.0, 0.0, 0.0)]);
    }

    proptest! {
        #[test]
        fn no_text_makes_the_reader_panic(text in "([a-z]{1,3}|[0-9.,;é\t\" -]|\n|name|vertex|x,y,z){0,40}") {
            let _ = read(&text);
        }

        #[test]
        fn points_come_back_as_written(
            points in prop::collection::vec(("([!-~é][ -~é]{0,7})?", prop::array::uniform3(-1e9..1e9f64)), 1..8),
        ) {
            let written: Vec<ExportPoint> = points
                .iter()
                .enumerate()
                .map(|(i, (name, at))| ExportPoint { name: format!("{name}{i}"), position: Point3::from(*at), point: MeshPoint::Vertex(0) })
                .collect();
            let text = write(&written);
            let expected: Vec<_> = written.iter().map(|w| (Some(w.name.clone()), PointPosition::InSpace(w.position))).collect();
            prop_assert_eq!(positions(&text), expected, "{}", text);
        }
    }
}
