//! Points of 3D Slicer as a table: lines of `#` tell the system and the columns.
//!
//! ```text
//! # Markups fiducial file version = 4.11
//! # CoordinateSystem = LPS
//! # columns = id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID
//! 1,-22.4,45.3,-10.1,0,0,0,1,1,1,0,nose,,
//! ```

use std::path::Path;

use nalgebra::Point3;

use mimesh_document::{Diagnostics, Location, Result};

use super::rows::{Separator, rows};
use crate::{
    anatomy::Anatomy,
    points::PointFile,
    text::{ParseError, number, quoted},
};

/// The columns of a file that does not name them.
const COLUMNS: &str = "id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID";

/// Parses the text of `file`; a file without a line on its system is in RAS.
///
/// # Errors
///
/// A system that is none of a mesh, and all points that are wrong, each with its line.
pub fn parse(file: &Path, text: &str) -> Result<PointFile> {
    let location = |line| Location::Line { file: file.into(), line };
    let mut result = PointFile { anatomy: Some(Anatomy::Ras), ..PointFile::new(file) };
    let mut columns = COLUMNS.to_owned();
    let mut points = Vec::new();
    for (text, line) in text.lines().map(str::trim).zip(1..) {
        match text.strip_prefix('#') {
            Some(heading) => {
                let Some((key, value)) = heading.split_once('=') else { continue };
                match key.trim().to_lowercase().as_str() {
                    "coordinatesystem" => {
                        result.anatomy = Some(anatomy(value.trim()).map_err(|error| error.at(location(line)))?);
                    }
                    "columns" => columns = value.trim().to_owned(),
                    _ => {}
                }
            }
            None if text.is_empty() => {}
            None => points.push((text, line)),
        }
    }
    let columns: Vec<String> = columns.split(',').map(|column| column.trim().to_lowercase()).collect();
    let column = |name: &str| columns.iter().position(|column| column == name);
    let (places, label) = (["x", "y", "z"].map(column), column("label"));
    // Later versions add it without naming it.
    let status = column("positionstatus").or_else(|| Some(column("associatednodeid")? + 1));
    let mut undefined = Vec::new();
    let mut short = None;
    let mut diagnostics = Diagnostics::default();
    for row in rows(&points, Separator::Comma) {
        if row.cells.len() < columns.len() {
            short.get_or_insert((row.line, row.cells.len()));
        }
        let cell = |column: Option<usize>| column.and_then(|c| row.cells.get(c)).map_or("", |cell| cell.trim());
        let name = Some(cell(label)).filter(|name| !name.is_empty()).map(str::to_owned);
        if matches!(cell(status), "0" | "1" | "3") {
            undefined.push(name.unwrap_or_else(|| format!("in line {}", row.line)));
            continue;
        }
        let found = places.map(|place| number(cell(place)));
        match found {
            [Ok(x), Ok(y), Ok(z)] => result.push_in_space(name, Point3::new(x, y, z), row.line),
            found => {
                let errors = ["x", "y", "z"].into_iter().zip(found).filter_map(|(axis, number)| {
                    let ParseError { message, hint } = number.err()?;
                    Some(ParseError { message: format!("`{axis}`: {message}"), hint })
                });
                diagnostics.extend(errors.map(|error| error.at(location(row.line))));
            }
        }
    }
    result.warn_of_left_out("without a position", &undefined);
    if let Some((line, cells)) = short {
        let columns = columns.len();
        result
            .warnings
            .push(format!("{}:{line}: {cells} cells for {columns} columns: is one missing?", file.display()));
    }
    diagnostics.extend(result.duplicate_names());
    diagnostics.into_result().map(|()| result)
}

/// The system that a file calls `name`; earlier versions have a number.
///
/// # Errors
///
/// If it is none of these.
pub fn anatomy(name: &str) -> std::result::Result<Anatomy, ParseError> {
    match name.to_uppercase().as_str() {
        "RAS" | "0" => Ok(Anatomy::Ras),
        "LPS" | "1" => Ok(Anatomy::Lps),
        _ => {
            let message = format!("expected the coordinate system LPS or RAS, found {}", quoted(name));
            Err(ParseError::new(message, "save the points in Slicer as LPS or RAS"))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{formats::testing, points::PointPosition};

    const HEAD: &str = "# Markups fiducial file version = 4.11\n# CoordinateSystem = LPS\n\
                        # columns = id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID\n";

    fn read(text: &str) -> Result<PointFile> {
        parse(Path::new("m.fcsv"), text)
    }

    fn at(x: f64, y: f64, z: f64) -> PointPosition {
        PointPosition::InSpace(Point3::new(x, y, z))
    }

    #[test]
    fn points_have_labels_and_a_system() {
        let file =
            read(&format!("{HEAD}1,1,2.5,-3,0,0,0,1,1,1,0,\"left, tip\",,\r\n2,4,5,6,0,0,0,1,1,1,0,,,\n")).unwrap();
        assert_eq!(file.anatomy, Some(Anatomy::Lps));
        assert_eq!(file.points[1].location, Location::Line { file: "m.fcsv".into(), line: 5 });
        let expected = [(Some("left, tip".to_owned()), at(1.0, 2.5, -3.0)), (None, at(4.0, 5.0, 6.0))];
        assert_eq!(testing::positions(Ok(file)), expected);
    }

    #[test]
    fn systems_of_all_versions_are_known() {
        for (line, expected) in [
            ("# CoordinateSystem = 0\n", Anatomy::Ras),
            ("# CoordinateSystem = RAS\n", Anatomy::Ras),
            ("# coordinateSystem = 1\n", Anatomy::Lps),
            ("#CoordinateSystem=lps\n", Anatomy::Lps),
            ("", Anatomy::Ras),
        ] {
            assert_eq!(read(&format!("{line}1,1,2,3")).unwrap().anatomy, Some(expected), "{line}");
        }
        let error = read("# x\n# CoordinateSystem = IJK\n1,1,2,3").unwrap_err().to_string();
        assert!(
            error.starts_with("error: m.fcsv:2: expected the coordinate system LPS or RAS, found `IJK`"),
            "{error}"
        );
    }

    #[test]
    fn columns_stand_as_the_file_names_them() {
        let text = "# Fiducial List file\n# columns = label,x,y,z,sel,vis\nnose,1,2,3,1,1\n";
        assert_eq!(testing::positions(read(text)), [(Some("nose".to_owned()), at(1.0, 2.0, 3.0))]);
    }

    #[test]
    fn points_without_a_position_are_left_out_and_told() {
        let text = format!("{HEAD}1,0,0,0,0,0,0,1,1,1,0,a,,,0,0\n2,1,2,3,0,0,0,1,1,1,0,b,,,2,0\n");
        let file = read(&text).unwrap();
        assert_eq!(file.warnings, ["m.fcsv: 1 without a position and left out: a"]);
        assert_eq!(file.points.len(), 1);
    }

    #[test]
    fn wrong_numbers_are_reported_with_their_lines() {
        let error = read(&format!("{HEAD}1,1,x,3,0,0,0,1,1,1,0,a,,\n2,1\n")).unwrap_err().to_string();
        assert!(error.contains("m.fcsv:4: `y`: expected a number, found `x`"), "{error}");
        assert!(error.contains("m.fcsv:5: `z`: expected a number, found nothing"), "{error}");
    }
}
