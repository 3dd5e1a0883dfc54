//! Weights.

use std::sync::Arc;

use mimesh_core::{
    Error, Figures, Result,
    mesh::{Surface, SurfacePoint},
    register,
    stage::{BoundWeights, HandlePoints, HandleWeights, ProximityGraph, Weights, unreached},
};
use nalgebra::DMatrix;
use numpy::PyUntypedArrayMethods;
use pyo3::types::PyAnyMethods;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize, Serializer};
use serde_json::{Map, Value};

use super::call::{Written, numbers, surface};

register!(Weights: PythonWeights);

/// A weights that is written in Python; its own name says which.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct PythonWeights {
    /// The name under which its class is registered.
    pub class: String,
    /// The settings of the class.
    pub settings: Map<String, Value>,
}

/// As pipelines have it, under its own name.
impl Serialize for PythonWeights {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        self.settings.serialize(serializer)
    }
}

impl PythonWeights {
    fn written(&self) -> Written<'_> {
        Written { kind: "weights", class: &self.class, settings: &self.settings }
    }
}

#[typetag::deserialize(name = "python")]
impl Weights for PythonWeights {
    fn typetag_name(&self) -> &'static str {
        self.written().name()
    }

    fn bind(
        &self,
        surface: &Surface,
        points: &[SurfacePoint],
        proximity: Option<&ProximityGraph>,
    ) -> Result<Box<dyn BoundWeights>> {
        let handles = HandlePoints::new(surface, points)?;
        let links = proximity.map(|graph| graph.pairs().collect()).unwrap_or_default();
        Ok(Box::new(Bound { stage: self.clone(), surface: Arc::new(surface.clone()), handles, links }))
    }
}

#[derive(Debug)]
struct Bound {
    stage: PythonWeights,
    surface: Arc<Surface>,
    handles: HandlePoints,
    /// Pairs of vertices that join components.
    links: Vec<[u32; 2]>,
}

impl BoundWeights for Bound {
    fn solve(&self, handles: &[usize]) -> Result<HandleWeights> {
        let vertices = self.handles.choose(handles)?;
        let mut matrix = self.stage.written().call(|py, stage| {
            let helper = py.import("mimesh._surface")?.getattr("solve_weights")?;
            let solved = helper.call1((stage, surface(py, &self.surface)?, vertices.clone(), self.links.clone()))?;
            let solved = numbers(&solved, "weights", vertices.len())?;
            let rows = solved.as_slice().unwrap_or_default();
            Ok(DMatrix::from_row_slice(solved.shape()[0], vertices.len(), rows))
        })?;
        Error::check_shape("rows of weights (#V)", self.surface.vertex_count(), matrix.nrows())?;
        // Rows of zeros are of vertices that no handle reaches.
        let is_reached: Vec<bool> = matrix.row_iter().map(|row| row.iter().any(|weight| *weight != 0.0)).collect();
        for [vertex, by] in unreached(&self.surface, &is_reached)? {
            let row = matrix.row(by as usize).into_owned();
            matrix.set_row(vertex as usize, &row);
        }
        Ok(HandleWeights { matrix, figures: Figures::default() })
    }

    fn figures(&self) -> Figures {
        Figures::default()
    }
}
