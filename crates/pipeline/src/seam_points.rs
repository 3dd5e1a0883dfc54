//! Seams that open, as a pipeline names them.

use std::{borrow::Cow, fmt};

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{
    Deserialize, Deserializer, Serialize,
    de::{self, SeqAccess, Visitor},
};

/// A place where a seam opens.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(untagged)]
pub enum SeamPoint {
    /// A vertex of the file, which parts from all that lie at its place.
    Vertex(u32),
    /// Two vertices of the file, which part from each other.
    Pair([u32; 2]),
}

impl SeamPoint {
    /// Whether it means the seam between the vertices of `pair`.
    pub fn opens(self, pair: [u32; 2]) -> bool {
        match self {
            Self::Vertex(vertex) => pair.contains(&vertex),
            Self::Pair([a, b]) => pair == [a.min(b), a.max(b)],
        }
    }
}

impl fmt::Display for SeamPoint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Vertex(vertex) => write!(f, "vertex {vertex}"),
            Self::Pair([a, b]) => write!(f, "vertices {a} and {b}"),
        }
    }
}

impl<'de> Deserialize<'de> for SeamPoint {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct VertexOrPair;

        impl<'de> Visitor<'de> for VertexOrPair {
            type Value = SeamPoint;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a vertex, or a sequence of two vertices, counted from 0")
            }

            fn visit_u64<E: de::Error>(self, vertex: u64) -> Result<SeamPoint, E> {
                let too_large = |_| E::invalid_value(de::Unexpected::Unsigned(vertex), &self);
                u32::try_from(vertex).map(SeamPoint::Vertex).map_err(too_large)
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<SeamPoint, A::Error> {
                match (list.next_element()?, list.next_element()?, list.next_element::<u32>()?) {
                    (Some(a), Some(b), None) => Ok(SeamPoint::Pair([a, b])),
                    _ => Err(de::Error::custom("expected two vertices")),
                }
            }
        }

        deserializer.deserialize_any(VertexOrPair)
    }
}

impl JsonSchema for SeamPoint {
    fn schema_name() -> Cow<'static, str> {
        "SeamPoint".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let vertex = || json_schema!({ "type": "integer", "minimum": 0 });
        json_schema!({ "oneOf": [
            vertex(),
            { "type": "array", "items": vertex(), "minItems": 2, "maxItems": 2 }
        ] })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_vertex_opens_all_seams_at_it_and_a_pair_one() {
        let read = |text: &str| serde_json::from_str::<Vec<SeamPoint>>(text);
        let points = read("[4, [7, 2]]").unwrap();
        assert_eq!(points, [SeamPoint::Vertex(4), SeamPoint::Pair([7, 2])]);
        assert_eq!(serde_json::to_string(&points).unwrap(), "[4,[7,2]]");
        assert!(points[0].opens([4, 9]) && points[0].opens([1, 4]) && !points[0].opens([2, 7]));
        assert!(points[1].opens([2, 7]) && !points[1].opens([2, 8]));
        for wrong in ["[-1]", "[[1]]", "[[1, 2, 3]]", "[\"a\"]", "[5000000000]"] {
            assert!(read(wrong).is_err(), "{wrong}");
        }
    }
}
