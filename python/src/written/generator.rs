//! Generators.

use mimesh_core::{
    Result,
    mesh::{MeshSequence, check_finite},
    register,
    stage::Generator,
};
use pyo3::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize, Serializer};
use serde_json::{Map, Value};

use super::call::Written;
use crate::mesh::MeshData;

register!(Generator: PythonGenerator);

/// A generator that is written in Python; its own name says which.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct PythonGenerator {
    /// The name under which its class is registered.
    pub class: String,
    /// The settings of the class.
    pub settings: Map<String, Value>,
}

/// As pipelines have it, under its own name.
impl Serialize for PythonGenerator {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        self.settings.serialize(serializer)
    }
}

impl PythonGenerator {
    fn written(&self) -> Written<'_> {
        Written { kind: "generator", class: &self.class, settings: &self.settings }
    }
}

#[typetag::deserialize(name = "python")]
impl Generator for PythonGenerator {
    fn typetag_name(&self) -> &'static str {
        self.written().name()
    }

    fn make(&self) -> Result<MeshSequence> {
        let mesh = self.written().call(|py, stage| {
            let helper = py.import("mimesh._convert")?.getattr("generate")?;
            let made = helper.call1((stage,))?;
            let made = made.cast_into::<MeshData>().map_err(PyErr::from)?;
            Ok(made.get().sequence.clone())
        })?;
        mesh.rest.validate()?;
        mesh.poses.iter().try_for_each(|pose| check_finite(&pose.positions.get()?))?;
        Ok(MeshSequence::clone(&mesh))
    }
}
