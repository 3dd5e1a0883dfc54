//! Stages under names that the program learns while it runs, as those that its user writes in another language.

use schemars::Schema;
use serde_json::Value;

use super::registry::{Alias, Implementation, Plugin, add, aliases, linked};
use crate::{Error, Result};

impl Alias {
    /// Makes the alias known as a stage of the kind `stage`; one of the same kind and name gives way to it.
    ///
    /// # Errors
    ///
    /// [`Error::Data`] if a linked implementation has that name, or none of the kind is called [`of`](Self::of).
    pub fn register(stage: &str, name: &str, of: &str, schema: Value, settings: Value) -> Result<()> {
        if linked(stage, name).is_some() {
            let message = format!("there is a {stage} `{name}` already, which is a part of the program");
            return Err(Error::data(message, "give the stage another name"));
        }
        let base = linked(stage, of).ok_or_else(|| {
            let message = format!("no {stage} `{of}` is linked into this program, which `{name}` would stand for");
            Error::data(message, "write the stage in Rust instead")
        })?;
        let schema = Schema::try_from(schema).map_err(|error| Error::Other(error.into()))?;
        // A program learns few names, and plug-ins live as long as it does.
        let name: &'static str = String::leak(name.to_owned());
        let alias = Self { name, of: base.name(), schema, settings };
        let plugin: &'static Plugin =
            Box::leak(Box::new(Plugin { stage: base.stage, implementation: Implementation::Alias(alias) }));
        add(plugin);
        Ok(())
    }
}

/// The alias `name` of a stage of the kind `stage`.
pub fn alias(stage: &str, name: &str) -> Option<&'static Alias> {
    let found = aliases().into_iter().find(|plugin| plugin.stage == stage && plugin.name() == name)?;
    match &found.implementation {
        Implementation::Alias(alias) => Some(alias),
        Implementation::Type(_) => None,
    }
}

#[cfg(test)]
mod tests {
    use schemars::JsonSchema;
    use serde::{Deserialize, Serialize};
    use serde_json::{Map, json};

    use super::*;
    use crate::{
        mesh::{Surface, SurfacePoint},
        plugin::{self, changes},
        stage::Sampler,
    };

    crate::register!(Sampler: Foreign);

    /// A sampler that is written elsewhere.
    #[derive(Debug, Default, Deserialize, JsonSchema, Serialize)]
    #[serde(default, deny_unknown_fields)]
    struct Foreign {
        /// Its name there.
        class: String,
        /// Its settings there.
        settings: Map<String, Value>,
    }

    #[typetag::serde(name = "test_foreign")]
    impl Sampler for Foreign {
        fn sample(&self, _: &Surface) -> Result<Vec<SurfacePoint>> {
            Ok(vec![])
        }
    }

    fn learn(name: &str, of: &str, default: u64) -> Result<()> {
        let schema =
            json!({ "description": "One.", "properties": { "k": { "type": "integer", "description": "K." } } });
        Alias::register("sampler", name, of, schema, json!({ "k": default }))
    }

    #[test]
    fn an_alias_is_a_stage_like_others_and_the_last_of_a_name_counts() {
        learn("test_learned", "test_foreign", 1).unwrap();
        let before = changes();
        learn("test_learned", "test_foreign", 2).unwrap();
        assert!(changes() > before);
        let all = plugin::all();
        let found: Vec<_> = all.iter().filter(|plugin| plugin.name() == "test_learned").collect();
        let [found] = found[..] else { panic!("{} of the name", found.len()) };
        assert_eq!((found.stage, found.settings()), ("sampler", json!({ "k": 2 })));
        assert!(found.default_instance::<dyn Sampler>().is_none());
        let schema = found.schema(&mut schemars::SchemaGenerator::default());
        assert_eq!(plugin::description(&schema), "One.");
    }

    #[test]
    fn its_settings_are_read_as_those_of_what_it_stands_for() {
        learn("test_read", "test_foreign", 1).unwrap();
        let written = json!({ "type": "test_read", "k": 7 });
        let expanded = alias("sampler", "test_read").unwrap().expand(written.as_object().unwrap());
        let read: Box<dyn Sampler> = serde_json::from_value(expanded.clone()).unwrap();
        assert_eq!(serde_json::to_value(&read).unwrap(), expanded);
        assert_eq!(expanded, json!({ "type": "test_foreign", "class": "test_read", "settings": { "k": 7 } }));
        assert!(alias("weights", "test_read").is_none());
    }

    #[test]
    fn names_of_linked_stages_are_taken_and_unknown_ones_are_nothing_to_stand_for() {
        let taken = learn("test_foreign", "test_foreign", 1).unwrap_err().to_string();
        assert_eq!(taken, "there is a sampler `test_foreign` already, which is a part of the program");
        assert!(learn("test_other", "test_nothing", 1).unwrap_err().to_string().contains("`test_nothing`"));
    }
}
