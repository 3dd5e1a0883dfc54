//! Transfers.

use std::sync::Arc;

use mimesh_core::{
    Error, Figures, Result,
    mesh::check_finite,
    register,
    stage::{BindInput, BoundTransfer, Transfer, Transferred},
};
use nalgebra::Point3;
use pyo3::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize, Serializer};
use serde_json::{Map, Value};

use super::call::{Written, marker_pairs, numbers, positions, surface};
use crate::{array::points, stage::MapData};

register!(Transfer: PythonTransfer);

/// A transfer that is written in Python; its own name says which.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct PythonTransfer {
    /// The name under which its class is registered.
    pub class: String,
    /// The settings of the class.
    pub settings: Map<String, Value>,
}

/// As pipelines have it, under its own name.
impl Serialize for PythonTransfer {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        self.settings.serialize(serializer)
    }
}

impl PythonTransfer {
    fn written(&self) -> Written<'_> {
        Written { kind: "transfer", class: &self.class, settings: &self.settings }
    }
}

impl PythonTransfer {
    /// Whether the class says so under `name`.
    fn says<T: for<'a, 'py> FromPyObject<'a, 'py>>(&self, name: &str, otherwise: T) -> T {
        let said = self.written().call(|_, stage| stage.getattr(name)?.extract::<T>().map_err(Into::into));
        said.unwrap_or(otherwise)
    }
}

#[typetag::deserialize(name = "python")]
impl Transfer for PythonTransfer {
    fn typetag_name(&self) -> &'static str {
        self.written().name()
    }

    fn bind(&self, input: BindInput<'_>) -> Result<Box<dyn BoundTransfer>> {
        let map = if self.needs_correspondence() { Some(input.require_map()?) } else { input.map };
        let (source, target) = (Arc::new(input.pair.source.clone()), Arc::new(input.pair.target.clone()));
        let map = map.map(|map| MapData { map: Arc::new(map.clone()) });
        let [of_source, vertices] = [source.vertex_count(), target.vertex_count()];
        let bound = self.written().call(|py, stage| {
            let helper = py.import("mimesh._surface")?.getattr("bind")?;
            let map = map.map(|map| Bound::new(py, map)).transpose()?;
            let markers = marker_pairs(input.pair.markers);
            Ok(helper.call1((stage, surface(py, &source)?, surface(py, &target)?, map, markers))?.unbind())
        })?;
        Ok(Box::new(BoundPython { stage: self.clone(), bound, of_source, vertices }))
    }

    fn needs_correspondence(&self) -> bool {
        self.says("needs_correspondence", true)
    }

    fn markers_needed(&self) -> usize {
        self.says("markers_needed", 0)
    }
}

#[derive(Debug)]
struct BoundPython {
    stage: PythonTransfer,
    /// What `bind` gave: it is called with positions of the source.
    bound: Py<PyAny>,
    of_source: usize,
    vertices: usize,
}

impl BoundTransfer for BoundPython {
    fn transfer(&self, posed: &[Point3<f64>]) -> Result<Transferred> {
        Error::check_shape("posed source vertices (#V)", self.of_source, posed.len())?;
        check_finite(posed)?;
        let moved = Python::attach(|py| {
            let called = positions(py, posed).and_then(|posed| self.bound.call1(py, (posed,)));
            let moved = called.and_then(|moved| {
                let moved = numbers(moved.bind(py), "positions", 3)?;
                points(&moved).map_err(|error| pyo3::exceptions::PyValueError::new_err(error.to_string()))
            });
            moved.map_err(|error| self.stage.written().error(py, &error))
        })?;
        Error::check_shape("vertices of the result (#V)", self.vertices, moved.len())?;
        Ok(Transferred { positions: moved, figures: Figures::default() })
    }

    fn figures(&self) -> Figures {
        Figures::default()
    }
}
