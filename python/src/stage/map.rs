//! Which triangles of two surfaces correspond.

use std::sync::Arc;

use mimesh_core::stage::{Correspondence, TransferPair, TriangleMap};
use pyo3::prelude::*;

use super::settings::stage;
use crate::{
    error::{exception, exception_of},
    surface::{PointParts, SurfaceData, markers, parts},
    work,
};

/// Where on the source each part of the target takes its motion from.
#[pyclass(frozen)]
pub struct MapData {
    /// The map.
    pub map: Arc<TriangleMap>,
}

#[pymethods]
impl MapData {
    /// A map of triangles as wholes: for each of the target that of the source, or -1.
    #[new]
    fn new(source_triangles: usize, triangles: Vec<i64>) -> Self {
        let triangles = triangles.into_iter().map(|triangle| u32::try_from(triangle).ok()).collect();
        let map = TriangleMap { source_triangle_count: source_triangles, triangles, ..TriangleMap::default() };
        Self { map: Arc::new(map) }
    }

    /// For each triangle of the target that of the source, or -1.
    fn triangles(&self) -> Vec<i64> {
        self.map.triangles.iter().map(|triangle| triangle.map_or(-1, i64::from)).collect()
    }

    /// For each vertex of the target the point of the source that it lies at; empty if triangles correspond as wholes.
    fn points(&self) -> Vec<Option<PointParts>> {
        self.map.points.iter().map(|point| point.map(parts)).collect()
    }

    /// The report of the correspondence, as JSON.
    fn figures(&self) -> String {
        serde_json::to_string(&self.map.figures).unwrap_or_default()
    }
}

/// The map of a correspondence.
#[pyfunction]
pub fn correspond(
    py: Python<'_>,
    settings: &str,
    source: &Bound<'_, SurfaceData>,
    target: &Bound<'_, SurfaceData>,
    pairs: Vec<(PointParts, PointParts)>,
) -> PyResult<MapData> {
    let stage = stage::<dyn Correspondence>(settings).map_err(|wrong| exception(py, &wrong))?;
    let (source, target) = (source.get().surface.clone(), target.get().surface.clone());
    let map = work::run(py, None, move |watch| {
        let markers = markers(pairs);
        let pair = TransferPair { source: &source, target: &target, markers: &markers, proximity: None };
        pair.check_markers()?;
        stage.correspond_watched(pair, mimesh_core::stage::Work::new(&|_| watch.check()))
    })?;
    map.map(|map| MapData { map: Arc::new(map) }).map_err(|error| exception_of(py, error))
}
