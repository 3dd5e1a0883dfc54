//! MeshLab's picked points: XML with an element `point` a point.
//!
//! ```xml
//! <PickedPoints>
//!  <point x="0.58" y="187.8" z="46.3" name="nose" active="1"/>
//! </PickedPoints>
//! ```

use std::{fmt::Write, path::Path};

use nalgebra::Point3;
use roxmltree::{Document, Error, Node, ParsingOptions};

use mimesh_document::{Diagnostic, Diagnostics, Location, Result};

use crate::{
    points::{ExportPoint, NamedPoint, PointFile, PointPosition},
    text::{Lines, ParseError, number, quoted, shorten},
};

/// Parses the text of `file`; points that are not active are left out, with a warning.
///
/// # Errors
///
/// A text that is no XML, at its first fault; otherwise all points that are wrong, each with its line.
pub fn parse(file: &Path, text: &str) -> Result<PointFile> {
    let document = document(file, text)?;
    let lines = Lines::new(text);
    let mut result = PointFile::new(file);
    let mut diagnostics = Diagnostics::default();
    let mut inactive = Vec::new();
    for node in document.descendants().filter(|node| node.tag_name().name() == "point") {
        let line = lines.line(node.range().start);
        let name = node.attribute("name").filter(|name| !name.is_empty()).map(str::to_owned);
        if matches!(node.attribute("active"), Some("0" | "false")) {
            inactive.push(name.unwrap_or_else(|| format!("in line {line}")));
            continue;
        }
        let location = Location::Line { file: file.into(), line };
        match coordinates(node) {
            Ok(at) => result.points.push(NamedPoint { name, position: PointPosition::InSpace(at), location }),
            Err(errors) => diagnostics.extend(errors.into_iter().map(|error| error.at(location.clone()))),
        }
    }
    result.warn_of_left_out("not active", &inactive);
    diagnostics.into_result().map(|()| result)
}

/// The text of a file with `points`, made on the mesh called `mesh`.
pub fn write(points: &[ExportPoint], mesh: &str) -> String {
    let mut text = format!(
        "<!DOCTYPE PickedPoints>\n<PickedPoints>\n <DocumentData>\n  <DataFileName name=\"{}\"/>\n </DocumentData>\n",
        escape(mesh)
    );
    for ExportPoint { name, position: p, .. } in points {
        let name = escape(name);
        let _ = writeln!(text, " <point x=\"{}\" y=\"{}\" z=\"{}\" name=\"{name}\" active=\"1\"/>", p.x, p.y, p.z);
    }
    text + "</PickedPoints>\n"
}

/// The XML document of a text, whose root is `PickedPoints`.
fn document<'t>(file: &Path, text: &'t str) -> Result<Document<'t>> {
    const SAVE_AGAIN: &str = "save the points with MeshLab's PickPoints tool";
    let location = |line| Location::Line { file: file.into(), line };
    if !text.trim_start().starts_with('<') {
        return Err(ParseError::new("expected `<PickedPoints>`, found no XML", SAVE_AGAIN).at(location(1)).into());
    }
    let options = ParsingOptions { allow_dtd: true, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text, options).map_err(|error| not_xml(text, &error, location))?;
    let root = document.root_element();
    if root.tag_name().name() != "PickedPoints" {
        let message = format!("expected `<PickedPoints>`, found {}", quoted(&format!("<{}>", root.tag_name().name())));
        let line = Lines::new(text).line(root.range().start);
        return Err(ParseError::new(message, SAVE_AGAIN).at(location(line)).into());
    }
    Ok(document)
}

/// The diagnostic of a text that is no XML.
fn not_xml(text: &str, error: &Error, location: impl Fn(usize) -> Location) -> Diagnostic {
    let position = error.pos();
    let (line, message) = match error {
        Error::UnexpectedEndOfStream | Error::UnclosedRootNode => {
            (text.lines().count(), "the file ends before `</PickedPoints>`".into())
        }
        Error::UnexpectedCloseTag(expected, found, _) => {
            (position.row as usize, format!("expected `</{}>`, found `</{}>`", shorten(expected), shorten(found)))
        }
        _ => (position.row as usize, error.to_string().replace(&format!(" at {position}"), "")),
    };
    let hint = match error {
        Error::UnknownEntityReference(..) | Error::MalformedEntityReference(_) => "write `&` as `&amp;`",
        _ => "the file is damaged or cut short: save it again, or mend the line",
    };
    ParseError::new(format!("not valid XML: {message}"), hint).at(location(line))
}

/// The position of a point.
fn coordinates(point: Node<'_, '_>) -> std::result::Result<Point3<f64>, Vec<ParseError>> {
    let mut errors = Vec::new();
    let coordinates = ["x", "y", "z"].map(|axis| {
        coordinate(point, axis).unwrap_or_else(|error| {
            errors.push(error);
            0.0
        })
    });
    if errors.is_empty() { Ok(Point3::from(coordinates)) } else { Err(errors) }
}

fn coordinate(point: Node<'_, '_>, axis: &str) -> std::result::Result<f64, ParseError> {
    let Some(text) = point.attribute(axis) else {
        let hint = "a point is `<point x=\"0\" y=\"0\" z=\"0\" name=\"nose\"/>`";
        return Err(ParseError::new(format!("the point has no `{axis}`"), hint));
    };
    number(text.trim()).map_err(|error| ParseError { message: format!("`{axis}`: {}", error.message), ..error })
}

/// `text` as the value of an attribute; characters that XML cannot hold are left out.
fn escape(text: &str) -> String {
    let mut escaped = String::new();
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\n' | '\t' | '\r' => {
                let _ = write!(escaped, "&#{};", u32::from(c));
            }
            '\u{fffe}' | '\u{ffff}' => {}
            c if c.is_control() => {}
            c => escaped.push(c),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use mimesh_core::mesh::MeshPoint;
    use proptest::prelude::*;

    use super::*;

    fn read(text: &str) -> Result<PointFile> {
        parse(Path::new("m.pp"), text)
    }

    fn first_lines(text: &str) -> Vec<String> {
        let text = read(text).unwrap_err().to_string();
        text.lines().filter_map(|line| line.strip_prefix("error: m.pp:")).map(str::to_owned).collect()
    }

    #[test]
    fn attributes_come_in_any_order_and_inactive_points_are_reported() {
        let file = read(
            "<!DOCTYPE PickedPoints>\r\n<PickedPoints>\n <!-- <point x=\"9\"/> -->\n <DocumentData><User name='a'/></DocumentData>\n \
             <point y=\"2\" name=\"a &amp; b\" x=\"1\" active=\"1\" z=\"3e-1\"/>\n <point x=\"0\" y=\"0\" z=\"0\" active=\"0\" name=\"c\"/>\n \
             <point x='4'\n z='6' y='5'></point></PickedPoints>",
        )
        .unwrap();
        assert_eq!(file.points[0].name.as_deref(), Some("a & b"));
        assert_eq!(file.points[0].position, PointPosition::InSpace(Point3::new(1.0, 2.0, 0.3)));
        assert_eq!(file.points[1].position, PointPosition::InSpace(Point3::new(4.0, 5.0, 6.0)));
        assert_eq!(file.points[1].location, Location::Line { file: "m.pp".into(), line: 7 });
        assert_eq!(file.warnings, ["m.pp: 1 not active and left out: c"]);
    }

    #[test]
    fn every_wrong_point_is_reported_with_its_line() {
        let text = "<PickedPoints>\n<point x=\"1,5\" y=\"0\" z=\"0\"/>\n<point x=\"1\" y=\"a\"/>\n</PickedPoints>\n";
        assert_eq!(
            first_lines(text),
            [
                "2: `x`: expected a number, found `1,5`",
                "3: `y`: expected a number, found `a`",
                "3: the point has no `z`",
            ]
        );
    }

    #[test]
    fn broken_xml_is_reported_at_its_first_fault() {
        let first = |text: &str| first_lines(text).remove(0);
        assert_eq!(
            first("<PickedPoints>\n<point x=1/>\n</PickedPoints>"),
            "2: not valid XML: expected a quote not '1'"
        );
        assert_eq!(
            first("<PickedPoints>\n<point x=\"1\">\n</PickedPoints>"),
            "3: not valid XML: expected `</point>`, found `</PickedPoints>`"
        );
        for cut in ["<PickedPoints>\n<point x=\"1", "<PickedPoints>\n<point x=\"1\"/>\n"] {
            assert_eq!(first(cut), "2: not valid XML: the file ends before `</PickedPoints>`", "{cut}");
        }
        let hint = read("<PickedPoints>\n<point name=\"a & b\"/>").unwrap_err().list[0].hint.clone();
        assert_eq!(hint.as_deref(), Some("write `&` as `&amp;`"));
        assert_eq!(first_lines("<html>\n</html>"), ["1: expected `<PickedPoints>`, found `<html>`"]);
        assert_eq!(first_lines("1 2 3"), ["1: expected `<PickedPoints>`, found no XML"]);
    }

    proptest! {
        #[test]
        fn no_text_makes_the_reader_panic(text in "(<(!--|[?]|/|point |PickedPoints)?|[a-z=\"'>/ &;#x\n]|[xyz]=\"[0-9.,é]*\"){0,40}") {
            let _ = read(&text);
        }

        #[test]
        fn points_come_back_as_written(
            points in prop::collection::vec(("[ -~é\t]{1,8}", prop::array::uniform3(-1e9..1e9f64)), 0..8),
        ) {
            let written: Vec<_> = points
                .iter()
                .map(|(name, at)| ExportPoint {
                    name: name.clone(),
                    position: Point3::from(*at),
                    point: MeshPoint::Vertex(0),
                })
                .collect();
            let back = read(&write(&written, "a \"b\"")).unwrap();
            let back: Vec<_> = back.points.into_iter().map(|p| (p.name, p.position)).collect();
            let expected: Vec<_> =
                points.into_iter().map(|(name, at)| (Some(name), PointPosition::InSpace(Point3::from(at)))).collect();
            prop_assert_eq!(back, expected);
        }
    }
}
