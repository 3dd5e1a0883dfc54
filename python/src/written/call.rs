//! Calls into Python, whose exceptions become errors of the stage.

use std::{
    collections::HashMap,
    sync::{Arc, LazyLock, Mutex, PoisonError},
};

use mimesh_core::{Error, Result, mesh::Surface, stage::Marker};
use nalgebra::Point3;
use numpy::{PyArrayMethods, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::{prelude::*, types::PyDict};
use serde_json::{Map, Value};

use crate::{
    array::View,
    error::{place, words},
    surface::{PointParts, SurfaceData, parts},
};

/// A class of Python that is a stage, with settings.
#[derive(Clone, Copy)]
pub struct Written<'a> {
    /// The kind of stage.
    pub kind: &'static str,
    /// The name under which the class is registered.
    pub class: &'a str,
    /// Its settings.
    pub settings: &'a Map<String, Value>,
}

/// A text that lives as long as the program; equal ones are one.
pub fn lasting(text: String) -> &'static str {
    static TEXTS: LazyLock<Mutex<HashMap<String, &'static str>>> = LazyLock::new(Mutex::default);
    let mut texts = TEXTS.lock().unwrap_or_else(PoisonError::into_inner);
    texts.entry(text.clone()).or_insert_with(|| String::leak(text))
}

impl Written<'_> {
    /// The name by which pipelines, reports and messages call it.
    pub fn name(self) -> &'static str {
        if self.class.is_empty() { "python" } else { lasting(self.class.to_owned()) }
    }

    /// Does `act` with an object of the class.
    ///
    /// # Errors
    ///
    /// [`Error::Data`] with what Python raised.
    pub fn call<T>(self, act: impl FnOnce(Python<'_>, &Bound<'_, PyAny>) -> PyResult<T>) -> Result<T> {
        Python::attach(|py| {
            let settings = serde_json::to_string(self.settings).unwrap_or_default();
            let made = py
                .import("mimesh._stages")
                .and_then(|stages| stages.getattr("instance")?.call1((self.kind, self.class, settings)));
            made.and_then(|stage| act(py, &stage)).map_err(|error| self.error(py, &error))
        })
    }

    /// What `error` is for those who know no Python.
    pub fn error(self, py: Python<'_>, error: &PyErr) -> Error {
        let _ = py.import("mimesh._stages").and_then(|stages| {
            // Only so does the value have its traceback.
            let value = error.clone_ref(py).into_value(py);
            stages.getattr("report_failure")?.call1((self.kind, self.class, value))
        });
        let message = format!("{} `{}`, written in Python, raised {}", self.kind, self.class, words(py, error));
        Error::data(message, place(py, error))
    }
}

/// A surface as Python sees it.
pub fn surface<'py>(py: Python<'py>, surface: &Arc<Surface>) -> PyResult<Bound<'py, PyAny>> {
    let data = Bound::new(py, SurfaceData { surface: surface.clone() })?;
    py.import("mimesh._surface")?.getattr("Surface")?.getattr("_of")?.call1((data,))
}

/// Positions as an array that Python cannot write.
pub fn positions<'py>(py: Python<'py>, positions: &[Point3<f64>]) -> PyResult<Bound<'py, PyAny>> {
    array(py, View::points(Arc::new(positions.to_vec()), Vec::as_slice))
}

/// A view as an array of NumPy.
pub fn array(py: Python<'_>, view: View) -> PyResult<Bound<'_, PyAny>> {
    py.import("numpy")?.getattr("asarray")?.call1((Bound::new(py, view)?,))
}

/// A result of Python as an array of numbers in two dimensions, the second of `columns`.
pub fn numbers<'py>(result: &Bound<'py, PyAny>, what: &str, columns: usize) -> PyResult<PyReadonlyArray2<'py, f64>> {
    let py = result.py();
    let numpy = py.import("numpy")?;
    let kind = PyDict::new(py);
    kind.set_item("dtype", "float64")?;
    let array = numpy.getattr("ascontiguousarray")?.call((result,), Some(&kind))?;
    let wrong = |found: String| {
        pyo3::exceptions::PyValueError::new_err(format!(
            "{what}: expected an array of n × {columns} numbers, found {found}"
        ))
    };
    let shape = |array: &Bound<'py, PyAny>| array.getattr("shape").map(|shape| shape.to_string()).unwrap_or_default();
    let array = array.cast_into::<numpy::PyArray2<f64>>().map_err(|error| wrong(shape(&error.into_inner())))?;
    if array.shape()[1] != columns {
        return Err(wrong(format!("{:?}", array.shape())));
    }
    Ok(array.readonly())
}

/// A result of Python as whole numbers.
pub fn whole_numbers(result: &Bound<'_, PyAny>) -> PyResult<Vec<i64>> {
    if let Ok(list) = result.call_method0("tolist") { list.extract() } else { result.extract() }
}

/// Markers as pairs of points.
pub fn marker_pairs(markers: &[Marker]) -> Vec<(PointParts, PointParts)> {
    markers.iter().map(|marker| (parts(marker.source), parts(marker.target))).collect()
}
