//! Deformers.

use std::sync::Arc;

use mimesh_core::{
    Error, Figures, Result,
    mesh::{Surface, check_finite},
    register,
    stage::{BoundDeformer, Deformer, Fit, HandleWeights, Regions, Skin},
};
use nalgebra::{DMatrix, Matrix3x4, Point3, Vector3, Vector4};
use numpy::PyUntypedArrayMethods;
use pyo3::types::PyAnyMethods;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize, Serializer};
use serde_json::{Map, Value};

use super::call::{Written, array, numbers, positions, surface};
use crate::array::View;

register!(Deformer: PythonDeformer);

/// A deformer that is written in Python; its own name says which.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct PythonDeformer {
    /// The name under which its class is registered.
    pub class: String,
    /// The settings of the class.
    pub settings: Map<String, Value>,
}

/// As pipelines have it, under its own name.
impl Serialize for PythonDeformer {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        self.settings.serialize(serializer)
    }
}

impl PythonDeformer {
    fn written(&self) -> Written<'_> {
        Written { kind: "deformer", class: &self.class, settings: &self.settings }
    }
}

#[typetag::deserialize(name = "python")]
impl Deformer for PythonDeformer {
    fn typetag_name(&self) -> &'static str {
        self.written().name()
    }

    fn bind(&self, surface: &Surface) -> Result<Box<dyn BoundDeformer>> {
        Ok(Box::new(Bound { stage: self.clone(), surface: Arc::new(surface.clone()) }))
    }
}

#[derive(Debug)]
struct Bound {
    stage: PythonDeformer,
    surface: Arc<Surface>,
}

impl BoundDeformer for Bound {
    fn skin(&self, weights: &HandleWeights, regions: &Regions) -> Result<Box<dyn Skin>> {
        Error::check_shape("rows of weights (#V)", self.surface.vertex_count(), weights.matrix.nrows())?;
        regions.check(self.surface.vertex_count())?;
        let (weights, regions) = (Arc::new(weights.matrix.clone()), Arc::new(regions.of_vertex.clone()));
        Ok(Box::new(PythonSkin { stage: self.stage.clone(), surface: self.surface.clone(), weights, regions }))
    }
}

#[derive(Debug)]
struct PythonSkin {
    stage: PythonDeformer,
    surface: Arc<Surface>,
    weights: Arc<DMatrix<f64>>,
    regions: Arc<Vec<u32>>,
}

impl Skin for PythonSkin {
    fn fit(&self, posed: &[Point3<f64>]) -> Result<Fit> {
        Error::check_shape("posed vertices (#V)", self.surface.vertex_count(), posed.len())?;
        check_finite(posed)?;
        let transforms: Vec<Matrix3x4<f64>> = self.stage.written().call(|py, stage| {
            let shape = vec![self.weights.ncols(), self.weights.nrows()];
            let weights = array(py, View::numbers(self.weights.clone(), shape, DMatrix::as_slice))?.getattr("T")?;
            let regions = array(py, View::indices(self.regions.clone(), Vec::as_slice))?;
            let helper = py.import("mimesh._surface")?.getattr("fit")?;
            let fitted = helper.call1((stage, surface(py, &self.surface)?, weights, regions, positions(py, posed)?))?;
            let fitted = numbers(&fitted, "maps", 12)?;
            debug_assert_eq!(fitted.shape()[1], 12);
            Ok(fitted.as_slice().unwrap_or_default().chunks_exact(12).map(Matrix3x4::from_row_slice).collect())
        })?;
        Error::check_shape("maps of handles (#H)", self.weights.ncols(), transforms.len())?;
        let place = |(v, rest): (usize, &Point3<f64>)| {
            let rest = Vector4::new(rest.x, rest.y, rest.z, 1.0);
            let sum: Vector3<f64> =
                transforms.iter().zip(self.weights.row(v).iter()).map(|(map, weight)| map * rest * *weight).sum();
            Point3::from(sum)
        };
        let positions = self.surface.positions.iter().enumerate().map(place).collect();
        Ok(Fit { transforms, positions, figures: Figures::default() })
    }
}
