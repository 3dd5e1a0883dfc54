//! Samplers.

use std::sync::Arc;

use mimesh_core::{
    Result,
    mesh::{Surface, SurfacePoint},
    register,
    stage::Sampler,
};
use pyo3::types::PyAnyMethods;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize, Serializer};
use serde_json::{Map, Value};

use super::call::{Written, surface};
use crate::surface::{PointParts, point};

register!(Sampler: PythonSampler);

/// A sampler that is written in Python; its own name says which.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct PythonSampler {
    /// The name under which its class is registered.
    pub class: String,
    /// The settings of the class.
    pub settings: Map<String, Value>,
}

/// As pipelines have it, under its own name.
impl Serialize for PythonSampler {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        self.settings.serialize(serializer)
    }
}

impl PythonSampler {
    fn written(&self) -> Written<'_> {
        Written { kind: "sampler", class: &self.class, settings: &self.settings }
    }
}

#[typetag::deserialize(name = "python")]
impl Sampler for PythonSampler {
    fn typetag_name(&self) -> &'static str {
        self.written().name()
    }

    fn sample(&self, of: &Surface) -> Result<Vec<SurfacePoint>> {
        let of = Arc::new(of.clone());
        let found: Vec<PointParts> = self.written().call(|py, stage| {
            let points = stage.call_method1("sample", (surface(py, &of)?,))?;
            py.import("mimesh._surface")?.getattr("parts_of")?.call1((points,))?.extract()
        })?;
        let (vertices, triangles) = (of.vertex_count(), of.triangle_count());
        let missing =
            found.iter().find(|(index, inside)| *index as usize >= if inside.is_some() { triangles } else { vertices });
        if let Some((index, _)) = missing {
            let message = format!("sampler `{}` gave a point at {index}, which the surface does not have", self.class);
            return Err(mimesh_core::Error::data(message, "give vertices of the surface, counted from 0"));
        }
        Ok(found.into_iter().map(point).collect())
    }
}
