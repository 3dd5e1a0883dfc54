//! Transfers that are bound to two surfaces.

use std::sync::Arc;

use mimesh_core::stage::{BindInput, BoundTransfer, Proximity, Transfer, TransferPair, Work};
use nalgebra::Point3;
use numpy::PyReadonlyArray2;
use pyo3::prelude::*;

use super::{map::MapData, settings::stage};
use crate::{
    array::{View, points},
    error::{exception, exception_of},
    surface::{PointParts, SurfaceData, markers, poses},
    work,
};

/// A transfer that is bound to two surfaces.
#[pyclass(frozen)]
pub struct BoundData {
    bound: Arc<dyn BoundTransfer>,
}

/// Binds a transfer.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "Python names them")]
pub fn bind(
    py: Python<'_>,
    settings: &str,
    source: &Bound<'_, SurfaceData>,
    target: &Bound<'_, SurfaceData>,
    pairs: Vec<(PointParts, PointParts)>,
    map: Option<&Bound<'_, MapData>>,
    seen_poses: Vec<PyReadonlyArray2<'_, f64>>,
    proximity: Option<&str>,
) -> PyResult<BoundData> {
    let transfer = stage::<dyn Transfer>(settings).map_err(|wrong| exception(py, &wrong))?;
    let proximity = proximity.map(stage::<dyn Proximity>).transpose().map_err(|wrong| exception(py, &wrong))?;
    let (source, target) = (source.get().surface.clone(), target.get().surface.clone());
    let seen = poses(&seen_poses, source.vertex_count()).map_err(|error| exception_of(py, error))?;
    let map = map.map(|map| map.get().map.clone());
    let bound = work::run(py, None, move |watch| {
        let graph = proximity.map(|stage| stage.proximity(&target)).transpose()?;
        let markers = markers(pairs);
        let pair = TransferPair { source: &source, target: &target, markers: &markers, proximity: graph.as_ref() };
        pair.check_markers()?;
        let report = |_| watch.check();
        let wanted = evenly_spaced(seen, transfer.poses_wanted());
        transfer.bind(BindInput { pair, map: map.as_deref(), poses: &wanted, work: Work::new(&report) })
    })?;
    bound.map(|bound| BoundData { bound: bound.into() }).map_err(|error| exception_of(py, error))
}

/// At most `count` of the poses, evenly spaced.
fn evenly_spaced(poses: Vec<Vec<Point3<f64>>>, count: usize) -> Vec<Vec<Point3<f64>>> {
    let chosen = mimesh_pipeline::input::evenly_spaced(poses.len(), count);
    chosen.into_iter().map(|i| poses[i].clone()).collect()
}

#[pymethods]
impl BoundData {
    /// The target's positions when the source is at `posed`.
    fn transfer(&self, py: Python<'_>, posed: PyReadonlyArray2<'_, f64>) -> PyResult<View> {
        let posed = points(&posed).map_err(|error| exception_of(py, error))?;
        let bound = self.bound.clone();
        let moved = work::run(py, None, move |_| bound.transfer(&posed).map(|transferred| transferred.positions))?;
        moved.map(|moved| View::points(Arc::new(moved), Vec::as_slice)).map_err(|error| exception_of(py, error))
    }

    /// The report of binding, as JSON.
    fn figures(&self) -> String {
        serde_json::to_string(&self.bound.figures()).unwrap_or_default()
    }
}
