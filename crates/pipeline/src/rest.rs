//! The shape of a source that counts as its rest.

use std::{borrow::Cow, fmt, path::PathBuf};

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{
    Deserialize, Deserializer, Serialize, Serializer,
    de::{self, MapAccess, Visitor},
};

/// The shape of a source that counts as its rest: that of a file, or a pose instead of it.
///
/// It is written as a path, or as a mapping with the key `file`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Rest {
    /// The file of the mesh.
    pub file: PathBuf,
    /// The name of the pose of the source that serves as its rest; `None` for the rest of the file.
    pub pose: Option<String>,
}

const EXPECTED: &str = "a path, or a mapping `{ file: …, pose: … }`";

/// The mapping; a derived reader reports a wrong key at its place.
#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    file: PathBuf,
    #[serde(default)]
    pose: Option<String>,
}

impl<'de> Deserialize<'de> for Rest {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct PathOrSettings;

        impl<'de> Visitor<'de> for PathOrSettings {
            type Value = Rest;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(EXPECTED)
            }

            fn visit_str<E>(self, text: &str) -> Result<Rest, E> {
                Ok(Rest { file: text.into(), pose: None })
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Rest, A::Error> {
                let Settings { file, pose } = Settings::deserialize(de::value::MapAccessDeserializer::new(map))?;
                Ok(Rest { file, pose })
            }
        }

        deserializer.deserialize_any(PathOrSettings)
    }
}

impl Serialize for Rest {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match &self.pose {
            None => self.file.serialize(serializer),
            Some(pose) => Settings { file: self.file.clone(), pose: Some(pose.clone()) }.serialize(serializer),
        }
    }
}

impl JsonSchema for Rest {
    fn schema_name() -> Cow<'static, str> {
        "Rest".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "oneOf": [
            { "type": "string" },
            {
                "type": "object",
                "properties": {
                    "file": { "type": "string", "description": "The file of the mesh." },
                    "pose": {
                        "type": "string",
                        "description": "The pose of the source that serves as its rest, by its name."
                    }
                },
                "required": ["file"],
                "additionalProperties": false
            }
        ] })
    }
}
