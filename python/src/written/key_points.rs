//! Key points.

use std::sync::Arc;

use mimesh_core::{
    Error, Figures, Result, register,
    stage::{ChoiceWatch, Chosen, HandlePoints, KeyPoints, KeyPointsInput},
};
use pyo3::{prelude::*, types::PyList};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize, Serializer};
use serde_json::{Map, Value};

use super::call::{Written, positions, surface};
use crate::surface::{PointParts, parts, point};

register!(KeyPoints: PythonKeyPoints);

/// A choice of key points that is written in Python; its own name says which.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct PythonKeyPoints {
    /// The name under which its class is registered.
    pub class: String,
    /// The settings of the class.
    pub settings: Map<String, Value>,
}

/// As pipelines have it, under its own name.
impl Serialize for PythonKeyPoints {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        self.settings.serialize(serializer)
    }
}

impl PythonKeyPoints {
    fn written(&self) -> Written<'_> {
        Written { kind: "key_points", class: &self.class, settings: &self.settings }
    }
}

#[typetag::deserialize(name = "python")]
impl KeyPoints for PythonKeyPoints {
    fn typetag_name(&self) -> &'static str {
        self.written().name()
    }

    fn choose(&self, input: KeyPointsInput<'_>, _: &dyn ChoiceWatch) -> Result<Chosen> {
        let count = input.source.vertex_count();
        if input.poses.is_empty() {
            return Err(Error::data("there is no pose to choose points by", "give the source its poses"));
        }
        input.poses.iter().try_for_each(|pose| Error::check_shape("vertices of a pose (#V)", count, pose.len()))?;
        HandlePoints::new(input.source, input.start)?;
        let source = Arc::new(input.source.clone());
        let found: Vec<PointParts> = self.written().call(|py, stage| {
            let poses: Vec<_> = input.poses.iter().map(|pose| positions(py, pose)).collect::<PyResult<_>>()?;
            let start: Vec<PointParts> = input.start.iter().map(|point| parts(*point)).collect();
            let helper = py.import("mimesh._surface")?.getattr("choose")?;
            helper.call1((stage, surface(py, &source)?, PyList::new(py, poses)?, start))?.extract()
        })?;
        let points: Vec<_> = found.into_iter().map(point).collect();
        HandlePoints::new(input.source, &points)?;
        if points.is_empty() {
            return Err(Error::data(format!("key points `{}` gave no point", self.class), "give at least one"));
        }
        Ok(Chosen { points, steps: vec![], figures: Figures::default() })
    }
}
