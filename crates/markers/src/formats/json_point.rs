//! A point of a JSON file: a vertex, a sequence of numbers, or a mapping.

use jsonc_parser::ast::{Array, Object, Value};
use nalgebra::Point3;

use mimesh_core::mesh::MeshPoint;

use super::{
    json_syntax::{describe, get, index, is_number, is_whole, number},
    wrap::Triple,
};
use crate::{
    points::PointPosition,
    text::{ParseError, barycentric, shorten},
};

const NAMES: [&str; 5] = ["name", "identifier", "label", "id", "rowname"];
const POSITIONS: [&str; 8] = ["position", "location", "pos", "co", "p", "point", "xyz", "translation"];
const VERTICES: [&str; 6] = ["vertex", "vertexindex", "vertices", "index", "ptnum", "pointnumber"];
const TRIANGLES: [&str; 5] = ["triangle", "triangleindex", "face", "prim", "primnum"];
const BARYCENTRICS: [&str; 6] = ["barycentric", "barycentrics", "bary", "uv", "uvw", "weights"];
const SEE_DOCUMENTATION: &str = "see docs/markers.md for the ways to write a point";

type Parsed<T> = std::result::Result<T, ParseError>;

/// The meaning that sequences of numbers have in a file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Meaning {
    /// Triangles with two coordinates, as Wrap writes them.
    Triangles,
    /// Positions in space.
    Positions,
    /// Groups of vertices.
    Vertices,
    /// Three whole numbers each: vertices or positions.
    Unclear,
}

impl Meaning {
    /// The meaning of the sequences `arrays` of a file together.
    pub fn of<'v, 't: 'v>(arrays: impl Iterator<Item = &'v Array<'t>>) -> Self {
        let arrays: Vec<_> = arrays.collect();
        let triples: Vec<Triple> = arrays.iter().filter_map(|array| triple(array)).collect();
        let all_whole = arrays.iter().all(|array| array.elements.iter().all(is_whole_from_zero));
        if all_whole && triples.len() < arrays.len() {
            Self::Vertices
        } else if Triple::are_triangles(&triples) {
            Self::Triangles
        } else if all_whole && !triples.is_empty() {
            Self::Unclear
        } else {
            Self::Positions
        }
    }
}

fn is_whole_from_zero(value: &Value<'_>) -> bool {
    is_whole(value) && number(value).is_some_and(|number| number >= 0.0)
}

fn triple(array: &Array<'_>) -> Option<Triple> {
    let numbers = numbers(&array.elements)?;
    Some(Triple { numbers, begins_whole: is_whole(&array.elements[0]) })
}

fn numbers<const N: usize>(values: &[Value<'_>]) -> Option<[f64; N]> {
    values.iter().map(number).collect::<Option<Vec<_>>>()?.try_into().ok()
}

/// The name and the position of the point `value`, which has the name `key` if it stands in a mapping.
///
/// # Errors
///
/// If `value` is no point.
pub fn point(key: Option<&str>, value: &Value<'_>, meaning: Meaning) -> Parsed<(Option<String>, PointPosition)> {
    let key_name = || key.map(str::to_owned);
    match value {
        Value::NumberLit(_) => {
            let vertex = index(value).ok_or_else(|| wrong_point(key, "the number of a vertex", value))?;
            Ok((key_name(), PointPosition::OnMesh(MeshPoint::Vertex(vertex))))
        }
        Value::Array(array) => Ok((key_name(), of_array(key, value, array, meaning)?)),
        Value::Object(object) => {
            let name = match get(object, &NAMES) {
                Some(Value::StringLit(name)) => Some(name.value.clone().into_owned()),
                Some(value) if is_number(value) => number(value).map(|number| number.to_string()),
                _ => key_name(),
            };
            let expected = "`position`, `vertex`, or `triangle` and `barycentric`";
            Ok((name, of_object(object)?.ok_or_else(|| wrong_point(key, expected, value))?))
        }
        _ => Err(wrong_point(key, "a point", value)),
    }
}

fn wrong_point(key: Option<&str>, expected: &str, value: &Value<'_>) -> ParseError {
    let key = key.map_or(String::new(), |key| format!("`{}`: ", shorten(key)));
    ParseError::new(
        format!("{key}expected {expected}, found {}", describe(value)),
        "a point is `[x, y, z]`, a vertex, or `{ \"name\": …, \"position\": [x, y, z] }`; see docs/markers.md",
    )
}

/// The position that the sequence `array`, which is `value`, gives in a file where sequences mean `meaning`.
fn of_array(key: Option<&str>, value: &Value<'_>, array: &Array<'_>, meaning: Meaning) -> Parsed<PointPosition> {
    match (meaning, triple(array)) {
        (Meaning::Triangles, Some(triple)) => triple.on_triangle(),
        (Meaning::Positions, Some(triple)) => Ok(triple.in_space()),
        (Meaning::Unclear, _) => Err(ParseError::new(
            format!("{} may be three vertices or a position", describe(value)),
            "write `{ \"vertices\": [1, 2, 3] }`, or the position with decimals: `[1.0, 2.0, 3.0]`",
        )),
        (Meaning::Vertices, _) => vertices(array).ok_or_else(|| wrong_point(key, "numbers of vertices", value)),
        _ => Err(wrong_point(key, "three numbers", value)),
    }
}

/// The position that a mapping gives; `None` if it gives none.
fn of_object(object: &Object<'_>) -> Parsed<Option<PointPosition>> {
    if let (Some(triangle), Some(coordinates)) = (get(object, &TRIANGLES), get(object, &BARYCENTRICS)) {
        return on_triangle(triangle, coordinates).map(Some);
    }
    if let Some(value) = get(object, &VERTICES) {
        let position = match value {
            Value::Array(array) => vertices(array),
            _ => index(value).map(|vertex| PointPosition::OnMesh(MeshPoint::Vertex(vertex))),
        };
        let message = || format!("expected the number of a vertex, found {}", describe(value));
        return position.map(Some).ok_or_else(|| ParseError::new(message(), SEE_DOCUMENTATION));
    }
    if let Some(value) = get(object, &POSITIONS) {
        let at = match value {
            Value::Array(array) => numbers(&array.elements),
            Value::Object(object) => axes(object),
            _ => None,
        };
        let message = || format!("expected three numbers, found {}", describe(value));
        let at = at.ok_or_else(|| ParseError::new(message(), "write them as `[x, y, z]`"))?;
        return Ok(Some(PointPosition::InSpace(Point3::from(at))));
    }
    Ok(axes(object).map(|at| PointPosition::InSpace(Point3::from(at))))
}

fn on_triangle(triangle: &Value<'_>, coordinates: &Value<'_>) -> Parsed<PointPosition> {
    let Some(index) = index(triangle) else {
        let message = format!("expected the number of a triangle, found {}", describe(triangle));
        return Err(ParseError::new(message, SEE_DOCUMENTATION));
    };
    let elements = coordinates.as_array().map(|array| &array.elements[..]).unwrap_or_default();
    let two = numbers(elements).map(|[u, v]| [u, v, 1.0 - u - v]);
    let Some(three) = two.or_else(|| numbers(elements)) else {
        let message = format!("expected two or three barycentric coordinates, found {}", describe(coordinates));
        return Err(ParseError::new(message, SEE_DOCUMENTATION));
    };
    let three = barycentric(&three)
        .map_err(|message| ParseError::new(message, "corners of the triangle in order, with a sum of 1"))?;
    Ok(PointPosition::OnMesh(MeshPoint::Triangle(index, three)))
}

fn vertices(array: &Array<'_>) -> Option<PointPosition> {
    let vertices = array.elements.iter().map(index).collect::<Option<Vec<_>>>()?;
    match vertices[..] {
        [] => None,
        [vertex] => Some(PointPosition::OnMesh(MeshPoint::Vertex(vertex))),
        _ => Some(PointPosition::MeanOfVertices(vertices)),
    }
}

/// The values of the keys `x`, `y` and `z`.
fn axes(object: &Object<'_>) -> Option<[f64; 3]> {
    let [x, y, z] = ["x", "y", "z"].map(|axis| get(object, &[axis]).and_then(number));
    Some([x?, y?, z?])
}
