//! Where the poses of the source are: files, or clips of a file.

use std::{borrow::Cow, fmt, path::PathBuf};

use mimesh_core::stage::{ClipChoice, ClipTimes};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{
    Deserialize, Deserializer, Serialize,
    de::{self, DeserializeSeed, IntoDeserializer, MapAccess, SeqAccess, Visitor},
};

use crate::one_or_many::OneOrMany;

/// The poses of the source: files, or frames of clips.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Poses {
    /// Paths and globs.
    Files(OneOrMany),
    /// Paths and globs, with how they are read.
    Mapped(FilePoses),
    /// Frames of clips.
    Clips(ClipPoses),
}

/// Files of poses, and how they are read.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FilePoses {
    /// A path or glob, or a sequence of them.
    pub files: OneOrMany,
    /// Take the vertices of each file in their order, whatever its polygons are. For files with the vertices of the rest mesh and
    /// other polygons, or none.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub same_vertices: bool,
}

/// Frames of the clips of a file, which stand for poses.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ClipPoses {
    /// The file; left out, that of the rest.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file: Option<PathBuf>,
    /// The name of the clip, a sequence of names, or `"*"` for all; `mimesh inspect` lists them.
    pub clip: OneOrMany,
    /// Frames a second; left out, 24.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.001, max = 10_000.0))]
    pub fps: Option<f64>,
    /// Take the times of the clip's keys in place of even steps.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub at_keys: bool,
    /// The first and the last time in seconds; left out, the whole clip.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("examples" = [[0.5, 1.5]]))]
    pub range: Option<[f64; 2]>,
}

impl Poses {
    /// The paths and globs, if the poses are files.
    pub fn files(&self) -> Option<&OneOrMany> {
        match self {
            Self::Files(files) => Some(files),
            Self::Mapped(poses) => Some(&poses.files),
            Self::Clips(_) => None,
        }
    }

    /// Whether files need the vertices of the rest mesh only.
    pub fn same_vertices(&self) -> bool {
        matches!(self, Self::Mapped(poses) if poses.same_vertices)
    }
}

impl ClipPoses {
    /// The clips and times, as formats are asked for them.
    pub fn choice(&self) -> ClipChoice {
        let all = self.clip.items.iter().any(|name| name == "*");
        ClipChoice {
            clips: if all { vec![] } else { self.clip.items.clone() },
            times: if self.at_keys {
                ClipTimes::Keys
            } else {
                self.fps.map_or_else(Default::default, ClipTimes::PerSecond)
            },
            range: self.range,
        }
    }
}

impl<'de> Deserialize<'de> for Poses {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct FilesOrClips;

        impl<'de> Visitor<'de> for FilesOrClips {
            type Value = Poses;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a path or glob, a sequence of them, or a mapping such as `{ clip: Run }`")
            }

            fn visit_str<E: de::Error>(self, text: &str) -> Result<Poses, E> {
                Ok(Poses::Files(OneOrMany { items: vec![text.into()], listed: false }))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<Poses, A::Error> {
                OneOrMany::deserialize(de::value::SeqAccessDeserializer::new(list)).map(Poses::Files)
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Poses, A::Error> {
                let first: Option<String> = map.next_key()?;
                let are_files = matches!(first.as_deref(), Some("files" | "same_vertices"));
                let map = de::value::MapAccessDeserializer::new(FromFirst { first, map });
                if are_files {
                    return FilePoses::deserialize(map).map(Poses::Mapped);
                }
                ClipPoses::deserialize(map).map(Poses::Clips)
            }
        }

        deserializer.deserialize_any(FilesOrClips)
    }
}

/// A mapping whose first key has been read.
struct FromFirst<A> {
    first: Option<String>,
    map: A,
}

impl<'de, A: MapAccess<'de>> MapAccess<'de> for FromFirst<A> {
    type Error = A::Error;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, A::Error> {
        match self.first.take() {
            Some(first) => seed.deserialize(first.into_deserializer()).map(Some),
            None => self.map.next_key_seed(seed),
        }
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, A::Error> {
        self.map.next_value_seed(seed)
    }
}

impl JsonSchema for Poses {
    fn schema_name() -> Cow<'static, str> {
        "Poses".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        json_schema!({ "oneOf": [
            { "type": "string" },
            { "type": "array", "items": { "type": "string" } },
            FilePoses::json_schema(generator),
            ClipPoses::json_schema(generator)
        ] })
    }
}
