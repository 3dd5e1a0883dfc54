//! The marker files that a pipeline names.

use std::{borrow::Cow, fmt, path::PathBuf};

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{
    Deserialize, Deserializer, Serialize,
    de::{self, MapAccess, Visitor},
};

/// The file of markers that a pipeline names, or its file of points for each mesh.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(untagged)]
pub enum MarkerFiles {
    /// One file that holds both sides: `.cons` or `.yaml`.
    One(PathBuf),
    /// A file for each mesh; the points are paired by name, else by order.
    Pair {
        /// The points of the source.
        source: PathBuf,
        /// The points of the target.
        target: PathBuf,
    },
}

impl MarkerFiles {
    /// The file that holds both sides, if it is one.
    pub fn one(&self) -> Option<&PathBuf> {
        match self {
            Self::One(file) => Some(file),
            Self::Pair { .. } => None,
        }
    }

    /// The files with the key under which a pipeline names each; a file that holds both sides has no key.
    pub fn named(&self) -> Vec<(Option<&'static str>, &PathBuf)> {
        match self {
            Self::One(file) => vec![(None, file)],
            Self::Pair { source, target } => vec![(Some("source"), source), (Some("target"), target)],
        }
    }

    /// The same files, with `change` applied to the key and the path of each; see [`named`](Self::named).
    pub fn map(&self, change: impl Fn(Option<&'static str>, &PathBuf) -> PathBuf) -> Self {
        match self {
            Self::One(file) => Self::One(change(None, file)),
            Self::Pair { source, target } => {
                Self::Pair { source: change(Some("source"), source), target: change(Some("target"), target) }
            }
        }
    }
}

const EXPECTED: &str = "a path, or a mapping `{ source: …, target: … }` of a path for each mesh";

/// The mapping; a derived reader reports a wrong key at its place.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Sides {
    source: Option<PathBuf>,
    target: Option<PathBuf>,
}

impl<'de> Deserialize<'de> for MarkerFiles {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Files;

        impl<'de> Visitor<'de> for Files {
            type Value = MarkerFiles;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(EXPECTED)
            }

            fn visit_str<E>(self, text: &str) -> Result<MarkerFiles, E> {
                Ok(MarkerFiles::One(text.into()))
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<MarkerFiles, A::Error> {
                let sides = Sides::deserialize(de::value::MapAccessDeserializer::new(map))?;
                match (sides.source, sides.target) {
                    (Some(source), Some(target)) => Ok(MarkerFiles::Pair { source, target }),
                    (None, None) => Err(de::Error::custom(format!("expected {EXPECTED}, found neither"))),
                    (None, _) => Err(de::Error::missing_field("source")),
                    (_, None) => Err(de::Error::missing_field("target")),
                }
            }
        }

        deserializer.deserialize_any(Files)
    }
}

impl JsonSchema for MarkerFiles {
    fn schema_name() -> Cow<'static, str> {
        "MarkerFiles".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "oneOf": [
            { "type": "string" },
            {
                "type": "object",
                "properties": {
                    "source": { "type": "string", "description": "The points of the source." },
                    "target": { "type": "string", "description": "The points of the target." }
                },
                "required": ["source", "target"],
                "additionalProperties": false
            }
        ] })
    }
}
