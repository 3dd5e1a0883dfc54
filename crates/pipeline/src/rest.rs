//! The mesh at rest: the file, the part of it, and the shape of it that counts as rest.

use std::{fmt, path::PathBuf};

use mimesh_core::stage::{PoseChoice, RestShape, Selection};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{
    Deserialize, Deserializer, Serialize, Serializer,
    de::{self, MapAccess, Visitor},
};

use crate::one_or_many::OneOrMany;

/// A mesh at rest: a file, or a part of one, in the shape that the file stores or in another that it holds.
///
/// It is written as a path, or as a mapping with the key `file`.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Rest {
    /// The file of the mesh.
    pub file: PathBuf,
    /// The parts of the file that take part, by the names of nodes, meshes or materials, e.g. `[Body, Face]`; all if left out.
    ///
    /// Results keep the other parts as they are.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub meshes: Option<OneOrMany>,
    /// The pose that serves as the rest, by its name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pose: Option<String>,
    /// The clip of the file in which the mesh rests at `time`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clip: Option<String>,
    /// The time in `clip`, in seconds; left out, 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time: Option<f64>,
}

impl Rest {
    /// All of a file, in the shape that it stores.
    pub fn of_file(file: impl Into<PathBuf>) -> Self {
        Self { file: file.into(), ..Self::default() }
    }

    /// The names of the parts; none stands for all.
    pub fn meshes(&self) -> Vec<String> {
        self.meshes.as_ref().map(|meshes| meshes.items.clone()).unwrap_or_default()
    }

    /// The parts and the shape of a target's file.
    pub fn selection(&self) -> Selection {
        let pose = self.pose.clone().map(RestShape::Pose);
        let rest = self.clip_shape().or(pose).unwrap_or_default();
        Selection { meshes: self.meshes(), rest, poses: PoseChoice::Nothing, ..Selection::default() }
    }

    /// The time in a clip that the file is asked for, if one is named.
    pub fn clip_shape(&self) -> Option<RestShape> {
        let name = self.clip.clone()?;
        Some(RestShape::Clip { name, seconds: self.time.unwrap_or_default() })
    }
}

/// Reads a path or the mapping; a derived reader of the mapping reports a wrong key at its place.
pub(crate) fn path_or_mapping<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Rest>, D::Error> {
    struct PathOrMapping;

    impl<'de> Visitor<'de> for PathOrMapping {
        type Value = Option<Rest>;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("a path, or a mapping `{ file: …, meshes: […] }`")
        }

        fn visit_unit<E>(self) -> Result<Option<Rest>, E> {
            Ok(None)
        }

        fn visit_none<E>(self) -> Result<Option<Rest>, E> {
            Ok(None)
        }

        fn visit_str<E>(self, text: &str) -> Result<Option<Rest>, E> {
            Ok(Some(Rest::of_file(text)))
        }

        fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Option<Rest>, A::Error> {
            Rest::deserialize(de::value::MapAccessDeserializer::new(map)).map(Some)
        }
    }

    deserializer.deserialize_any(PathOrMapping)
}

/// Writes a path where that says it all, else the mapping.
pub(crate) fn as_short_as_possible<S: Serializer>(rest: &Option<Rest>, serializer: S) -> Result<S::Ok, S::Error> {
    match rest {
        Some(rest) if *rest == Rest::of_file(&rest.file) => rest.file.serialize(serializer),
        rest => rest.serialize(serializer),
    }
}

/// The schema of a path or the mapping.
pub(crate) fn schema(generator: &mut SchemaGenerator) -> Schema {
    json_schema!({ "oneOf": [{ "type": "string" }, Rest::json_schema(generator)] })
}
