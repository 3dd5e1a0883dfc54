//! Clusterers.

use std::sync::Arc;

use mimesh_core::{
    Error, Figures, Result,
    mesh::Surface,
    register,
    stage::{BoundClusterer, Clusterer, Regions},
};
use nalgebra::{DMatrix, Point3};
use pyo3::{prelude::*, types::PyList};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize, Serializer};
use serde_json::{Map, Value};

use super::call::{Written, array, positions, surface, whole_numbers};
use crate::array::View;

register!(Clusterer: PythonClusterer);

/// A clusterer that is written in Python; its own name says which.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct PythonClusterer {
    /// The name under which its class is registered.
    pub class: String,
    /// The settings of the class.
    pub settings: Map<String, Value>,
}

/// As pipelines have it, under its own name.
impl Serialize for PythonClusterer {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        self.settings.serialize(serializer)
    }
}

impl PythonClusterer {
    fn written(&self) -> Written<'_> {
        Written { kind: "clusterer", class: &self.class, settings: &self.settings }
    }
}

#[typetag::deserialize(name = "python")]
impl Clusterer for PythonClusterer {
    fn typetag_name(&self) -> &'static str {
        self.written().name()
    }

    fn bind(&self, surface: &Surface, poses: &[Vec<Point3<f64>>]) -> Result<Box<dyn BoundClusterer>> {
        poses
            .iter()
            .try_for_each(|pose| Error::check_shape("vertices of a pose (#V)", surface.vertex_count(), pose.len()))?;
        Ok(Box::new(BoundPython { stage: self.clone(), surface: Arc::new(surface.clone()), poses: poses.to_vec() }))
    }
}

#[derive(Debug)]
struct BoundPython {
    stage: PythonClusterer,
    surface: Arc<Surface>,
    poses: Vec<Vec<Point3<f64>>>,
}

impl BoundClusterer for BoundPython {
    fn cluster(&self, weights: &DMatrix<f64>) -> Result<Regions> {
        Error::check_shape("rows of weights (#V)", self.surface.vertex_count(), weights.nrows())?;
        let labels = self.stage.written().call(|py, stage| {
            let poses: Vec<_> = self.poses.iter().map(|pose| positions(py, pose)).collect::<PyResult<_>>()?;
            let shape = vec![weights.ncols(), weights.nrows()];
            let columns = array(py, View::numbers(Arc::new(weights.clone()), shape, DMatrix::as_slice))?;
            let arguments = (surface(py, &self.surface)?, PyList::new(py, poses)?, columns.getattr("T")?);
            whole_numbers(&stage.call_method1("cluster", arguments)?)
        })?;
        let wrong = labels.iter().find(|label| u32::try_from(**label).is_err());
        if let Some(wrong) = wrong {
            let message = format!("clusterer `{}` gave the region {wrong}", self.stage.class);
            return Err(Error::data(message, "number the regions from 0"));
        }
        // Regions without a vertex have no number.
        let mut used: Vec<i64> = labels.clone();
        used.sort_unstable();
        used.dedup();
        let number = |label: &i64| used.partition_point(|other| other < label) as u32;
        let regions =
            Regions { of_vertex: labels.iter().map(number).collect(), count: used.len(), figures: Figures::default() };
        regions.check(self.surface.vertex_count())?;
        Ok(regions)
    }
}
