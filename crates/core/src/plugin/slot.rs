//! JSON Schemas of slots: settings that hold a stage.

use std::{any::type_name, borrow::Cow, marker::PhantomData};

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde_json::{Value, json};

use super::registry::{StageKind, all};

/// The schema of a slot for stage `S`: `x-stage` names the kind of stage, beside what may stand in the slot.
///
/// The alternatives stand there as `oneOf` where `generator` inlines, and as `$ref` into `$defs` where it does not. An inlining
/// generator also writes a `$ref` for a kind of stage within itself, as a transfer within a transfer, since that would never end;
/// the definition is in the generator, and in its root schema if it makes one. So a reader of nested stages goes by `x-stage` and
/// `type` from one implementation's schema to the next, and needs no `$ref`.
pub fn slot<S: StageKind + JsonSchema + ?Sized>(generator: &mut SchemaGenerator) -> Schema {
    let mut schema = json_schema!({ "x-stage": S::NAME });
    let alternatives = generator.subschema_for::<Alternatives<S>>().to_value();
    for (key, value) in alternatives.as_object().into_iter().flatten() {
        schema.insert(key.clone(), value.clone());
    }
    schema
}

/// Makes a stage trait known: `stage_kind!(Transfer, "transfer");`, once, beside the trait.
#[macro_export]
macro_rules! stage_kind {
    ($stage:ident, $name:literal) => {
        impl $crate::plugin::StageKind for dyn $stage {
            const NAME: &'static str = $name;
        }

        impl $crate::schemars::JsonSchema for dyn $stage {
            fn inline_schema() -> bool {
                true
            }

            fn schema_name() -> std::borrow::Cow<'static, str> {
                stringify!($stage).into()
            }

            fn json_schema(generator: &mut $crate::schemars::SchemaGenerator) -> $crate::schemars::Schema {
                $crate::plugin::slot::<dyn $stage>(generator)
            }
        }
    };
}

/// The kind of stage that a setting with this schema holds, alone or optional; of a list it is that of `items`. `None` if it holds
/// no stage.
pub fn stage_of(schema: &Value) -> Option<&str> {
    let own = schema.get("x-stage").and_then(Value::as_str);
    own.or_else(|| schema.get("anyOf")?.as_array()?.iter().find_map(stage_of))
}

/// Any registered implementation of stage `S`. It has a definition of its own, so that `x-stage` can stand beside a `$ref` to it.
struct Alternatives<S: ?Sized>(PhantomData<S>);

impl<S: StageKind + JsonSchema + ?Sized> JsonSchema for Alternatives<S> {
    fn schema_name() -> Cow<'static, str> {
        S::schema_name()
    }

    fn schema_id() -> Cow<'static, str> {
        type_name::<S>().into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        one_of(S::NAME, generator)
    }
}

/// The schema of "any registered implementation of `stage`", told apart by `type`.
fn one_of(stage: &str, generator: &mut SchemaGenerator) -> Schema {
    let variants: Vec<_> = all()
        .into_iter()
        .filter(|plugin| plugin.stage == stage)
        .map(|plugin| {
            let mut schema = plugin.schema(generator);
            let object = schema.ensure_object();
            let properties = object.entry("properties").or_insert_with(|| json!({}));
            properties["type"] = json!({ "const": plugin.name() });
            object.insert("required".into(), required(object.get("required")));
            schema
        })
        .collect();
    json_schema!({ "oneOf": variants })
}

/// `type`, and whatever else has no default.
fn required(others: Option<&Value>) -> Value {
    let mut names = vec![json!("type")];
    names.extend(others.and_then(Value::as_array).into_iter().flatten().cloned());
    Value::Array(names)
}

#[cfg(test)]
mod tests {
    use schemars::{JsonSchema, generate::SchemaSettings};
    use serde::{Deserialize, Serialize};
    use serde_json::Value;

    use super::*;
    use crate::{
        Result,
        mesh::{Surface, SurfacePoint},
        stage::Sampler,
    };

    crate::register!(Sampler: Within);

    /// A sampler with others in it.
    #[derive(Debug, Default, Deserialize, JsonSchema, Serialize)]
    #[serde(default, deny_unknown_fields)]
    struct Within {
        /// One or none.
        optional: Option<Box<dyn Sampler>>,
        /// Any number.
        list: Vec<Box<dyn Sampler>>,
        /// Any number or nothing.
        optional_list: Option<Vec<Box<dyn Sampler>>>,
        /// No stage.
        count: usize,
    }

    #[typetag::serde(name = "test_within")]
    impl Sampler for Within {
        fn sample(&self, _: &Surface) -> Result<Vec<SurfacePoint>> {
            Ok(vec![])
        }
    }

    /// A pipeline, so to say.
    #[derive(JsonSchema)]
    #[allow(dead_code, reason = "only its schema is looked at")]
    struct Slots {
        required: Box<dyn Sampler>,
        optional: Option<Box<dyn Sampler>>,
        list: Vec<Box<dyn Sampler>>,
    }

    fn schema<T: JsonSchema>(inline: bool) -> Value {
        let settings = SchemaSettings::draft2020_12().with(|settings| settings.inline_subschemas = inline);
        settings.into_generator().into_root_schema_for::<T>().to_value()
    }

    fn holds_a_sampler(schema: &Value, key: &str) -> bool {
        let property = &schema["properties"][key];
        stage_of(property.get("items").unwrap_or(property)) == Some("sampler")
    }

    #[test]
    fn every_slot_names_its_kind_of_stage() {
        for inline in [false, true] {
            let schema = schema::<Slots>(inline);
            for key in ["required", "optional", "list"] {
                assert!(holds_a_sampler(&schema, key), "{key} in {schema:#}");
            }
        }
    }

    #[test]
    fn a_stage_within_itself_names_its_kind_too() {
        for inline in [false, true] {
            let schema = schema::<Slots>(inline);
            let alternatives = match inline {
                false => &schema["$defs"]["Sampler"],
                true => &schema["properties"]["required"],
            };
            let within = alternatives["oneOf"].as_array().into_iter().flatten();
            let within = within.into_iter().find(|one| one["properties"]["type"]["const"] == "test_within");
            let within = within.unwrap_or_else(|| panic!("no `test_within` in {schema:#}"));
            for key in ["optional", "list", "optional_list"] {
                assert!(holds_a_sampler(within, key), "{key} in {within:#}");
            }
            assert_eq!(stage_of(&within["properties"]["count"]), None);
            // Even where the generator inlines, the circle ends in a definition, which the root has.
            let inner = &within["properties"]["list"]["items"];
            assert_eq!(inner["$ref"], "#/$defs/Sampler");
            assert!(schema["$defs"]["Sampler"]["oneOf"].is_array());
        }
    }
}
