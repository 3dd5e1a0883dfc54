use std::{
    any::Any,
    borrow::Cow,
    sync::{
        PoisonError, RwLock,
        atomic::{AtomicU64, Ordering},
    },
};

use schemars::{Schema, SchemaGenerator};
use serde::de::DeserializeOwned;
use serde_json::{Map, Value, json};

use crate::{Error, Result};

/// One registered implementation of one stage.
pub struct Plugin {
    /// The stage, as a pipeline spells it, e.g. `transfer`.
    pub stage: &'static str,
    #[doc(hidden)]
    pub implementation: Implementation,
}

/// What stands behind a [`Plugin`].
#[doc(hidden)]
pub enum Implementation {
    /// A type that is linked into the program.
    Type(ImplementingType),
    /// A name that stands for settings of one.
    Alias(Alias),
}

/// A name of its own for settings of an implementation that is linked into the program.
///
/// `{ type: NAME, … }` stands for `{ type: OF, class: NAME, settings: { … } }`, which the implementation `OF` understands.
#[derive(Clone, Debug)]
pub struct Alias {
    /// The name.
    pub name: &'static str,
    /// The `type` of the implementation that it stands for.
    pub of: &'static str,
    /// The JSON Schema of its own settings, with descriptions.
    pub schema: Schema,
    /// The defaults of its own settings.
    pub settings: Value,
}

impl Alias {
    /// The settings as the implementation that it stands for takes them.
    pub fn expand(&self, settings: &Map<String, Value>) -> Value {
        let own: Map<_, _> = settings
            .iter()
            .filter(|(key, _)| *key != "type")
            .map(|(key, value)| (key.clone(), value.clone()))
            .collect();
        json!({ "type": self.of, "class": self.name, "settings": own })
    }
}

/// What [`register!`](crate::register) says of a type.
#[doc(hidden)]
pub struct ImplementingType {
    pub name: fn() -> &'static str,
    pub schema: fn(&mut SchemaGenerator) -> Schema,
    pub settings: fn() -> Value,
    pub instance: fn() -> Box<dyn Any>,
}

/// A stage trait object, e.g. `dyn Transfer`; implemented by [`stage_kind!`](crate::stage_kind).
pub trait StageKind: 'static {
    /// The stage's name, as a pipeline spells it.
    const NAME: &'static str;
}

impl Plugin {
    /// The `type:` in YAML.
    pub fn name(&self) -> &'static str {
        match &self.implementation {
            Implementation::Type(of) => (of.name)(),
            Implementation::Alias(alias) => alias.name,
        }
    }

    /// JSON Schema of the settings, without `type`; its descriptions are the doc comments.
    pub fn schema(&self, generator: &mut SchemaGenerator) -> Schema {
        match &self.implementation {
            Implementation::Type(of) => (of.schema)(generator),
            Implementation::Alias(alias) => alias.schema.clone(),
        }
    }

    /// The settings of the default instance as JSON, without `type`.
    pub fn settings(&self) -> Value {
        match &self.implementation {
            Implementation::Type(of) => (of.settings)(),
            Implementation::Alias(alias) => alias.settings.clone(),
        }
    }

    /// An instance with default settings, if this is an implementation of stage `S`; an alias has none.
    pub fn default_instance<S: StageKind + ?Sized>(&self) -> Option<Box<S>> {
        let Implementation::Type(of) = &self.implementation else { return None };
        (of.instance)().downcast::<Box<S>>().ok().map(|boxed| *boxed)
    }
}

/// The plugins that are aliases.
static ALIASES: RwLock<Vec<&'static Plugin>> = RwLock::new(Vec::new());

/// How often aliases have changed.
static CHANGES: AtomicU64 = AtomicU64::new(0);

/// Adds an alias; one of the same kind and name gives way to it.
pub(super) fn add(plugin: &'static Plugin) {
    let mut aliases = ALIASES.write().unwrap_or_else(PoisonError::into_inner);
    aliases.retain(|other| (other.stage, other.name()) != (plugin.stage, plugin.name()));
    aliases.push(plugin);
    CHANGES.fetch_add(1, Ordering::Release);
}

/// All aliases.
pub(super) fn aliases() -> Vec<&'static Plugin> {
    ALIASES.read().unwrap_or_else(PoisonError::into_inner).clone()
}

/// How often aliases have changed so far: what was made of the registry before the last time is out of date.
pub fn changes() -> u64 {
    CHANGES.load(Ordering::Acquire)
}

/// Every registered implementation, sorted by stage and name.
pub fn all() -> Vec<&'static Plugin> {
    let mut plugins: Vec<_> = inventory::iter::<Plugin>.into_iter().chain(aliases()).collect();
    plugins.sort_by_key(|plugin| (plugin.stage, plugin.name()));
    plugins
}

/// The implementation `name` of the kind `stage` that is linked into the program.
pub(super) fn linked(stage: &str, name: &str) -> Option<&'static Plugin> {
    inventory::iter::<Plugin>.into_iter().find(|plugin| plugin.stage == stage && plugin.name() == name)
}

/// The registered implementations of stage `S` with default settings, by name.
pub fn instances<S: StageKind + ?Sized>() -> Vec<(&'static str, Box<S>)> {
    all().into_iter().filter_map(|plugin| Some((plugin.name(), plugin.default_instance::<S>()?))).collect()
}

/// The registered implementation of stage `S` of that name with default settings: what a stage takes for another one that it
/// needs, where the user names none. `None` if no such implementation is linked into the program.
///
/// A default must not ask for an implementation of its own stage: telling the names of a stage needs all its defaults.
pub fn instance<S: StageKind + ?Sized>(name: &str) -> Option<Box<S>> {
    let of_stage = inventory::iter::<Plugin>.into_iter().filter(|plugin| plugin.stage == S::NAME);
    of_stage.filter(|plugin| plugin.name() == name).find_map(Plugin::default_instance::<S>)
}

/// The implementation of stage `S` that `settings` describe, as a pipeline would; as with [`instance`], `None` if it is not
/// linked into the program. Only that stage may be an alias, not those nested in it.
pub fn configured<S: StageKind + ?Sized>(settings: Value) -> Option<Box<S>>
where
    Box<S>: DeserializeOwned,
{
    let name = settings.get("type").and_then(Value::as_str);
    let alias = aliases().into_iter().find_map(|plugin| match &plugin.implementation {
        Implementation::Alias(alias) if plugin.stage == S::NAME && Some(alias.name) == name => Some(alias),
        _ => None,
    });
    let settings = match (alias, settings.as_object()) {
        (Some(alias), Some(own)) => alias.expand(own),
        _ => settings,
    };
    serde_json::from_value(settings).ok()
}

/// The stage in the slot `slot` of another stage.
///
/// # Errors
///
/// [`Error::Data`] if there is none, which is so where its default, the implementation `default`, is not linked.
pub fn nested<'a, S: StageKind + ?Sized>(slot: &str, stage: &'a Option<Box<S>>, default: &str) -> Result<&'a S> {
    stage.as_deref().ok_or_else(|| {
        Error::data(
            format!("`{slot}` is left out, and its default `{default}` is not linked into this program"),
            format!("say which, e.g. `{slot}: {{ type: … }}`, or link the crate with `{default}`"),
        )
    })
}

/// Registers an implementation: `register!(Transfer: Gradient);`, once, at the top of the file that implements it.
///
/// The type needs `Default`, `Serialize`, `JsonSchema` and the trait with `#[typetag::serde(name = "…")]`.
#[macro_export]
macro_rules! register {
    ($stage:ident : $implementation:ty) => {
        $crate::inventory::submit! {
            $crate::Plugin {
                stage: <dyn $crate::stage::$stage as $crate::plugin::StageKind>::NAME,
                implementation: $crate::plugin::Implementation::Type($crate::plugin::ImplementingType {
                    name: || $crate::stage::$stage::typetag_name(&<$implementation>::default()),
                    schema: <$implementation as $crate::schemars::JsonSchema>::json_schema,
                    settings: || {
                        $crate::serde_json::to_value(<$implementation>::default()).expect("settings serialise to JSON")
                    },
                    instance: || {
                        let boxed: Box<dyn $crate::stage::$stage> = Box::new(<$implementation>::default());
                        Box::new(boxed)
                    },
                }),
            }
        }
    };
}

inventory::collect!(Plugin);

/// The description of a schema's subject, i.e. its doc comment.
pub fn description(schema: &Schema) -> Cow<'_, str> {
    schema.get("description").and_then(Value::as_str).unwrap_or_default().into()
}
