//! Transfers whose results stay in memory.

use std::{borrow::Cow, path::PathBuf, sync::Arc};

use mimesh_core::mesh::{ClipTime, MeshSequence};
use mimesh_document::{Diagnostic, Kind};
use mimesh_pipeline::{Finished, Plan, run};
use nalgebra::Point3;
use pyo3::prelude::*;
use serde_json::json;

use crate::{
    array::View,
    error::{self, exception, exception_of},
    in_memory::{Collected, Collector, EXTENSION},
    job::{Job, keep},
    mesh::MeshData,
    save::{SavedPose, save},
    work,
};

/// The poses of a target.
#[pyclass(frozen)]
pub struct TransferData {
    target: Arc<MeshSequence>,
    names: Vec<String>,
    times: Vec<Option<ClipTime>>,
    positions: Arc<Vec<f64>>,
    report: String,
}

impl TransferData {
    fn saved_poses(&self) -> Vec<SavedPose<'_>> {
        let length = self.target.rest.positions.len() * 3;
        let poses = self.names.iter().zip(&self.times).zip(self.positions.chunks_exact(length));
        let saved = poses.map(|((name, time), positions)| SavedPose {
            name,
            time: time.as_ref(),
            positions: Box::new(move || {
                let points = positions.chunks_exact(3).map(|p| Point3::new(p[0], p[1], p[2]));
                Ok(Cow::Owned(points.collect()))
            }),
        });
        saved.collect()
    }
}

#[pymethods]
impl TransferData {
    /// The names of the poses.
    fn names(&self) -> Vec<String> {
        self.names.clone()
    }

    /// The positions of all poses, p × n × 3.
    fn positions(&self) -> View {
        let shape = vec![self.names.len(), self.target.rest.positions.len(), 3];
        View::numbers(self.positions.clone(), shape, Vec::as_slice)
    }

    /// The report of the run and the poses that failed, as JSON.
    fn report(&self) -> &str {
        &self.report
    }

    /// The target at rest.
    fn target(&self) -> MeshData {
        self.target.clone().into()
    }

    /// Writes the target with its new poses.
    fn save(slf: Py<Self>, py: Python<'_>, path: PathBuf) -> PyResult<Vec<PathBuf>> {
        let own = slf.clone_ref(py);
        let written = work::run(py, None, move |_| save(&path, &own.get().target.rest, &own.get().saved_poses()))?;
        written.map_err(|failure| exception(py, &failure))
    }
}

/// Runs a pipeline of one run whose output is `EXTENSION`, and keeps its results in memory.
#[pyfunction]
pub fn transfer(
    py: Python<'_>,
    job: &str,
    meshes: Vec<(String, Py<MeshData>)>,
    progress: Option<Py<PyAny>>,
) -> PyResult<TransferData> {
    let mut job = Job::new(job).map_err(|failure| exception(py, &failure))?;
    let kept = keep(py, &meshes);
    let collector = Collector::new();
    job.set.push(format!("output=[result.{EXTENSION}]"));
    job.set.push(format!("formats=[{{ type: in_memory, call: {} }}]", collector.call));
    let result = work::run(py, progress.as_ref(), move |watch| {
        let _kept = kept;
        let cache = job.cache()?;
        let all = job.prepare(cache.as_ref())?;
        let [prepared] = &all[..] else {
            let message = format!("{} runs, expected one", all.len());
            return Err(Diagnostic::new(Kind::Usage, message).hint("transfer to one target after the other").into());
        };
        watch.check();
        let plan = Plan::new(prepared, cache.as_ref());
        let Finished { report, failed } = run(prepared, &plan, job.threads, cache.as_ref(), watch)?;
        let Collected { names, times, positions } = collector.take();
        let target = MeshSequence { rest: prepared.target.sequence.rest.clone(), ..MeshSequence::default() };
        let report = json!({ "report": report, "failed_poses": error::json(&failed.into()) });
        let (target, positions) = (Arc::new(target), Arc::new(positions));
        Ok(TransferData { target, names, times, positions, report: report.to_string() })
    })?;
    let data = result.map_err(|failure| exception(py, &failure))?;
    let expected = data.names.len() * data.target.rest.positions.len() * 3;
    mimesh_core::Error::check_shape("numbers of all poses", expected, data.positions.len())
        .map_err(|error| exception_of(py, error))?;
    Ok(data)
}
