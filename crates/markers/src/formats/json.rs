//! Points as JSON: Wrap's triangles, mappings of names, sequences of named points, and what scripts export from Blender.
//!
//! | contents | from |
//! |---|---|
//! | `[[42, 0.3, 0.5], …]` | Wrap: triangle, coordinates of its first and second corner; in order |
//! | `{"nose": [42, 0.3, 0.5], …}` | Wrap, with names |
//! | `{"nose": [x, y, z], …}`, `[[x, y, z], …]` | Blender empties, Houdini, Wrap's 3D points |
//! | `{"nose": 750, "ear": [12, 13, 14, 15], …}` | Blender vertex groups: a vertex, or the nearest to the mean of several |
//! | `{"markups": [{"controlPoints": […]}]}` | 3D Slicer |
//! | `[{"name": "nose", "position": [x, y, z]}, …]` | named points; also `vertex`, or `triangle` and `barycentric` |

use std::path::Path;

use jsonc_parser::{ast::Value, common::Ranged};
use serde_json::json;

use mimesh_core::mesh::MeshPoint;
use mimesh_document::{Diagnostics, Location, Result};

use super::{
    json_point::{Meaning, point},
    json_syntax::{self, describe, is_number, normalized},
    markups,
};
use crate::{
    points::{ExportPoint, NamedPoint, PointFile},
    text::{Lines, ParseError},
};

/// Keys of a mapping that holds the points one level down.
const CONTAINERS: [&str; 9] =
    ["points", "landmarks", "markers", "empties", "objects", "vertexgroups", "groups", "keypoints", "pickedpoints"];

/// Parses the text of `file`.
///
/// # Errors
///
/// A text that is no JSON, at its first fault; otherwise all points that are wrong, each with its line.
pub fn parse(file: &Path, text: &str) -> Result<PointFile> {
    let lines = Lines::new(text);
    let location = |offset: usize| Location::Line { file: file.into(), line: lines.line(offset) };
    let root = json_syntax::parse(text).map_err(|(offset, error)| Diagnostics::from(error.at(location(offset))))?;
    if let Some(all) = markups::markups(&root) {
        return markups::points(file, &lines, all);
    }
    let root = contained(&root);
    let items: Vec<(Option<&str>, &Value<'_>)> = match root {
        Value::Array(array) => array.elements.iter().map(|item| (None, item)).collect(),
        Value::Object(object) => object.properties.iter().map(|item| (Some(item.name.as_str()), &item.value)).collect(),
        _ => {
            let message = format!("expected a sequence or a mapping of points, found {}", describe(root));
            return Err(ParseError::new(message, "e.g. `{\"nose\": [0.1, 0.2, 0.3]}`")
                .at(location(root.start()))
                .into());
        }
    };
    let meaning = Meaning::of(items.iter().filter_map(|(_, value)| value.as_array()));
    let mut result = PointFile::new(file);
    let mut diagnostics = Diagnostics::default();
    for (key, value) in items {
        let location = location(value.start());
        match point(key, value, meaning) {
            Ok((name, position)) => result.points.push(NamedPoint { name, position, location }),
            Err(error) => diagnostics.push(error.at(location)),
        }
    }
    diagnostics.extend(result.duplicate_names());
    diagnostics.into_result().map(|()| result)
}

/// The text of a file with `points`: name, position, and the vertex or the place on a triangle.
pub fn write(points: &[ExportPoint]) -> String {
    let lines: Vec<_> = points.iter().map(|point| format!("  {}", item(point))).collect();
    format!("[\n{}\n]\n", lines.join(",\n"))
}

fn item(ExportPoint { name, position: p, point }: &ExportPoint) -> serde_json::Value {
    match point {
        MeshPoint::Vertex(vertex) => json!({ "name": name, "position": [p.x, p.y, p.z], "vertex": vertex }),
        MeshPoint::Triangle(triangle, barycentric) => {
            json!({ "name": name, "position": [p.x, p.y, p.z], "triangle": triangle, "barycentric": barycentric })
        }
    }
}

/// The points in `root`, where they stand below a key such as `points`; else `root`.
fn contained<'v, 't>(root: &'v Value<'t>) -> &'v Value<'t> {
    let properties = root.as_object().map(|object| &object.properties[..]).unwrap_or_default();
    let container = properties.iter().find(|property| {
        CONTAINERS.contains(&normalized(property.name.as_str()).as_str()) && is_container(&property.value)
    });
    container.map_or(root, |property| &property.value)
}

/// Whether `value` holds points rather than being one.
fn is_container(value: &Value<'_>) -> bool {
    match value {
        Value::Array(array) => !array.elements.iter().any(is_number),
        Value::Object(_) => true,
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;
    use proptest::prelude::*;

    use super::*;
    use crate::{
        formats::testing::{self, vertex},
        points::PointPosition,
    };

    fn read(text: &str) -> Result<PointFile> {
        parse(Path::new("m.json"), text)
    }

    fn positions(text: &str) -> Vec<(Option<String>, PointPosition)> {
        testing::positions(read(text))
    }

    fn first_lines(text: &str) -> Vec<String> {
        let text = read(text).unwrap_err().to_string();
        text.lines().filter_map(|line| line.strip_prefix("error: m.json:")).map(str::to_owned).collect()
    }

    fn at(x: f64, y: f64, z: f64) -> PointPosition {
        PointPosition::InSpace(Point3::new(x, y, z))
    }

    fn on_triangle(triangle: u32, barycentric: [f64; 3]) -> PointPosition {
        PointPosition::OnMesh(MeshPoint::Triangle(triangle, barycentric))
    }

    #[test]
    fn sequences_that_begin_with_a_whole_number_and_lie_in_a_triangle_are_those_of_wrap() {
        assert_eq!(
            positions("[ [42, 0.25, 0.5], [1337, 0.0, 1.0] ]"),
            [(None, on_triangle(42, [0.25, 0.5, 0.25])), (None, on_triangle(1337, [0.0, 1.0, 0.0]))]
        );
        assert_eq!(positions("{\"a\": [42, 0.25, 0.5]}"), [(Some("a".into()), on_triangle(42, [0.25, 0.5, 0.25]))]);
        assert_eq!(positions("[[42.0, 0.25, 0.5]]"), [(None, at(42.0, 0.25, 0.5))]);
        assert_eq!(
            positions("[[1, 0.25, -0.5], [0.5, 2, 3]]"),
            [(None, at(1.0, 0.25, -0.5)), (None, at(0.5, 2.0, 3.0))]
        );
    }

    #[test]
    fn names_stand_for_positions_vertices_or_groups_of_vertices() {
        let name = |name: &str| Some(name.to_owned());
        assert_eq!(
            positions("{\"b\": [0.5, 2, 3], \"a\": 7, \"c\": {\"location\": [1, 2, 3], \"type\": \"EMPTY\"}}"),
            [(name("b"), at(0.5, 2.0, 3.0)), (name("a"), vertex(7)), (name("c"), at(1.0, 2.0, 3.0))]
        );
        assert_eq!(
            positions("{\"vertex_groups\": {\"ear\": [5, 6, 7, 8], \"eye\": [1, 2, 3], \"nose\": [9]}}"),
            [
                (name("ear"), PointPosition::MeanOfVertices(vec![5, 6, 7, 8])),
                (name("eye"), PointPosition::MeanOfVertices(vec![1, 2, 3])),
                (name("nose"), vertex(9))
            ]
        );
        assert_eq!(
            positions(
                "{\"version\": 1, \"points\": [{\"Identifier\": \"nose\", \"VertexIndex\": 4}, \
                 {\"name\": \"b\", \"triangle\": 3, \"barycentric\": [0.5, 0.25]}, \
                 {\"name\": \"c\", \"position\": {\"x\": 1, \"y\": 2, \"z\": 3}}, {\"name\": \"d\", \"x\": 1, \"y\": 2, \"z\": 4}]}"
            ),
            [
                (name("nose"), vertex(4)),
                (name("b"), on_triangle(3, [0.5, 0.25, 0.25])),
                (name("c"), at(1.0, 2.0, 3.0)),
                (name("d"), at(1.0, 2.0, 4.0)),
            ]
        );
    }

    #[test]
    fn wrong_points_are_reported_with_their_lines() {
        assert_eq!(
            first_lines("[\n[1, 0.2, 0.3],\n[2, 0.2, 0.3],\n[3, 0.8, 0.9]\n]"),
            ["4: expected `[triangle, u, v]` with u and v from 0 to 1 and a sum of 1 at most, found `[3, 0.8, 0.9]`"]
        );
        assert_eq!(
            first_lines(
                "{\"a\": [1.5, 2],\n\"b\": \"x\",\n\"c\": -1,\n\"d\": {\"colour\": 1},\n\"e\": {\"name\": \"b2\", \"vertex\": 1.5}}"
            ),
            [
                "1: `a`: expected three numbers, found [1.5, 2]",
                "2: `b`: expected a point, found the string `x`",
                "3: `c`: expected the number of a vertex, found -1",
                "4: `d`: expected `position`, `vertex`, or `triangle` and `barycentric`, found a mapping with the keys colour",
                "5: expected the number of a vertex, found 1.5",
            ]
        );
        assert_eq!(first_lines("{\"a\": [5, 6, 7]}"), ["1: [5, 6, 7] may be three vertices or a position"]);
        assert_eq!(
            first_lines("[{\"name\": \"a\", \"vertex\": 1},\n{\"name\": \"a\", \"vertex\": 2}]"),
            ["2: another point is called a (line 1)"]
        );
        assert_eq!(first_lines("3"), ["1: expected a sequence or a mapping of points, found 3"]);
        assert_eq!(first_lines("[[1, 2, 3],]"), ["1: not valid JSON: expected a value behind the comma, found `]`"]);
    }

    fn written() -> impl Strategy<Value = ExportPoint> {
        let point = prop_oneof![
            any::<u32>().prop_map(MeshPoint::Vertex),
            (any::<u32>(), 0.0..0.5f64, 0.0..0.5f64).prop_map(|(t, u, v)| MeshPoint::Triangle(t, [u, v, 1.0 - u - v])),
        ];
        (".{0,6}", prop::array::uniform3(-1e9..1e9f64), point).prop_map(|(name, at, point)| ExportPoint {
            name,
            position: Point3::from(at),
            point,
        })
    }

    proptest! {
        #[test]
        fn no_text_makes_the_reader_panic(text in "([\\[\\]{},:é ]|\"(name|position|vertex|a)\"|[0-9.e-]{1,4}){0,30}") {
            let _ = read(&text);
        }

        #[test]
        fn points_come_back_as_written(points in prop::collection::vec(written(), 1..8)) {
            let points: Vec<_> =
                points.into_iter().enumerate().map(|(i, p)| ExportPoint { name: format!("{}{i}", p.name), ..p }).collect();
            let back = positions(&write(&points));
            for ((name, position), written) in back.into_iter().zip(&points) {
                prop_assert_eq!(name.as_ref(), Some(&written.name));
                prop_assert_eq!(position, PointPosition::OnMesh(written.point));
            }
        }
    }
}
