//! The schema of a value, found by its path.

use std::{
    any::TypeId,
    collections::HashMap,
    sync::{LazyLock, Mutex, PoisonError},
};

use mimesh_core::plugin::{self, StageKind};
use mimesh_document::Step;
use schemars::JsonSchema;
use serde_json::Value;

use crate::spec::Pipeline;

/// The schema of a value of a pipeline.
#[derive(Clone, Copy, Debug)]
pub struct SchemaNode<'s> {
    /// The whole schema, which references point into.
    root: &'s Value,
    /// The schema as its slot gives it: with the slot's description, default and extensions.
    slot: &'s Value,
    /// The schema that the slot refers to, the same where it refers to none.
    schema: &'s Value,
    /// The kind of stage whose settings belong there.
    stage: Option<&'s str>,
}

impl SchemaNode<'static> {
    /// The schema of a pipeline with all linked stages.
    pub fn pipeline() -> Self {
        Self::of_root(schema_of::<Pipeline>())
    }

    /// The schema of the settings of any linked stage of the kind `S`.
    pub fn of_kind<S: StageKind + JsonSchema + ?Sized>() -> Self {
        let root = schema_of::<Box<S>>();
        Self::of_root(root).resolved(root)
    }
}

impl<'s> SchemaNode<'s> {
    /// The node of a schema that stands alone.
    pub fn of_root(root: &'s Value) -> Self {
        Self { root, slot: root, schema: root, stage: None }
    }

    /// The schema of the value at `path` of a document with the value `value`.
    ///
    /// Settings that the document leaves out are taken for those of their default type. `None` where nothing is known.
    pub fn at(self, value: &Value, path: &[Step]) -> Option<Self> {
        let mut node = self;
        let mut value = Some(value);
        for step in path {
            node = node.entry(step, value)?;
            value = value.and_then(|value| step.get(value));
        }
        Some(node)
    }

    /// The schema one step into `value`, whose schema this is.
    pub fn entry(self, step: &Step, value: Option<&Value>) -> Option<Self> {
        let settings = self.settings_of(value);
        let inner = match step {
            Step::Key(key) => settings.property(key)?,
            Step::Index(_) => settings.items()?,
        };
        Some(self.resolved(inner))
    }

    /// The kind of stage whose settings belong here, e.g. `transfer`.
    pub fn stage(self) -> Option<&'s str> {
        self.stage
    }

    /// The type that is taken where the document names none.
    pub fn default_type(self) -> Option<&'s str> {
        self.slot.get("default")?.get("type")?.as_str()
    }

    /// Whether the value names a file.
    pub fn is_file(self) -> bool {
        self.slot.get("x-file").and_then(Value::as_bool).unwrap_or(false)
    }

    /// Whether the value is a program with its arguments.
    pub fn is_command(self) -> bool {
        self.slot.get("x-command").and_then(Value::as_bool).unwrap_or(false)
    }

    /// An extension of the slot, e.g. `x-defaults`, else of the schema that the slot refers to.
    pub fn extension(self, name: &str) -> Option<&'s Value> {
        self.slot.get(name).or_else(|| self.schema.get(name))
    }

    /// The schema itself, with its limits and choices.
    pub fn schema(self) -> &'s Value {
        self.schema
    }

    /// The description of the slot, else of the schema that it refers to.
    pub fn description(self) -> &'s str {
        self.extension("description").and_then(Value::as_str).unwrap_or_default()
    }

    /// The default of the slot.
    pub fn default(self) -> Option<&'s Value> {
        self.slot.get("default")
    }

    /// The named properties with their schemas; of a stage those of `value`'s type.
    pub fn properties(self, value: Option<&Value>) -> Vec<(&'s str, Self)> {
        let own = self.settings_of(value).schema.get("properties").and_then(Value::as_object);
        own.into_iter().flatten().map(|(key, schema)| (key.as_str(), self.resolved(schema))).collect()
    }

    /// The schema of the settings of the stage `name`, where settings of a stage belong.
    pub fn variant(self, name: &str) -> Option<Self> {
        let variants = self.schema.get("oneOf")?.as_array()?;
        let found = variants.iter().find(|variant| type_of(variant) == Some(name))?;
        Some(Self { slot: found, schema: found, stage: None, ..self })
    }

    /// For the slot of a stage the schema of its settings in `value`, or in its default; else the schema itself.
    fn settings_of(self, value: Option<&Value>) -> Self {
        if self.stage().is_none() {
            return self;
        }
        let name = value.and_then(|value| value.get("type")).and_then(Value::as_str).or(self.default_type());
        name.and_then(|name| self.variant(name)).unwrap_or(self)
    }

    /// The schema of the property `key`, looked for in every alternative.
    fn property(self, key: &str) -> Option<&'s Value> {
        if let Some(found) = self.schema.get("properties").and_then(|properties| properties.get(key)) {
            return Some(found);
        }
        if let Some(any) = self.schema.get("additionalProperties").filter(|any| any.is_object()) {
            return Some(any);
        }
        self.alternatives().find_map(|node| node.property(key))
    }

    /// The schema of the items of a sequence, looked for in every alternative.
    fn items(self) -> Option<&'s Value> {
        self.schema.get("items").or_else(|| self.alternatives().find_map(Self::items))
    }

    /// The alternatives that the schema allows; those of a stage are its types, of which only the value says which counts.
    fn alternatives(self) -> impl Iterator<Item = Self> {
        let schemas = ["oneOf", "anyOf"].into_iter().filter_map(move |key| self.schema.get(key)?.as_array());
        schemas.flatten().filter(move |_| self.stage.is_none()).map(move |schema| self.resolved(schema))
    }

    /// The node of `slot`, with what it refers to: through `$ref`, and through `anyOf` with `null` of an optional value.
    fn resolved(self, slot: &'s Value) -> Self {
        let mut schema = slot;
        let mut stage = None;
        loop {
            stage = stage.or(schema.get("x-stage").and_then(Value::as_str));
            let target = schema.get("$ref").and_then(Value::as_str).and_then(|to| to.strip_prefix("#/$defs/"));
            let next = match target {
                Some(name) => self.root.get("$defs").and_then(|definitions| definitions.get(name)),
                None => schema.get("anyOf").and_then(Value::as_array).and_then(|choices| only_one(choices)),
            };
            match next {
                Some(next) => schema = next,
                None => return Self { root: self.root, slot, schema, stage },
            }
        }
    }
}

/// The schema of `T` with all stages that are known by now.
fn schema_of<T: JsonSchema + 'static>() -> &'static Value {
    /// The schemas with how often aliases had changed when they were made.
    type Made = HashMap<TypeId, (u64, &'static Value)>;
    static MADE: LazyLock<Mutex<Made>> = LazyLock::new(Mutex::default);
    // A panic elsewhere leaves whole schemas.
    let mut made = MADE.lock().unwrap_or_else(PoisonError::into_inner);
    let changes = plugin::changes();
    match made.get(&TypeId::of::<T>()) {
        Some((of, schema)) if *of == changes => schema,
        _ => {
            // Those who walk an older schema may go on. There are as many as names that the program learns.
            let schema = Box::leak(Box::new(schemars::schema_for!(T).to_value()));
            made.insert(TypeId::of::<T>(), (changes, schema));
            schema
        }
    }
}

/// The type that a variant of a stage's schema is for.
fn type_of(variant: &Value) -> Option<&str> {
    variant.get("properties")?.get("type")?.get("const")?.as_str()
}

/// The only alternative beside `null` and the word that leaves the choice.
fn only_one(choices: &[Value]) -> Option<&Value> {
    let is_own =
        |choice: &&Value| choice.get("type").and_then(Value::as_str) != Some("null") && choice.get("const").is_none();
    let mut others = choices.iter().filter(is_own);
    others.next().filter(|_| others.next().is_none())
}
