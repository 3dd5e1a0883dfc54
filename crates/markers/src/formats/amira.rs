//! Landmarks of Avizo and Amira as ASCII: one set of points, or a set for the source and one for the target.
//!
//! ```text
//! # AmiraMesh 3D ASCII 2.0
//! define Markers 2
//! Parameters { NumSets 2, ContentType "LandmarkSet" }
//! Markers { float[3] Coordinates } @1
//! Markers { float[3] Coordinates2 } @2
//! @1
//! 1 2 3
//! …
//! ```

use std::path::Path;

use nalgebra::Point3;

use mimesh_document::{Diagnostics, Location, Result};

use crate::{
    points::PointFile,
    text::{ParseError, number, quoted},
};

const SAVE_AGAIN: &str = "save the landmarks in Avizo as `LandmarkSet Ascii`";

/// Whether `text` is a file of Avizo or Amira.
pub fn is_amira(text: &str) -> bool {
    let first = text.trim_start().lines().next().unwrap_or_default().to_lowercase();
    first.starts_with('#') && ["amiramesh", "avizo", "hypermesh"].iter().any(|name| first.contains(name))
}

/// Parses the text of `file`: the points of each of its sets.
///
/// # Errors
///
/// Binary files, files without landmarks or with more than two sets of them, and all points that are wrong, each with its line.
pub fn parse(file: &Path, text: &str) -> Result<Vec<PointFile>> {
    let location = |line| Location::Line { file: file.into(), line };
    let wrong = |line, message: String| ParseError::new(message, SAVE_AGAIN).at(location(line));
    if !is_amira(text) {
        return Err(wrong(1, "expected `# AmiraMesh` or `# Avizo` in the first line".into()).into());
    }
    if text.trim_start().lines().next().is_some_and(|first| first.to_uppercase().contains("BINARY")) {
        return Err(wrong(1, "expected landmarks as ASCII, found a binary file".into()).into());
    }
    let lines: Vec<(&str, usize)> = text.lines().map(str::trim).zip(1..).collect();
    let is_data = |text: &str| text.strip_prefix('@').is_some_and(|label| label.parse::<u32>().is_ok());
    let header_end = lines.iter().position(|(text, _)| is_data(text)).unwrap_or(lines.len());
    let (header, data) = lines.split_at(header_end);
    let header: Vec<_> = header.iter().filter(|(text, _)| !text.starts_with('#')).collect();
    let count = header.iter().find_map(|(text, line)| {
        let mut words = text.split_whitespace();
        let is_markers = words.next()? == "define" && words.next()? == "Markers";
        Some((words.next().filter(|_| is_markers)?.parse::<usize>().ok()?, *line))
    });
    let labels: Vec<&str> = header.iter().filter_map(|(text, _)| coordinates_label(text)).collect();
    let (Some((count, line)), false) = (count, labels.is_empty()) else {
        return Err(
            wrong(1, "expected `define Markers` and `Markers { float[3] Coordinates }`, found none".into()).into()
        );
    };
    if labels.len() > 2 {
        return Err(wrong(line, format!("expected one or two sets of landmarks, found {}", labels.len())).into());
    }
    let mut diagnostics = Diagnostics::default();
    let sets = labels.iter().map(|label| {
        let mut set = PointFile::new(file);
        let rows = data.iter().skip_while(|(text, _)| text.strip_prefix('@') != Some(label)).skip(1);
        let rows = rows.take_while(|(text, _)| !is_data(text)).filter(|(text, _)| !text.is_empty()).take(count);
        for &(text, line) in rows {
            match position(text) {
                Ok(position) => set.push_in_space(None, position, line),
                Err(error) => diagnostics.push(error.at(location(line))),
            }
        }
        set
    });
    let sets: Vec<PointFile> = sets.collect();
    if let (true, Some(set)) = (diagnostics.is_empty(), sets.iter().find(|set| set.points.len() < count)) {
        diagnostics.push(wrong(line, format!("expected {count} landmarks in each set, found {}", set.points.len())));
    }
    diagnostics.into_result().map(|()| sets)
}

/// The label of the data of coordinates, if the line is about those: `Markers { float[3] Coordinates } @1`.
fn coordinates_label(text: &str) -> Option<&str> {
    let (field, label) = text.strip_prefix("Markers")?.split_once('}')?;
    let words: Vec<&str> = field.trim_start_matches([' ', '\t', '{']).split_whitespace().collect();
    let are_coordinates = matches!(words[..], ["float[3]" | "double[3]", name] if name.starts_with("Coordinates"));
    label.trim().trim_start_matches("=").trim().strip_prefix('@').map(str::trim).filter(|_| are_coordinates)
}

fn position(text: &str) -> std::result::Result<Point3<f64>, ParseError> {
    let numbers = text.split_whitespace().map(number).collect::<std::result::Result<Vec<_>, _>>()?;
    match numbers[..] {
        [x, y, z] => Ok(Point3::new(x, y, z)),
        _ => Err(ParseError::new(format!("expected three numbers, found {}", quoted(text)), SAVE_AGAIN)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TWO: &str = "# AmiraMesh 3D ASCII 2.0\n\n\ndefine Markers 2\n\nParameters {\n    NumSets 2,\n    ContentType \"LandmarkSet\"\n}\n\n\
                       Markers { float[3] Coordinates } @1\nMarkers { float[3] Coordinates2 } @2\n\n# Data section follows\n\
                       @1\n1 2 3 \n4.5e0 5 6\n\n@2\n7 8 9\n10 11 12\n\n";

    fn points(text: &str) -> Vec<Vec<[f64; 3]>> {
        let sets = parse(Path::new("m.landmarkAscii"), text).unwrap_or_else(|failure| panic!("{failure}"));
        let of_set = |set: &PointFile| set.positions_in_space().iter().map(|p| p.coords.into()).collect();
        sets.iter().map(of_set).collect()
    }

    fn first_line(text: &str) -> String {
        let failure = parse(Path::new("m.am"), text).unwrap_err().to_string();
        failure.lines().next().unwrap_or_default().to_owned()
    }

    #[test]
    fn one_or_two_sets_are_read() {
        let [first, second] = [vec![[1.0, 2.0, 3.0], [4.5, 5.0, 6.0]], vec![[7.0, 8.0, 9.0], [10.0, 11.0, 12.0]]];
        assert_eq!(points(TWO), [first.clone(), second]);
        let one = TWO.replace("Markers { float[3] Coordinates2 } @2\n", "Markers { int Type } @2\n");
        assert_eq!(points(&one.replace("# AmiraMesh 3D ASCII 2.0", "# Avizo 3D ASCII 3.0")), [first]);
    }

    #[test]
    fn what_is_wrong_is_reported_with_its_line() {
        assert_eq!(
            first_line("# AmiraMesh BINARY-LITTLE-ENDIAN 2.1\n"),
            "error: m.am:1: expected landmarks as ASCII, found a binary file"
        );
        assert!(first_line("1 2 3\n").contains("expected `# AmiraMesh`"));
        assert!(first_line("# Avizo 3D ASCII 2.0\ndefine Lattice 3 3 3\n").contains("expected `define Markers`"));
        assert_eq!(
            first_line(&TWO.replace("10 11 12\n", "")),
            "error: m.am:4: expected 2 landmarks in each set, found 1"
        );
        assert_eq!(first_line(&TWO.replace("7 8 9", "7 8")), "error: m.am:20: expected three numbers, found `7 8`");
        assert_eq!(first_line(&TWO.replace("7 8 9", "7 8 x")), "error: m.am:20: expected a number, found `x`");
    }
}
