//! Memory of Rust that NumPy looks at in its place, and arrays of NumPy as data of Rust.

use std::{any::Any, sync::Arc};

use mimesh_core::{Error, Result};
use nalgebra::Point3;
use numpy::{PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::{
    prelude::*,
    types::{PyDict, PyTuple},
};

/// Memory that does not change as long as somebody looks at it.
///
/// `numpy.asarray(view)` is an array of that memory, which it keeps alive and cannot write.
#[pyclass(frozen)]
pub struct View {
    address: usize,
    shape: Vec<usize>,
    kind: &'static str,
    _owner: Arc<dyn Any + Send + Sync>,
}

impl View {
    /// The points that `part` gives of `owner`, n × 3.
    pub fn points<O: Any + Send + Sync>(owner: Arc<O>, part: impl Fn(&O) -> &[Point3<f64>]) -> Self {
        let points = part(&owner);
        let (address, shape) = (points.as_ptr() as usize, vec![points.len(), 3]);
        Self { address, shape, kind: "f8", _owner: owner }
    }

    /// Numbers of `owner` as an array of `shape`.
    pub fn numbers<O: Any + Send + Sync>(owner: Arc<O>, shape: Vec<usize>, part: impl Fn(&O) -> &[f64]) -> Self {
        let numbers = part(&owner);
        assert_eq!(numbers.len(), shape.iter().product::<usize>(), "an array of its own shape");
        Self { address: numbers.as_ptr() as usize, shape, kind: "f8", _owner: owner }
    }

    /// The indices that `part` gives of `owner`.
    pub fn indices<O: Any + Send + Sync>(owner: Arc<O>, part: impl Fn(&O) -> &[u32]) -> Self {
        let indices = part(&owner);
        let (address, shape) = (indices.as_ptr() as usize, vec![indices.len()]);
        Self { address, shape, kind: "u4", _owner: owner }
    }

    /// The triangles that `part` gives of `owner`, n × 3.
    pub fn triangles<O: Any + Send + Sync>(owner: Arc<O>, part: impl Fn(&O) -> &[[u32; 3]]) -> Self {
        let triangles = part(&owner);
        let (address, shape) = (triangles.as_ptr() as usize, vec![triangles.len(), 3]);
        Self { address, shape, kind: "u4", _owner: owner }
    }
}

#[pymethods]
impl View {
    /// Where the memory is, for NumPy.
    #[getter]
    fn __array_interface__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let order = if cfg!(target_endian = "little") { '<' } else { '>' };
        let interface = PyDict::new(py);
        interface.set_item("version", 3)?;
        interface.set_item("typestr", format!("{order}{}", self.kind))?;
        interface.set_item("shape", PyTuple::new(py, &self.shape)?)?;
        // `True` says that nobody may write.
        interface.set_item("data", (self.address, true))?;
        Ok(interface)
    }
}

/// The rows of an array of n × 3 numbers, one after the other in memory.
///
/// # Errors
///
/// [`Error::Data`] for an array of another shape or order.
pub fn points(array: &PyReadonlyArray2<'_, f64>) -> Result<Vec<Point3<f64>>> {
    let numbers = array.as_slice().ok().filter(|_| array.shape()[1] == 3);
    let numbers = numbers.ok_or_else(|| shape_error("positions", "an array of n × 3 numbers", array.shape()))?;
    Ok(numbers.chunks_exact(3).map(|p| Point3::new(p[0], p[1], p[2])).collect())
}

/// The numbers of an array.
///
/// # Errors
///
/// [`Error::Data`] for an array whose numbers do not lie one after the other.
pub fn indices<'a>(array: &'a PyReadonlyArray1<'_, u32>) -> Result<&'a [u32]> {
    array.as_slice().map_err(|_| shape_error("indices", "numbers one after the other in memory", array.shape()))
}

fn shape_error(what: &str, expected: &str, shape: &[usize]) -> Error {
    let message = format!("{what}: expected {expected}, found an array of the shape {shape:?}");
    Error::data(message, "make it contiguous: `numpy.ascontiguousarray(…)`")
}
