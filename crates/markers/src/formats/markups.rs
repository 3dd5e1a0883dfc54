//! Points of 3D Slicer as JSON (`.mrk.json`): `markups` with a system and `controlPoints`.

use std::path::Path;

use jsonc_parser::{
    ast::{Object, Value},
    common::Ranged,
};
use nalgebra::Point3;

use mimesh_document::{Diagnostics, Location, Result};

use super::{
    fcsv::anatomy,
    json_syntax::{describe, get, number},
};
use crate::{
    anatomy::Anatomy,
    points::PointFile,
    text::{Lines, ParseError},
};

/// The sequence `markups` of a file of 3D Slicer; `None` if it is none.
pub fn markups<'v, 't>(root: &'v Value<'t>) -> Option<&'v [Value<'t>]> {
    let all = get(root.as_object()?, &["markups"])?.as_array()?;
    let has_points =
        |value: &Value<'_>| value.as_object().is_some_and(|markup| get(markup, &["controlpoints"]).is_some());
    all.elements.iter().any(has_points).then_some(&all.elements)
}

/// The points of `all`: those of fiducials if there are such, in the system of the first.
///
/// # Errors
///
/// A system that is none of a mesh, and all points that are wrong, each with its line.
pub fn points(file: &Path, lines: &Lines, all: &[Value<'_>]) -> Result<PointFile> {
    let location = |offset: usize| Location::Line { file: file.into(), line: lines.line(offset) };
    let markups: Vec<&Object<'_>> = all.iter().filter_map(Value::as_object).collect();
    let is_list = |markup: &Object<'_>| matches!(string(markup, "type"), None | Some("Fiducial"));
    let any_list = markups.iter().any(|markup| is_list(markup));
    let mut result = PointFile::new(file);
    let (mut others, mut undefined) = (Vec::new(), Vec::new());
    let mut diagnostics = Diagnostics::default();
    for markup in markups {
        if any_list && !is_list(markup) {
            others.push(string(markup, "type").unwrap_or_default().to_owned());
            continue;
        }
        // Slicer itself reads a file without this key as LPS.
        let system = string(markup, "coordinatesystem").map_or(Ok(Anatomy::Lps), anatomy);
        let system = system.map_err(|error| error.at(location(markup.start())))?;
        let turn = system != *result.anatomy.get_or_insert(system);
        let points = get(markup, &["controlpoints"]).and_then(|points| points.as_array());
        for value in points.iter().flat_map(|points| &points.elements) {
            let Some(point) = value.as_object() else {
                let message = format!("expected a control point, found {}", describe(value));
                diagnostics.push(ParseError::new(message, "save the markups again").at(location(value.start())));
                continue;
            };
            let name = string(point, "label").filter(|label| !label.is_empty()).map(str::to_owned);
            let line = lines.line(value.start());
            if string(point, "positionstatus").is_some_and(|status| status != "defined") {
                undefined.push(name.unwrap_or_else(|| format!("in line {line}")));
                continue;
            }
            match position(point) {
                Ok(position) => {
                    let position = if turn { Anatomy::turned(&position) } else { position };
                    result.push_in_space(name, position, line);
                }
                Err(error) => diagnostics.push(error.at(location(value.start()))),
            }
        }
    }
    result.warn_of_left_out("without a position", &undefined);
    result.warn_of_left_out("that are no lists of points", &others);
    diagnostics.extend(result.duplicate_names());
    diagnostics.into_result().map(|()| result)
}

fn position(point: &Object<'_>) -> std::result::Result<Point3<f64>, ParseError> {
    let value = get(point, &["position"]);
    let numbers = value.and_then(|value| value.as_array()).map(|array| &array.elements[..]).unwrap_or_default();
    let numbers: Option<Vec<f64>> = numbers.iter().map(number).collect();
    let numbers: Option<[f64; 3]> = numbers.and_then(|numbers| numbers.try_into().ok());
    numbers.map(Point3::from).ok_or_else(|| {
        let found = value.map_or("none".into(), describe);
        ParseError::new(format!("expected a `position` of three numbers, found {found}"), "place the point in Slicer")
    })
}

fn string<'v>(object: &'v Object<'_>, key: &str) -> Option<&'v str> {
    Some(&*get(object, &[key])?.as_string_lit()?.value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{formats::json::parse, points::PointPosition};

    fn read(text: &str) -> Result<PointFile> {
        parse(Path::new("m.mrk.json"), text)
    }

    #[test]
    fn control_points_are_read_in_their_system() {
        let file = read(
            r#"{"@schema": "https://…/markups-schema-v1.0.3.json#", "markups": [
              {"type": "Fiducial", "coordinateSystem": "RAS", "controlPoints": [
                {"id": "1", "label": "nose", "position": [1, 2, 3], "positionStatus": "defined", "selected": true},
                {"id": "2", "label": "ear", "position": [], "positionStatus": "undefined"}]},
              {"type": "Plane", "coordinateSystem": "RAS", "controlPoints": [{"label": "p", "position": [9, 9, 9]}]},
              {"type": "Fiducial", "coordinateSystem": "LPS", "controlPoints": [{"label": "", "position": [4, 5, 6]}]}]}"#,
        )
        .unwrap();
        assert_eq!(file.anatomy, Some(Anatomy::Ras));
        let at = |x, y, z| PointPosition::InSpace(Point3::new(x, y, z));
        let points: Vec<_> = file.points.iter().map(|p| (p.name.as_deref(), p.position.clone())).collect();
        assert_eq!(points, [(Some("nose"), at(1.0, 2.0, 3.0)), (None, at(-4.0, -5.0, 6.0))]);
        let told = ["1 without a position and left out: ear", "1 that are no lists of points and left out: Plane"];
        assert_eq!(file.warnings, told.map(|told| format!("m.mrk.json: {told}")));
    }

    #[test]
    fn wrong_points_are_reported_with_their_lines() {
        let error =
            read("{\"markups\": [{\"controlPoints\": [\n{\"position\": [1, 2]},\n7]}]}").unwrap_err().to_string();
        assert!(error.contains("m.mrk.json:2: expected a `position` of three numbers, found [1, 2]"), "{error}");
        assert!(error.contains("m.mrk.json:3: expected a control point, found 7"), "{error}");
        let error =
            read("{\"markups\": [\n{\"coordinateSystem\": \"IJK\", \"controlPoints\": []}]}").unwrap_err().to_string();
        assert!(error.contains("m.mrk.json:2: expected the coordinate system LPS or RAS"), "{error}");
    }
}
