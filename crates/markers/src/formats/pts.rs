//! Points as `.pts`: a line a point, after what the program that wrote it puts first.
//!
//! | beginning | from | lines |
//! |---|---|---|
//! | `Version 1.0`, the count | Landmark Editor | `S000 x y z`; 9999 three times is a point that was not found |
//! | `version: 1`, `n_points: 68`, `{` … `}` | ibug | `x y z`; `x y` are points of a picture |
//! | the count, or nothing | tools of morphometrics | `x y z` or `name x y z` |

use std::path::Path;

use nalgebra::Point3;

use mimesh_document::{Diagnostic, Diagnostics, Kind, Location, Result};

use crate::{
    points::PointFile,
    text::{ParseError, number, shorten},
};

/// The coordinate that Landmark Editor writes for a point that was not found.
const MISSING: f64 = 9999.0;

/// Parses the text of `file`; lines that begin with `#` are skipped.
///
/// # Errors
///
/// Points of a picture, another number of points than the file says, and all lines that are wrong.
pub fn parse(file: &Path, text: &str) -> Result<PointFile> {
    let location = |line| Location::Line { file: file.into(), line };
    let lines = text.lines().map(str::trim).zip(1..);
    let mut lines: Vec<(&str, usize)> = lines.filter(|(text, _)| !text.is_empty() && !text.starts_with('#')).collect();
    let count = heading(&mut lines);
    let mut result = PointFile::new(file);
    let mut missing = Vec::new();
    let mut diagnostics = Diagnostics::default();
    for &(text, line) in &lines {
        let cells: Vec<&str> = text.split([' ', '\t', ',', ';']).filter(|cell| !cell.is_empty()).collect();
        match point(&cells) {
            Ok((name, [x, y, z])) if [x, y, z] == [MISSING; 3] => {
                missing.push(name.unwrap_or_else(|| format!("in line {line}")));
            }
            Ok((name, at)) => result.push_in_space(name, Point3::from(at), line),
            Err(_) if is_picture(&cells) => {
                let error = ParseError::new(
                    "these points have two coordinates: they lie on a picture, not on a mesh",
                    "give points with x, y and z, e.g. picked on the mesh in MeshLab or Blender",
                );
                return Err(error.at(location(line)).into());
            }
            Err(error) => diagnostics.push(error.at(location(line))),
        }
    }
    if let Some((count, line)) = count.filter(|(count, _)| *count != lines.len()) {
        let message = format!("expected {count} points, as this line says, found {}", lines.len());
        let diagnostic = Diagnostic::new(Kind::BadData, message).at(location(line));
        diagnostics.push(diagnostic.hint("was the file cut short? if not, correct the number"));
    }
    result.warn_of_left_out("not found when they were picked", &missing);
    diagnostics.extend(result.duplicate_names());
    diagnostics.into_result().map(|()| result)
}

/// Takes the lines that hold no points out; the number of points that they give, with its line.
fn heading(lines: &mut Vec<(&str, usize)>) -> Option<(usize, usize)> {
    let mut count = None;
    lines.retain(|(text, line)| {
        let lower = text.to_lowercase();
        let number = lower.strip_prefix("n_points").map(|rest| rest.trim_start_matches([':', '=', ' ']));
        let alone = count.is_none().then(|| text.parse().ok()).flatten();
        match number.and_then(|number| number.parse().ok()).or(alone) {
            Some(found) => count = Some((found, *line)),
            None => {
                return !((lower.starts_with("version") && text.split_whitespace().count() < 3)
                    || matches!(*text, "{" | "}")
                    || number.is_some());
            }
        }
        false
    });
    count
}

/// The name and the position in the cells of a line.
fn point(cells: &[&str]) -> std::result::Result<(Option<String>, [f64; 3]), ParseError> {
    let (name, place) = match cells {
        [x, y, z] => (None, [x, y, z]),
        [name, x, y, z] => (Some((*name).to_owned()), [x, y, z]),
        _ => {
            let message = format!("expected `x y z` or `name x y z`, found `{}`", shorten(&cells.join(" ")));
            return Err(ParseError::new(message, "write one point a line"));
        }
    };
    let [x, y, z] = place.map(|cell| number(cell));
    Ok((name, [x?, y?, z?]))
}

/// Whether the cells are a point of a picture.
fn is_picture(cells: &[&str]) -> bool {
    cells.len() == 2 && cells.iter().all(|cell| number(cell).is_ok())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{formats::testing, points::PointPosition};

    fn read(text: &str) -> Result<PointFile> {
        parse(Path::new("m.pts"), text)
    }

    fn at(x: f64, y: f64, z: f64) -> PointPosition {
        PointPosition::InSpace(Point3::new(x, y, z))
    }

    #[test]
    fn every_kind_with_three_coordinates_is_read() {
        let plain = [(None, at(1.0, 2.0, 3.0)), (None, at(4.5, 5.0, -6e-1))];
        for text in [
            "1 2 3\n4.5 5 -6e-1\n",
            "2\r\n1 2 3\r\n4.5\t5  -6e-1\r\n",
            "version: 1\nn_points: 2\n{\n1 2 3\n4.5 5 -6e-1\n}\n",
            "version: 1\nn_points:  2\n{\n1.0 2.0 3.0\n4.5 5 -0.6\n}",
        ] {
            assert_eq!(testing::positions(read(text)), plain, "{text}");
        }
        let editor = "Version 1.0\n3\nS000 1 2 3\nS001 9999 9999 9999\nC000 4.5 5 -.6\n";
        let name = |name: &str| Some(name.to_owned());
        let expected = [(name("S000"), at(1.0, 2.0, 3.0)), (name("C000"), at(4.5, 5.0, -0.6))];
        assert_eq!(testing::positions(read(editor)), expected);
        let told = "m.pts: 1 not found when they were picked and left out: S001";
        assert_eq!(read(editor).unwrap().warnings, [told]);
    }

    #[test]
    fn points_of_a_picture_are_refused() {
        for text in ["version: 1\nn_points: 2\n{\n30.5 44.25\n31 45\n}\n", "30.5 44.25\n31 45\n"] {
            let error = read(text).unwrap_err().to_string();
            assert!(error.contains("two coordinates: they lie on a picture, not on a mesh"), "{error}");
        }
    }

    #[test]
    fn what_is_wrong_is_reported_with_its_line() {
        let error = |text: &str| read(text).unwrap_err().to_string();
        assert!(
            error("3\n1 2 3\n4 5 6\n").starts_with("error: m.pts:1: expected 3 points, as this line says, found 2")
        );
        assert!(
            error("1 2 3\n1 2 3 4 5\n")
                .starts_with("error: m.pts:2: expected `x y z` or `name x y z`, found `1 2 3 4 5`")
        );
        assert!(error("a 1 2 x\n").starts_with("error: m.pts:1: expected a number, found `x`"));
        assert!(error("a 1 2 3\na 4 5 6\n").starts_with("error: m.pts:2: another point is called a (line 1)"));
    }
}
