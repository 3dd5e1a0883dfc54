//! Surfaces, as stages see meshes.

use std::sync::Arc;

use mimesh_core::{
    Error,
    mesh::{Surface, SurfacePoint},
    stage::Marker,
};
use nalgebra::Point3;
use numpy::PyReadonlyArray2;
use pyo3::prelude::*;

use crate::{
    array::{View, points},
    error::exception_of,
    mesh::MeshData,
};

/// The welded triangles of a mesh; it does not change.
#[pyclass(frozen)]
pub struct SurfaceData {
    /// The surface.
    pub surface: Arc<Surface>,
}

/// A point of a surface as Python has it: a vertex, or a triangle with barycentric coordinates.
pub type PointParts = (u32, Option<[f64; 3]>);

#[pymethods]
impl SurfaceData {
    /// The surface of a mesh.
    #[new]
    fn new(py: Python<'_>, mesh: &Bound<'_, MeshData>) -> PyResult<Self> {
        let mesh = mesh.get();
        let surface = py.detach(|| mesh.surface()).map_err(|error| exception_of(py, error))?;
        Ok(Self { surface })
    }

    /// Positions at rest, n × 3.
    fn vertices(&self) -> View {
        View::points(self.surface.clone(), |surface| &surface.positions)
    }

    /// The triangles, m × 3.
    fn triangles(&self) -> View {
        View::triangles(self.surface.clone(), |surface| &surface.triangles)
    }

    /// The vertex of the surface for each vertex of the mesh, -1 for one that no face uses.
    fn vertex_of(&self) -> Vec<i64> {
        self.surface.vertex_of.iter().map(|vertex| vertex.map_or(-1, i64::from)).collect()
    }

    /// The first vertex of the mesh for each vertex of the surface.
    fn representative(&self) -> View {
        View::indices(self.surface.clone(), |surface| &surface.representative)
    }

    /// Positions of the surface, from those of the mesh.
    fn from_mesh(&self, py: Python<'_>, positions: PyReadonlyArray2<'_, f64>) -> PyResult<View> {
        let moved = points(&positions).and_then(|positions| self.surface.from_mesh(&positions));
        moved.map(|moved| View::points(Arc::new(moved), Vec::as_slice)).map_err(|error| exception_of(py, error))
    }

    /// Positions of the mesh, from those of the surface.
    fn to_mesh(&self, py: Python<'_>, positions: PyReadonlyArray2<'_, f64>) -> PyResult<View> {
        let moved = points(&positions).and_then(|positions| self.surface.to_mesh(&positions));
        moved.map(|moved| View::points(Arc::new(moved), Vec::as_slice)).map_err(|error| exception_of(py, error))
    }

    /// The connected component of each vertex.
    fn components(&self) -> Vec<i64> {
        self.surface.components().of_vertex.iter().map(|component| component.map_or(-1, i64::from)).collect()
    }
}

/// A point of a surface of Rust.
pub fn point((index, barycentric): PointParts) -> SurfacePoint {
    barycentric.map_or(SurfacePoint::Vertex(index), |b| SurfacePoint::Triangle(index, b))
}

/// A point of a surface of Python.
pub fn parts(point: SurfacePoint) -> PointParts {
    match point {
        SurfacePoint::Vertex(vertex) => (vertex, None),
        SurfacePoint::Triangle(triangle, barycentric) => (triangle, Some(barycentric)),
    }
}

/// Markers of pairs of points, called by their numbers.
pub fn markers(pairs: Vec<(PointParts, PointParts)>) -> Vec<Marker> {
    let marker = |(i, (source, target))| Marker { name: format!("{i}"), source: point(source), target: point(target) };
    pairs.into_iter().enumerate().map(marker).collect()
}

/// Positions of poses that have `count` vertices.
///
/// # Errors
///
/// [`Error::Shape`] if one has another number.
pub fn poses(arrays: &[PyReadonlyArray2<'_, f64>], count: usize) -> mimesh_core::Result<Vec<Vec<Point3<f64>>>> {
    let read = |array: &PyReadonlyArray2<'_, f64>| {
        let positions = points(array)?;
        Error::check_shape("vertices of a pose (#V)", count, positions.len())?;
        Ok(positions)
    };
    arrays.iter().map(read).collect()
}
