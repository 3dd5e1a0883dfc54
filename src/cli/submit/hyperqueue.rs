//! HyperQueue: a job file whose tasks depend on one another.

use mimesh_document::{Diagnostic, Kind, diagnostic::Result};
use serde::Serialize;

use super::{files::JobFile, job::Job};
use crate::cli::help_commands::in_quotes as quoted;

/// The name of the job file.
const JOB_FILE: &str = "job.toml";

/// A job file.
#[derive(Serialize)]
struct File<'a> {
    name: &'a str,
    task: Vec<Entry>,
}

/// A task of it.
#[derive(Serialize)]
struct Entry {
    id: usize,
    command: Vec<String>,
    /// The tasks before it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    deps: Vec<usize>,
    cwd: String,
}

/// The job file: stages that run once, then the parts of each run, then its results.
///
/// # Errors
///
/// A diagnostic if the job cannot be told as TOML.
pub fn files(job: &Job) -> Result<Vec<JobFile>> {
    let mut entries: Vec<Entry> = Vec::new();
    for run in 0..job.runs.len() {
        let mut add = |command: Vec<String>, deps: Vec<usize>| {
            let id = entries.len();
            entries.push(Entry { id, command, deps, cwd: job.folder.clone() });
            id
        };
        let prepare = add(job.prepare(run), vec![]);
        let tasks = job.tasks().filter(|task| task.run == run);
        let parts: Vec<usize> = tasks.map(|task| add(job.transfer(task), vec![prepare])).collect();
        add(job.merge(run), parts);
    }
    let text = toml::to_string(&File { name: &job.name, task: entries })
        .map_err(|error| Diagnostic::new(Kind::Internal, format!("the job file: {error}")))?;
    Ok(vec![JobFile::data(JOB_FILE, text)])
}

/// How to go on.
pub fn next(folder: &str) -> String {
    format!("submit it: hq job submit-file {}\n", quoted(&format!("{folder}/{JOB_FILE}")))
}
