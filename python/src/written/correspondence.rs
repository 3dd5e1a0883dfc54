//! Correspondences.

use std::sync::Arc;

use mimesh_core::{
    Result, register,
    stage::{Correspondence, TransferPair, TriangleMap},
};
use pyo3::types::PyAnyMethods;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize, Serializer};
use serde_json::{Map, Value};

use super::call::{Written, marker_pairs, surface, whole_numbers};

register!(Correspondence: PythonCorrespondence);

/// A correspondence that is written in Python; its own name says which.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct PythonCorrespondence {
    /// The name under which its class is registered.
    pub class: String,
    /// The settings of the class.
    pub settings: Map<String, Value>,
}

/// As pipelines have it, under its own name.
impl Serialize for PythonCorrespondence {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        self.settings.serialize(serializer)
    }
}

impl PythonCorrespondence {
    fn written(&self) -> Written<'_> {
        Written { kind: "correspondence", class: &self.class, settings: &self.settings }
    }
}

#[typetag::deserialize(name = "python")]
impl Correspondence for PythonCorrespondence {
    fn typetag_name(&self) -> &'static str {
        self.written().name()
    }

    fn correspond(&self, pair: TransferPair<'_>) -> Result<TriangleMap> {
        let (source, target) = (Arc::new(pair.source.clone()), Arc::new(pair.target.clone()));
        let triangles = self.written().call(|py, stage| {
            let arguments = (surface(py, &source)?, surface(py, &target)?, marker_pairs(pair.markers));
            let helper = py.import("mimesh._surface")?.getattr("correspond")?;
            whole_numbers(&helper.call1((stage, arguments.0, arguments.1, arguments.2))?)
        })?;
        let triangles = triangles.into_iter().map(|triangle| u32::try_from(triangle).ok()).collect();
        let map =
            TriangleMap { source_triangle_count: pair.source.triangle_count(), triangles, ..TriangleMap::default() };
        map.check(pair)?;
        Ok(map)
    }
}
