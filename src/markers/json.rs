//! Points as JSON: Wrap's triangles, maps of names, lists of named points, and what scripts export from Blender.
//!
//! | contents | from |
//! |---|---|
//! | `[[42, 0.3, 0.5], …]` | Wrap: triangle, coordinates of its first and second corner; in order |
//! | `{"nose": [42, 0.3, 0.5], …}` | Wrap, with names |
//! | `{"nose": [x, y, z], …}`, `[[x, y, z], …]` | Blender empties, Houdini, Wrap's 3D points |
//! | `{"nose": 750, "ear": [12, 13, 14, 15], …}` | Blender vertex groups: a vertex, or the nearest to the mean of several |
//! | `[{"name": "nose", "position": [x, y, z]}, …]` | named points; also `vertex`, or `triangle` and `barycentric` |

use std::path::Path;

use nalgebra::Point3;
use serde_json::json;

use super::{
    json_tree::{self, Node, Value},
    points::{NamedPoint, PointFile, Spot, Triple},
    text::{Wrong, shorten},
    write::Written,
};
use crate::{
    core::mesh::SurfacePoint,
    diagnostic::{Diagnostic, Diagnostics, Location, Result},
};

/// Keys of a map that holds the points one level down.
const WRAPPERS: [&str; 9] =
    ["points", "landmarks", "markers", "empties", "objects", "vertexgroups", "groups", "keypoints", "pickedpoints"];
const NAMES: [&str; 5] = ["name", "identifier", "label", "id", "rowname"];
const POSITIONS: [&str; 8] = ["position", "location", "pos", "co", "p", "point", "xyz", "translation"];
const VERTICES: [&str; 6] = ["vertex", "vertexindex", "vertices", "index", "ptnum", "pointnumber"];
const TRIANGLES: [&str; 5] = ["triangle", "triangleindex", "face", "prim", "primnum"];
const BARYCENTRICS: [&str; 6] = ["barycentric", "barycentrics", "bary", "uv", "uvw", "weights"];

/// Parses the text of `file`.
///
/// # Errors
///
/// All that is wrong, each with its line.
pub fn parse(file: &Path, text: &str) -> Result<PointFile> {
    let location = |line: usize| Location::Line { file: file.into(), line };
    let mut root = json_tree::parse(text).map_err(|(line, wrong)| Diagnostics::from(wrong.at(location(line))))?;
    if let Value::Map(map) = &mut root.value
        && let Some(at) = map.iter().position(|(key, node)| WRAPPERS.contains(&plain(key).as_str()) && holds(node))
    {
        root = map.swap_remove(at).1;
    }
    let items: Vec<(Option<String>, Node)> = match root.value {
        Value::List(list) => list.into_iter().map(|item| (None, item)).collect(),
        Value::Map(map) => map.into_iter().map(|(name, item)| (Some(name), item)).collect(),
        _ => {
            let message = format!("expected a list or a map of points, found {}", root.found());
            return Err(Wrong { message, hint: "e.g. `{\"nose\": [0.1, 0.2, 0.3]}`".into() }
                .at(location(root.line))
                .into());
        }
    };
    let meaning = Meaning::of(items.iter().map(|(_, node)| node));
    let mut diagnostics: Vec<Diagnostic> = Vec::new();
    let mut result = PointFile { file: file.into(), ..PointFile::default() };
    let mut seen = std::collections::HashMap::new();
    for (key, node) in items {
        match point(key, &node, meaning) {
            Ok((name, spot)) => {
                let first = name.clone().and_then(|name| seen.insert(name, node.line));
                if let (Some(name), Some(first)) = (&name, first) {
                    let message = format!("another point is called {name} (line {first})");
                    diagnostics.push(Wrong { message, hint: "give each its own name".into() }.at(location(node.line)));
                }
                result.points.push(NamedPoint { name, spot, location: location(node.line) });
            }
            Err(wrong) => diagnostics.push(wrong.at(location(node.line))),
        }
    }
    if diagnostics.is_empty() { Ok(result) } else { Err(Diagnostics { diagnostics }) }
}

/// The text of a file with `points`: name, position, and the vertex or the place on a triangle.
pub fn write(points: &[Written]) -> String {
    let point = |Written { name, position: p, point }: &Written| match point {
        SurfacePoint::Vertex(vertex) => json!({ "name": name, "position": [p.x, p.y, p.z], "vertex": vertex }),
        SurfacePoint::Triangle(triangle, barycentric) => {
            json!({ "name": name, "position": [p.x, p.y, p.z], "triangle": triangle, "barycentric": barycentric })
        }
    };
    lines(points.iter().map(|written| point(written).to_string()))
}

/// The text of a file for Wrap: triangles with the coordinates of their first and second corner.
pub fn write_wrap(points: &[Written], triangle: impl Fn(SurfacePoint) -> (u32, [f64; 3])) -> String {
    let point = |written: &Written| {
        let (triangle, [u, v, _]) = triangle(written.point);
        // Wrap's own files have decimals here, by which they are told from positions.
        format!("[{triangle}, {u:?}, {v:?}]")
    };
    lines(points.iter().map(point))
}

fn lines(items: impl Iterator<Item = String>) -> String {
    let items: Vec<_> = items.map(|item| format!("  {item}")).collect();
    format!("[\n{}\n]\n", items.join(",\n"))
}

/// What lists of numbers mean in a file.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Meaning {
    Triangles,
    Positions,
    Vertices,
    /// Three whole numbers each: vertices or positions.
    Unclear,
}

impl Meaning {
    fn of<'a>(nodes: impl Iterator<Item = &'a Node>) -> Self {
        let mut triples = Vec::new();
        let mut all_whole = true;
        let mut other_lengths = false;
        for node in nodes {
            let Value::List(list) = &node.value else { continue };
            all_whole &= list.iter().all(|item| matches!(item.value, Value::Number(n, true) if n >= 0.0));
            match triple(list) {
                Some(triple) => triples.push(triple),
                None => other_lengths = true,
            }
        }
        match () {
            () if all_whole && other_lengths => Self::Vertices,
            () if Triple::are_triangles(triples.iter()) => Self::Triangles,
            () if all_whole && !triples.is_empty() => Self::Unclear,
            () => Self::Positions,
        }
    }
}

fn triple(list: &[Node]) -> Option<Triple> {
    let [a, b, c] = list else { return None };
    let number = |node: &Node| if let Value::Number(number, whole) = node.value { Some((number, whole)) } else { None };
    let [a, b, c] = [number(a)?, number(b)?, number(c)?];
    Some(Triple { numbers: [a.0, b.0, c.0], whole: a.1 })
}

fn point(key: Option<String>, node: &Node, meaning: Meaning) -> std::result::Result<(Option<String>, Spot), Wrong> {
    let wrong = |expected: &str| Wrong {
        message: format!(
            "{}expected {expected}, found {}",
            key.as_ref().map_or(String::new(), |k| format!("`{}`: ", shorten(k))),
            node.found()
        ),
        hint: "a point is `[x, y, z]`, a vertex, or `{ \"name\": …, \"position\": [x, y, z] }`; see docs/markers.md"
            .into(),
    };
    match &node.value {
        Value::Number(..) => {
            Ok((key.clone(), Spot::Vertex(whole(node).ok_or_else(|| wrong("the number of a vertex"))?)))
        }
        Value::List(list) => {
            let spot = match (meaning, triple(list)) {
                (Meaning::Triangles, Some(triple)) => triple.triangle().map_err(|message| Wrong {
                    message,
                    hint: "Wrap writes the triangle, then the coordinates of its first and second corner".into(),
                })?,
                (Meaning::Positions, Some(triple)) => triple.position(),
                (Meaning::Unclear, _) => {
                    return Err(Wrong {
                        message: format!("{} may be three vertices or a position", node.found()),
                        hint: "write `{ \"vertices\": [1, 2, 3] }`, or the position with decimals: `[1.0, 2.0, 3.0]`"
                            .into(),
                    });
                }
                (Meaning::Vertices, _) => vertices(list).ok_or_else(|| wrong("numbers of vertices"))?,
                _ => return Err(wrong("three numbers")),
            };
            Ok((key, spot))
        }
        Value::Map(map) => {
            let of =
                |known: &[&str]| map.iter().find(|(k, _)| known.contains(&plain(k).as_str())).map(|(_, node)| node);
            let name = match of(&NAMES).map(|node| &node.value) {
                Some(Value::Text(name)) => Some(name.clone()),
                Some(Value::Number(number, _)) => Some(format!("{number}")),
                _ => key.clone(),
            };
            let spot = spot(&of)?.ok_or_else(|| wrong("`position`, `vertex`, or `triangle` and `barycentric`"))?;
            Ok((name, spot))
        }
        _ => Err(wrong("a point")),
    }
}

/// The place that a map of a point tells; none if it tells none.
fn spot<'n>(of: &impl Fn(&[&str]) -> Option<&'n Node>) -> std::result::Result<Option<Spot>, Wrong> {
    let hint = || "see docs/markers.md for the ways to write a point".to_owned();
    if let Some(node) = of(&TRIANGLES)
        && let Some(weights) = of(&BARYCENTRICS)
    {
        let triangle = whole(node).ok_or_else(|| Wrong {
            message: format!("expected the number of a triangle, found {}", node.found()),
            hint: hint(),
        })?;
        let coordinates = numbers(weights).filter(|c| [2, 3].contains(&c.len())).ok_or_else(|| Wrong {
            message: format!("expected two or three barycentric coordinates, found {}", weights.found()),
            hint: hint(),
        })?;
        let [u, v] = [coordinates[0], coordinates[1]];
        let w = coordinates.get(2).copied().unwrap_or(1.0 - u - v);
        let barycentric = super::yaml::check_barycentric(&[u, v, w])
            .map_err(|message| Wrong { message, hint: "corners of the triangle in order, with a sum of 1".into() })?;
        return Ok(Some(Spot::Triangle(triangle, barycentric)));
    }
    if let Some(node) = of(&VERTICES) {
        let spot = match &node.value {
            Value::List(list) => vertices(list),
            _ => whole(node).map(Spot::Vertex),
        };
        let message = || format!("expected the number of a vertex, found {}", node.found());
        return spot.map(Some).ok_or_else(|| Wrong { message: message(), hint: hint() });
    }
    if let Some(node) = of(&POSITIONS) {
        let message = || format!("expected three numbers, found {}", node.found());
        let at = numbers(node).and_then(|numbers| <[f64; 3]>::try_from(numbers).ok());
        let at = at.ok_or_else(|| Wrong { message: message(), hint: "write them as `[x, y, z]`".into() })?;
        return Ok(Some(Spot::Position(Point3::from(at))));
    }
    let axes = ["x", "y", "z"]
        .map(|axis| of(&[axis]).and_then(|node| if let Value::Number(n, _) = node.value { Some(n) } else { None }));
    Ok(if let [Some(x), Some(y), Some(z)] = axes { Some(Spot::Position(Point3::new(x, y, z))) } else { None })
}

/// A key as it is compared: small letters without dashes and blanks.
fn plain(key: &str) -> String {
    key.chars().filter(|c| !"_- ".contains(*c)).collect::<String>().to_lowercase()
}

fn holds(node: &Node) -> bool {
    matches!(&node.value, Value::List(list) if list.iter().all(|item| !matches!(item.value, Value::Number(..))))
        || matches!(node.value, Value::Map(_))
}

fn whole(node: &Node) -> Option<u32> {
    match node.value {
        Value::Number(number, true) if (0.0..=f64::from(u32::MAX)).contains(&number) => Some(number as u32),
        _ => None,
    }
}

fn vertices(list: &[Node]) -> Option<Spot> {
    let vertices = list.iter().map(whole).collect::<Option<Vec<_>>>()?;
    match vertices[..] {
        [] => None,
        [vertex] => Some(Spot::Vertex(vertex)),
        _ => Some(Spot::Vertices(vertices)),
    }
}

fn numbers(node: &Node) -> Option<Vec<f64>> {
    let number = |node: &Node| if let Value::Number(number, _) = node.value { Some(number) } else { None };
    match &node.value {
        Value::List(list) => list.iter().map(number).collect(),
        Value::Map(map) => {
            let axis = |name: &str| map.iter().find(|(key, _)| plain(key) == name).and_then(|(_, node)| number(node));
            Some(vec![axis("x")?, axis("y")?, axis("z")?])
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn read(text: &str) -> Result<PointFile> {
        parse(Path::new("m.json"), text)
    }

    fn spots(text: &str) -> Vec<(Option<String>, Spot)> {
        read(text).unwrap_or_else(|failure| panic!("{failure}")).points.into_iter().map(|p| (p.name, p.spot)).collect()
    }

    fn first_lines(text: &str) -> Vec<String> {
        let text = read(text).unwrap_err().to_string();
        text.lines().filter_map(|line| line.strip_prefix("error: m.json:")).map(str::to_owned).collect()
    }

    fn at(x: f64, y: f64, z: f64) -> Spot {
        Spot::Position(Point3::new(x, y, z))
    }

    #[test]
    fn lists_that_begin_with_a_whole_number_and_lie_in_a_triangle_are_those_of_wrap() {
        assert_eq!(
            spots("[ [42, 0.25, 0.5], [1337, 0.0, 1.0] ]"),
            [(None, Spot::Triangle(42, [0.25, 0.5, 0.25])), (None, Spot::Triangle(1337, [0.0, 1.0, 0.0]))]
        );
        assert_eq!(spots("{\"a\": [42, 0.25, 0.5]}"), [(Some("a".into()), Spot::Triangle(42, [0.25, 0.5, 0.25]))]);
        assert_eq!(spots("[[42.0, 0.25, 0.5]]"), [(None, at(42.0, 0.25, 0.5))]);
        assert_eq!(spots("[[1, 0.25, -0.5], [0.5, 2, 3]]"), [(None, at(1.0, 0.25, -0.5)), (None, at(0.5, 2.0, 3.0))]);
    }

    #[test]
    fn names_stand_for_positions_vertices_or_groups_of_vertices() {
        let name = |name: &str| Some(name.to_owned());
        assert_eq!(
            spots("{\"b\": [0.5, 2, 3], \"a\": 7, \"c\": {\"location\": [1, 2, 3], \"type\": \"EMPTY\"}}"),
            [(name("b"), at(0.5, 2.0, 3.0)), (name("a"), Spot::Vertex(7)), (name("c"), at(1.0, 2.0, 3.0))]
        );
        assert_eq!(
            spots("{\"vertex_groups\": {\"ear\": [5, 6, 7, 8], \"eye\": [1, 2, 3], \"nose\": [9]}}"),
            [
                (name("ear"), Spot::Vertices(vec![5, 6, 7, 8])),
                (name("eye"), Spot::Vertices(vec![1, 2, 3])),
                (name("nose"), Spot::Vertex(9))
            ]
        );
        assert_eq!(
            spots(
                "{\"version\": 1, \"points\": [{\"Identifier\": \"nose\", \"VertexIndex\": 4}, \
                 {\"name\": \"b\", \"triangle\": 3, \"barycentric\": [0.5, 0.25]}, \
                 {\"name\": \"c\", \"position\": {\"x\": 1, \"y\": 2, \"z\": 3}}, {\"name\": \"d\", \"x\": 1, \"y\": 2, \"z\": 4}]}"
            ),
            [
                (name("nose"), Spot::Vertex(4)),
                (name("b"), Spot::Triangle(3, [0.5, 0.25, 0.25])),
                (name("c"), at(1.0, 2.0, 3.0)),
                (name("d"), at(1.0, 2.0, 4.0)),
            ]
        );
    }

    #[test]
    fn wrong_points_are_told_with_their_lines() {
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
                "2: `b`: expected a point, found the text `x`",
                "3: `c`: expected the number of a vertex, found -1",
                "4: `d`: expected `position`, `vertex`, or `triangle` and `barycentric`, found a map with the keys colour",
                "5: expected the number of a vertex, found 1.5",
            ]
        );
        assert_eq!(first_lines("{\"a\": [5, 6, 7]}"), ["1: [5, 6, 7] may be three vertices or a position"]);
        assert_eq!(
            first_lines("[{\"name\": \"a\", \"vertex\": 1},\n{\"name\": \"a\", \"vertex\": 2}]"),
            ["2: another point is called a (line 1)"]
        );
        assert_eq!(first_lines("3"), ["1: expected a list or a map of points, found 3"]);
        assert_eq!(first_lines("[[1, 2, 3],]"), ["1: not valid JSON: a comma before `]`"]);
    }

    fn written() -> impl Strategy<Value = Written> {
        let point = prop_oneof![
            any::<u32>().prop_map(SurfacePoint::Vertex),
            (any::<u32>(), 0.0..0.5f64, 0.0..0.5f64)
                .prop_map(|(t, u, v)| SurfacePoint::Triangle(t, [u, v, 1.0 - u - v])),
        ];
        (".{0,6}", prop::array::uniform3(-1e9..1e9f64), point).prop_map(|(name, at, point)| Written {
            name,
            position: Point3::from(at),
            point,
        })
    }

    proptest! {
        #[test]
        fn no_list_makes_the_reader_panic(text in "([\\[\\]{},:é ]|\"(name|position|vertex|a)\"|[0-9.e-]{1,4}){0,30}") {
            let _ = read(&text);
        }

        #[test]
        fn points_come_back_as_written(points in prop::collection::vec(written(), 1..8)) {
            let points: Vec<_> =
                points.into_iter().enumerate().map(|(i, p)| Written { name: format!("{}{i}", p.name), ..p }).collect();
            let back = spots(&write(&points));
            for ((name, spot), written) in back.into_iter().zip(&points) {
                prop_assert_eq!(name.as_ref(), Some(&written.name));
                let expected = match written.point {
                    SurfacePoint::Vertex(v) => Spot::Vertex(v),
                    SurfacePoint::Triangle(t, b) => Spot::Triangle(t, b),
                };
                prop_assert_eq!(spot, expected);
            }
        }
    }
}
