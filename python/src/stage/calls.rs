//! Stages that give their result in one call.

use std::sync::Arc;

use mimesh_core::{
    Error, Figures,
    mesh::{Surface, SurfacePoint},
    stage::{
        Clusterer, Deformer, Generator, HandleWeights, KeyPoints, KeyPointsInput, Landmarks, Metric, MetricContext,
        MetricInput, Posed, Proximity, Regions, Sampler, TransferPair, Weights, Work,
    },
};
use nalgebra::DMatrix;
use numpy::PyReadonlyArray2;
use pyo3::prelude::*;

use super::settings::stage;
use crate::{
    array::{View, points},
    error::{exception, exception_of},
    mesh::MeshData,
    surface::{PointParts, SurfaceData, markers, parts, point, poses},
    work::{self, Watch},
};

/// Does `work` on its own thread.
fn doing<T: Send + 'static>(
    py: Python<'_>,
    act: impl FnOnce(&Watch) -> mimesh_core::Result<T> + Send + 'static,
) -> PyResult<T> {
    work::run(py, None, act)?.map_err(|error| exception_of(py, error))
}

/// The points of a sampler.
#[pyfunction]
pub fn sample(py: Python<'_>, settings: &str, surface: &Bound<'_, SurfaceData>) -> PyResult<Vec<PointParts>> {
    let stage = stage::<dyn Sampler>(settings).map_err(|wrong| exception(py, &wrong))?;
    let surface = surface.get().surface.clone();
    let found = doing(py, move |_| stage.sample(&surface))?;
    Ok(found.into_iter().map(parts).collect())
}

/// The weights of handles at points, one column after the other (#H × #V).
#[pyfunction]
pub fn weights(
    py: Python<'_>,
    settings: &str,
    surface: &Bound<'_, SurfaceData>,
    handles: Vec<PointParts>,
    proximity: Option<&str>,
) -> PyResult<View> {
    let weights = stage::<dyn Weights>(settings).map_err(|wrong| exception(py, &wrong))?;
    let proximity = proximity.map(stage::<dyn Proximity>).transpose().map_err(|wrong| exception(py, &wrong))?;
    let surface = surface.get().surface.clone();
    let matrix = doing(py, move |watch| {
        let graph = proximity.map(|stage| stage.proximity(&surface)).transpose()?;
        let points: Vec<SurfacePoint> = handles.into_iter().map(point).collect();
        let bound = weights.bind(&surface, &points, graph.as_ref())?;
        let all: Vec<usize> = (0..points.len()).collect();
        Ok(bound.solve_watched(&all, Work::new(&|_| watch.check()))?.matrix)
    })?;
    let shape = vec![matrix.ncols(), matrix.nrows()];
    Ok(View::numbers(Arc::new(matrix), shape, DMatrix::as_slice))
}

/// The region of each vertex for weights (#V × #H), and the number of regions.
#[pyfunction]
pub fn cluster(
    py: Python<'_>,
    settings: &str,
    surface: &Bound<'_, SurfaceData>,
    seen_poses: Vec<PyReadonlyArray2<'_, f64>>,
    weights: PyReadonlyArray2<'_, f64>,
) -> PyResult<(View, usize)> {
    let stage = stage::<dyn Clusterer>(settings).map_err(|wrong| exception(py, &wrong))?;
    let surface = surface.get().surface.clone();
    let seen = poses(&seen_poses, surface.vertex_count()).map_err(|error| exception_of(py, error))?;
    let weights = matrix(&weights);
    let regions = doing(py, move |_| stage.bind(&surface, &seen)?.cluster(&weights))?;
    let count = regions.count;
    Ok((View::indices(Arc::new(regions), |regions| &regions.of_vertex), count))
}

/// The maps (#H × 3 × 4) that bring a surface closest to a pose, and where they bring it.
#[pyfunction]
pub fn fit(
    py: Python<'_>,
    settings: &str,
    surface: &Bound<'_, SurfaceData>,
    weights: PyReadonlyArray2<'_, f64>,
    regions: Vec<u32>,
    posed: PyReadonlyArray2<'_, f64>,
) -> PyResult<(View, View)> {
    let stage = stage::<dyn Deformer>(settings).map_err(|wrong| exception(py, &wrong))?;
    let surface = surface.get().surface.clone();
    let posed = points(&posed).map_err(|error| exception_of(py, error))?;
    let weights = HandleWeights { matrix: matrix(&weights), figures: Figures::default() };
    let fit = doing(py, move |_| {
        let count = regions.iter().map(|&region| region as usize + 1).max().unwrap_or(1);
        let regions = Regions { of_vertex: regions, count, figures: Figures::default() };
        regions.check(surface.vertex_count())?;
        stage.bind(&surface)?.skin(&weights, &regions)?.fit(&posed)
    })?;
    let rows = fit.transforms.iter().flat_map(|map| map.transpose().as_slice().to_vec());
    let maps: Vec<f64> = rows.collect();
    let shape = vec![fit.transforms.len(), 3, 4];
    Ok((View::numbers(Arc::new(maps), shape, Vec::as_slice), View::points(Arc::new(fit.positions), Vec::as_slice)))
}

/// The pairs of points that a stage proposes, with how sure each is.
#[pyfunction]
pub fn propose(
    py: Python<'_>,
    settings: &str,
    source: &Bound<'_, SurfaceData>,
    target: &Bound<'_, SurfaceData>,
    pairs: Vec<(PointParts, PointParts)>,
) -> PyResult<Vec<(PointParts, PointParts, f64)>> {
    let stage = stage::<dyn Landmarks>(settings).map_err(|wrong| exception(py, &wrong))?;
    let (source, target) = (source.get().surface.clone(), target.get().surface.clone());
    let proposal = doing(py, move |watch| {
        let markers = markers(pairs);
        let pair = TransferPair { source: &source, target: &target, markers: &markers, proximity: None };
        pair.check_markers()?;
        stage.propose_watched(pair, Work::new(&|_| watch.check()))
    })?;
    let found = proposal.pairs.into_iter();
    Ok(found.map(|pair| (parts(pair.marker.source), parts(pair.marker.target), pair.confidence)).collect())
}

/// The links between components: their numbers, their distance and pairs of vertices.
#[pyfunction]
#[expect(clippy::type_complexity, reason = "Python takes the tuples apart")]
pub fn link(
    py: Python<'_>,
    settings: &str,
    surface: &Bound<'_, SurfaceData>,
) -> PyResult<Vec<([u32; 2], f64, Vec<[u32; 2]>)>> {
    let stage = stage::<dyn Proximity>(settings).map_err(|wrong| exception(py, &wrong))?;
    let surface = surface.get().surface.clone();
    let graph = doing(py, move |_| stage.proximity(&surface))?;
    Ok(graph.links().map(|link| (link.components, link.distance, link.pairs.clone())).collect())
}

/// The mesh of a generator.
#[pyfunction]
pub fn generate(py: Python<'_>, settings: &str) -> PyResult<MeshData> {
    let stage = stage::<dyn Generator>(settings).map_err(|wrong| exception(py, &wrong))?;
    doing(py, move |_| stage.make()).map(MeshData::from)
}

/// The points that tell poses best.
#[pyfunction]
pub fn choose(
    py: Python<'_>,
    settings: &str,
    surface: &Bound<'_, SurfaceData>,
    seen_poses: Vec<PyReadonlyArray2<'_, f64>>,
) -> PyResult<Vec<PointParts>> {
    let stage = stage::<dyn KeyPoints>(settings).map_err(|wrong| exception(py, &wrong))?;
    let surface = surface.get().surface.clone();
    let seen = poses(&seen_poses, surface.vertex_count()).map_err(|error| exception_of(py, error))?;
    let chosen = doing(py, move |_| stage.choose(KeyPointsInput { source: &surface, poses: &seen, start: &[] }, &()))?;
    Ok(chosen.points.into_iter().map(parts).collect())
}

/// The statistics of a result (positions of the mesh), as JSON; of the known result and of nothing else.
#[pyfunction]
pub fn measure(
    py: Python<'_>,
    settings: &str,
    rest: &Bound<'_, MeshData>,
    result: PyReadonlyArray2<'_, f64>,
    truth: Option<PyReadonlyArray2<'_, f64>>,
) -> PyResult<String> {
    let stage = stage::<dyn Metric>(settings).map_err(|wrong| exception(py, &wrong))?;
    let sequence = rest.get().sequence.clone();
    let surface = rest.get().surface().map_err(|error| exception_of(py, error))?;
    let result = points(&result).map_err(|error| exception_of(py, error))?;
    let truth = truth.map(|truth| points(&truth)).transpose().map_err(|error| exception_of(py, error))?;
    let figures = doing(py, move |_| {
        let context = MetricContext::alone(&sequence.rest, &surface);
        let on_surface = |positions: &Vec<_>| {
            Error::check_shape("vertices of the result (#V)", sequence.rest.positions.len(), positions.len())?;
            Surface::from_mesh(&surface, positions)
        };
        let seen = on_surface(&result)?;
        let posed = Posed { mesh: &result, surface: &seen };
        let seen_truth = truth.as_ref().map(on_surface).transpose()?;
        let ground_truth = truth.as_ref().zip(seen_truth.as_ref()).map(|(mesh, surface)| Posed { mesh, surface });
        let input = MetricInput { ground_truth, wants_field: false, ..MetricInput::alone(posed) };
        Ok(stage.bind(context)?.measure(input)?.statistics)
    })?;
    Ok(serde_json::to_string(&figures).unwrap_or_default())
}

/// An array as a matrix.
fn matrix(array: &PyReadonlyArray2<'_, f64>) -> DMatrix<f64> {
    let view = array.as_array();
    DMatrix::from_fn(view.nrows(), view.ncols(), |row, column| view[[row, column]])
}
