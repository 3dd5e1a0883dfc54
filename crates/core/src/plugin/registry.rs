use std::{any::Any, borrow::Cow};

use schemars::{Schema, SchemaGenerator};
use serde::de::DeserializeOwned;
use serde_json::Value;

use crate::{Error, Result};

/// One registered implementation of one stage.
pub struct Plugin {
    /// The stage, as a pipeline spells it, e.g. `transfer`.
    pub stage: &'static str,
    /// The `type:` in YAML.
    pub name: fn() -> &'static str,
    /// JSON Schema of the settings, without `type`; its descriptions are the doc comments.
    pub schema: fn(&mut SchemaGenerator) -> Schema,
    /// The settings of the default instance as JSON, without `type`.
    pub settings: fn() -> Value,
    #[doc(hidden)]
    pub instance: fn() -> Box<dyn Any>,
}

/// A stage trait object, e.g. `dyn Transfer`; implemented by [`stage_kind!`](crate::stage_kind).
pub trait StageKind: 'static {
    /// The stage's name, as a pipeline spells it.
    const NAME: &'static str;
}

impl Plugin {
    /// An instance with default settings, if this is an implementation of stage `S`.
    pub fn default_instance<S: StageKind + ?Sized>(&self) -> Option<Box<S>> {
        (self.instance)().downcast::<Box<S>>().ok().map(|boxed| *boxed)
    }
}

/// Every registered implementation, sorted by stage and name.
pub fn all() -> Vec<&'static Plugin> {
    let mut plugins: Vec<_> = inventory::iter::<Plugin>.into_iter().collect();
    plugins.sort_by_key(|plugin| (plugin.stage, (plugin.name)()));
    plugins
}

/// The registered implementations of stage `S` with default settings, by name.
pub fn instances<S: StageKind + ?Sized>() -> Vec<(&'static str, Box<S>)> {
    all().into_iter().filter_map(|plugin| Some(((plugin.name)(), plugin.default_instance::<S>()?))).collect()
}

/// The registered implementation of stage `S` of that name with default settings: what a stage takes for another one that it
/// needs, where the user names none. `None` if no such implementation is linked into the program.
///
/// A default must not ask for an implementation of its own stage: telling the names of a stage needs all its defaults.
pub fn instance<S: StageKind + ?Sized>(name: &str) -> Option<Box<S>> {
    let of_stage = inventory::iter::<Plugin>.into_iter().filter(|plugin| plugin.stage == S::NAME);
    of_stage.filter(|plugin| (plugin.name)() == name).find_map(Plugin::default_instance::<S>)
}

/// The implementation of stage `S` that `settings` describe, as a pipeline would; as with [`instance`], `None` if it is not
/// linked into the program.
pub fn configured<S: StageKind + ?Sized>(settings: Value) -> Option<Box<S>>
where
    Box<S>: DeserializeOwned,
{
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
                name: || $crate::stage::$stage::typetag_name(&<$implementation>::default()),
                schema: <$implementation as $crate::schemars::JsonSchema>::json_schema,
                settings: || {
                    $crate::serde_json::to_value(<$implementation>::default()).expect("settings serialise to JSON")
                },
                instance: || {
                    let boxed: Box<dyn $crate::stage::$stage> = Box::new(<$implementation>::default());
                    Box::new(boxed)
                },
            }
        }
    };
}

inventory::collect!(Plugin);

/// The description of a schema's subject, i.e. its doc comment.
pub fn description(schema: &Schema) -> Cow<'_, str> {
    schema.get("description").and_then(Value::as_str).unwrap_or_default().into()
}
