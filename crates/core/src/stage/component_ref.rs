use std::{borrow::Cow, fmt};

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

use crate::{
    Error, Result,
    mesh::{Components, Surface},
};

/// Components of the target in settings: a number, the name of an object, group or material, or `all`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ComponentRef {
    /// The number, from 0, in the order of first vertices.
    Number(u32),
    /// A name: all components of the parts that have it. Where no part is called `all`, it stands for all components.
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
                "the target has no component {what}: expected 0 to {}, a name, or `all`; {names}",
                count.saturating_sub(1)
            ),
            "inspect the mesh: its components are listed with their numbers and names",
        ))
    }
}

fn named(name: &str, target: &Surface, components: &Components) -> Vec<u32> {
    let part = target.part_names.iter().position(|n| n == name);
    let called = target.part_of.iter().enumerate().filter(|(_, p)| Some(**p as usize) == part).map(|(t, _)| t);
    let others = target.other_names.iter().filter(|(other, _)| other == name).flat_map(|(_, runs)| runs);
    let others = others.flat_map(|run| run.clone().map(|t| t as usize));
    let component = |t: usize| components.of_vertex[target.triangles[t][0] as usize];
    let mut found: Vec<u32> = called.chain(others).filter_map(component).collect();
    if found.is_empty() && name == "all" {
        return (0..components.count() as u32).collect();
    }
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
                f.write_str("the number of a component, the name of an object, group or material, or `all`")
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
            "description": "Components: a number, the name of an object, group or material, or `all`.",
            "type": ["integer", "string"],
            "minimum": 0,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Mesh, Part};
    use nalgebra::Point3;

    /// Four triangles apart: object `leg` in group `left`, object `leg` in group `right`, group `left` alone, nothing.
    fn surface() -> Surface {
        let corner = |k: u32| Point3::new(f64::from(k / 3), f64::from(k % 3), f64::from(k % 2));
        let mut mesh =
            Mesh::from_triangles((0..12).map(corner).collect(), &[[0, 1, 2], [3, 4, 5], [6, 7, 8], [9, 10, 11]]);
        let part = |k: usize, object: Option<&str>, group: Option<&str>| Part {
            object: object.map(Into::into),
            groups: group.into_iter().map(Into::into).collect(),
            polygons: k..k + 1,
            ..Part::default()
        };
        mesh.parts = vec![
            part(0, Some("leg"), Some("left")),
            part(1, Some("leg"), Some("right")),
            part(2, None, Some("left")),
            part(3, None, None),
        ];
        Surface::new(&mesh).unwrap()
    }

    #[test]
    fn components_are_found_by_number_object_and_group_and_all_together() {
        let surface = surface();
        let find = |name: &str| {
            ComponentRef::Name(name.into()).resolve(&surface, &surface.components()).map_err(|error| error.to_string())
        };
        assert_eq!(find("leg"), Ok(vec![0, 1]));
        assert_eq!(find("left"), Ok(vec![0, 2]));
        assert_eq!(find("right"), Ok(vec![1]));
        assert_eq!(find("all"), Ok(vec![0, 1, 2, 3]));
        assert!(find("lge").unwrap_err().starts_with("the target has no component `lge`: expected 0 to 3"));
        assert_eq!(ComponentRef::Number(2).resolve(&surface, &surface.components()).unwrap(), [2]);
    }
}
