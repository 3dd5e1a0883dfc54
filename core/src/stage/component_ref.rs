use std::{borrow::Cow, fmt};

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

use crate::{
    Error, Result,
    mesh::{Components, Surface},
};

/// A component of the target in settings: its number, or the name of an object, group or material.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ComponentRef {
    /// The number, from 0, in the order of first vertices.
    Number(u32),
    /// A name: all components of the part.
    Name(String),
}

impl ComponentRef {
    /// The components meant.
    ///
    /// # Errors
    ///
    /// [`Error::Data`] if there is none, with the names that there are.
    pub fn resolve(&self, target: &Surface, components: &Components) -> Result<Vec<u32>> {
        let count = components.count();
        let (found, what) = match self {
            Self::Number(number) => ((0..count as u32).filter(|c| c == number).collect(), format!("number {number}")),
            Self::Name(name) => (named(name, target, components), format!("`{name}`")),
        };
        if !found.is_empty() {
            return Ok(found);
        }
        let names = if target.part_names.is_empty() {
            "the mesh names no objects, groups or materials".into()
        } else {
            format!("the mesh has parts {}", target.part_names.join(", "))
        };
        Err(Error::data(
            format!(
                "the target has no component {what}: expected 0 to {}, or a name; {names}",
                count.saturating_sub(1)
            ),
            "`mimesh inspect MESH --components` lists them",
        ))
    }
}

fn named(name: &str, target: &Surface, components: &Components) -> Vec<u32> {
    let Some(part) = target.part_names.iter().position(|n| n == name) else { return vec![] };
    let triangles = target.triangles.iter().zip(&target.part_of).filter(|(_, p)| **p as usize == part);
    let mut found: Vec<u32> = triangles.filter_map(|(t, _)| components.of_vertex[t[0] as usize]).collect();
    found.sort_unstable();
    found.dedup();
    found
}

impl fmt::Display for ComponentRef {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(number) => number.fmt(f),
            Self::Name(name) => name.fmt(f),
        }
    }
}

impl Serialize for ComponentRef {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Number(number) => serializer.serialize_u32(*number),
            Self::Name(name) => serializer.serialize_str(name),
        }
    }
}

impl<'de> Deserialize<'de> for ComponentRef {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor;
        impl de::Visitor<'_> for Visitor {
            type Value = ComponentRef;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("the number of a component or the name of an object, group or material")
            }

            fn visit_u64<E: de::Error>(self, number: u64) -> Result<ComponentRef, E> {
                let number =
                    u32::try_from(number).map_err(|_| E::invalid_value(de::Unexpected::Unsigned(number), &self))?;
                Ok(ComponentRef::Number(number))
            }

            fn visit_i64<E: de::Error>(self, number: i64) -> Result<ComponentRef, E> {
                let number =
                    u32::try_from(number).map_err(|_| E::invalid_value(de::Unexpected::Signed(number), &self))?;
                Ok(ComponentRef::Number(number))
            }

            fn visit_str<E: de::Error>(self, name: &str) -> Result<ComponentRef, E> {
                Ok(ComponentRef::Name(name.into()))
            }
        }
        deserializer.deserialize_any(Visitor)
    }
}

impl JsonSchema for ComponentRef {
    fn schema_name() -> Cow<'static, str> {
        "ComponentRef".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "A component: its number, or the name of an object, group or material.",
            "type": ["integer", "string"],
            "minimum": 0,
        })
    }
}
