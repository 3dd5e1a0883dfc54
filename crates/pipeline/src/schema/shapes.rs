//! What documents ask of the schema: which stages belong where, and which words.

use mimesh_core::plugin;
use mimesh_document::{Shapes, Step, Variants};
use serde_json::Value;

use super::{SchemaNode, choices};

/// The knowledge of a pipeline's values, for documents.
#[derive(Clone, Copy, Debug)]
pub struct PipelineShapes;

/// The knowledge of the values of a document with this schema.
#[derive(Clone, Copy, Debug)]
pub struct SchemaShapes(pub SchemaNode<'static>);

impl Shapes for PipelineShapes {
    fn variants(&self, root: &Value, path: &[Step]) -> Option<Variants> {
        SchemaShapes(SchemaNode::pipeline()).variants(root, path)
    }

    fn choices(&self, root: &Value, path: &[Step]) -> Vec<String> {
        SchemaShapes(SchemaNode::pipeline()).choices(root, path)
    }

    fn default_type(&self, root: &Value, path: &[Step]) -> Option<String> {
        SchemaShapes(SchemaNode::pipeline()).default_type(root, path)
    }

    fn renamed(&self, root: &Value, path: &[Step], key: &str) -> Option<String> {
        SchemaShapes(SchemaNode::pipeline()).renamed(root, path, key)
    }
}

impl Shapes for SchemaShapes {
    fn variants(&self, root: &Value, path: &[Step]) -> Option<Variants> {
        let kind = self.0.at(root, path)?.stage()?;
        Some(Variants { kind: kind.into(), types: types(kind).into_iter().map(str::to_owned).collect() })
    }

    fn choices(&self, root: &Value, path: &[Step]) -> Vec<String> {
        let node = self.0.at(root, path).filter(|node| node.stage().is_none());
        node.map(|node| choices(node.schema())).unwrap_or_default()
    }

    fn default_type(&self, root: &Value, path: &[Step]) -> Option<String> {
        self.0.at(root, path)?.default_type().map(str::to_owned)
    }

    fn renamed(&self, root: &Value, path: &[Step], key: &str) -> Option<String> {
        let node = self.0.at(root, path)?;
        let value = path.iter().try_fold(root, |value, step| step.get(value));
        node.renamed(value, key)
    }
}

impl SchemaNode<'_> {
    /// The present name of `key`, which used to be a key of this mapping.
    pub fn renamed(self, value: Option<&Value>, key: &str) -> Option<String> {
        let name = value.and_then(|value| value.get("type")).and_then(Value::as_str);
        let settings = name.and_then(|name| self.variant(name)).unwrap_or(self);
        settings.extension("x-renamed")?.get(key)?.as_str().map(str::to_owned)
    }
}

/// The registered types of a kind of stage, sorted.
pub fn types(kind: &str) -> Vec<&'static str> {
    plugin::all().into_iter().filter(|plugin| plugin.stage == kind).map(|plugin| plugin.name()).collect()
}
