//! Pipelines: checked, planned and run.

use std::time::Instant;

use mimesh_document::{Diagnostic, diagnostic::Result};
use mimesh_pipeline::{
    Finished, Plan, Prepared,
    cache::Cache,
    report::{Results, Row, RunOutcome},
    run as run_one,
};
use pyo3::prelude::*;
use serde_json::{Value, json};

use crate::{
    error::{self, exception},
    job::{Job, keep},
    mesh::MeshData,
    work::{self, Watch},
};

/// Meshes of memory with the names that the text of a pipeline gives them.
type Meshes = Vec<(String, Py<MeshData>)>;

/// What is wrong with a pipeline, as JSON.
#[pyfunction]
pub fn check(py: Python<'_>, job: &str, meshes: Meshes) -> PyResult<String> {
    let job = Job::new(job).map_err(|failure| exception(py, &failure))?;
    let kept = keep(py, &meshes);
    let wrong = work::run(py, None, move |_| {
        let _kept = kept;
        job.cache().and_then(|cache| job.prepare(cache.as_ref())).err().unwrap_or_default()
    })?;
    Ok(error::json(&wrong).to_string())
}

/// The plan of each run of a pipeline, as JSON.
#[pyfunction]
pub fn plan(py: Python<'_>, job: &str, meshes: Meshes) -> PyResult<String> {
    let job = Job::new(job).map_err(|failure| exception(py, &failure))?;
    let kept = keep(py, &meshes);
    let planned = work::run(py, None, move |_| {
        let _kept = kept;
        let cache = job.cache()?;
        let all = job.prepare(cache.as_ref())?;
        let named =
            |prepared: &Prepared| json!({ "run": prepared.variant.name, "plan": Plan::new(prepared, cache.as_ref()) });
        Ok(Value::from(all.iter().map(named).collect::<Vec<_>>()).to_string())
    })?;
    planned.map_err(|failure| exception(py, &failure))
}

/// Runs a pipeline. The results are as JSON those of `mimesh run --json` for several runs, beside the poses that failed.
#[pyfunction]
pub fn run(py: Python<'_>, job: &str, meshes: Meshes, progress: Option<Py<PyAny>>) -> PyResult<String> {
    let job = Job::new(job).map_err(|failure| exception(py, &failure))?;
    let kept = keep(py, &meshes);
    let results = work::run(py, progress.as_ref(), move |watch| {
        let _kept = kept;
        let cache = job.cache()?;
        let all = job.prepare(cache.as_ref())?;
        run_all(&job, &all, cache.as_ref(), watch).map(|(results, failed)| as_json(&results, failed))
    })?;
    results.map(|results| results.to_string()).map_err(|failure| exception(py, &failure))
}

/// Runs everything that is prepared; a run that fails does not stop the others, unless it is the only one.
fn run_all(job: &Job, all: &[Prepared], cache: Option<&Cache>, watch: &Watch) -> Result<(Results, Vec<Diagnostic>)> {
    let mut results = Results { pipeline: job.file.clone(), rows: vec![] };
    let mut failed_poses = vec![];
    for prepared in all {
        watch.check();
        let started = Instant::now();
        let finished = run_one(prepared, &Plan::new(prepared, cache), job.threads, cache, watch);
        let outcome = match finished {
            Ok(Finished { report, failed }) => {
                failed_poses.extend(failed);
                RunOutcome::Report(Box::new(report))
            }
            Err(failure) if all.len() == 1 => return Err(failure),
            Err(failure) => {
                let named = |diagnostic: Diagnostic| diagnostic.doing(&prepared.variant.name);
                RunOutcome::Failed(failure.list.into_iter().map(named).collect())
            }
        };
        results.rows.push(Row {
            variant: prepared.variant.clone(),
            place: prepared.outputs.report.clone(),
            outcome,
            seconds: started.elapsed().as_secs_f64() + prepared.seconds(),
        });
    }
    Ok((results, failed_poses))
}

fn as_json(results: &Results, failed_poses: Vec<Diagnostic>) -> Value {
    let runs = results.rows.iter().map(|row| match &row.outcome {
        RunOutcome::Report(report) => json!({ "name": row.variant.name, "report": report }),
        RunOutcome::Failed(diagnostics) => {
            json!({ "name": row.variant.name, "diagnostics": error::json(&diagnostics.clone().into()) })
        }
    });
    json!({
        "status": results.status(),
        "runs": runs.collect::<Vec<_>>(),
        "table": results.table(),
        "failed_poses": error::json(&failed_poses.into()),
    })
}
