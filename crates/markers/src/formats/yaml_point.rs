//! A point of a `.yaml`: a vertex, or a place on a triangle.

use std::fmt;

use nalgebra::Point3;
use serde::{
    Deserialize, Deserializer,
    de::{self, Error, MapAccess, Unexpected, Visitor},
};

use mimesh_core::mesh::MeshPoint;

use crate::text::barycentric;

/// A point in YAML: a vertex as a number or as `{ vertex: 4 }`, or `{ triangle: 12, barycentric: [0.2, 0.3, 0.5] }`; the
/// mappings also with `at: [x, y, z]`.
pub struct YamlPoint {
    /// The vertex, or the place on a triangle.
    pub point: MeshPoint,
    /// The position of the point when it was made.
    pub at: Option<Point3<f64>>,
}

impl<'de> Deserialize<'de> for YamlPoint {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(PointVisitor)
    }
}

struct PointVisitor;

impl<'de> Visitor<'de> for PointVisitor {
    type Value = YamlPoint;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a vertex (a whole number from 0) or `{ triangle: …, barycentric: [a, b, c] }`")
    }

    fn visit_u64<E: Error>(self, vertex: u64) -> Result<YamlPoint, E> {
        match u32::try_from(vertex) {
            Ok(vertex) => Ok(YamlPoint { point: MeshPoint::Vertex(vertex), at: None }),
            Err(_) => Err(E::invalid_value(Unexpected::Unsigned(vertex), &self)),
        }
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<YamlPoint, A::Error> {
        let keys = PointKeys::deserialize(de::value::MapAccessDeserializer::new(map))?;
        let point = match (keys.vertex, keys.triangle, keys.barycentric) {
            (Some(vertex), None, None) => MeshPoint::Vertex(vertex),
            (None, Some(triangle), Some(values)) => {
                MeshPoint::Triangle(triangle, barycentric(&values).map_err(A::Error::custom)?)
            }
            (None, Some(_), None) => return Err(A::Error::missing_field("barycentric")),
            (None, None, Some(_)) => return Err(A::Error::missing_field("triangle")),
            (None, None, None) => return Err(A::Error::missing_field("vertex")),
            _ => return Err(A::Error::custom("expected either a vertex or a triangle, found both")),
        };
        Ok(YamlPoint { point, at: keys.at.as_deref().map(coordinates).transpose().map_err(A::Error::custom)? })
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PointKeys {
    vertex: Option<u32>,
    triangle: Option<u32>,
    barycentric: Option<Vec<f64>>,
    at: Option<Vec<f64>>,
}

fn coordinates(values: &[f64]) -> Result<Point3<f64>, String> {
    match <[f64; 3]>::try_from(values) {
        Ok(values) if values.iter().all(|value| value.is_finite()) => Ok(Point3::from(values)),
        Ok(_) => Err("expected finite coordinates".into()),
        Err(_) => Err(format!("expected three coordinates, found {}", values.len())),
    }
}
