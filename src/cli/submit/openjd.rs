//! Open Job Description 2023-09: a template with three steps for each group of runs with equally many poses.

use std::collections::BTreeMap;

use mimesh_document::{Diagnostic, Kind, diagnostic::Result};
use serde_json::{Value, json};

use super::{
    files::JobFile,
    job::{Job, RunOfJob},
};
use crate::cli::help_commands::in_quotes;

/// The name of the template, as bundles of jobs have it.
const TEMPLATE: &str = "template.json";

/// The most values of a parameter that the specification allows.
const MAX_VALUES: usize = 1024;

/// The longest name of a job that the specification allows.
const MAX_NAME: usize = 128;

/// The template.
///
/// # Errors
///
/// A diagnostic for words that mean something else in a template.
pub fn files(job: &Job) -> Result<Vec<JobFile>> {
    let words = job.options.iter().chain(job.runs.iter().map(|run| &run.name));
    for word in words.chain([&job.program, &job.pipeline, &job.cache]) {
        if word.contains("{{") {
            let message = format!("`{word}` has `{{{{`, which names a value in Open Job Description");
            return Err(Diagnostic::new(Kind::Usage, message).hint("rename it, or use --to shell, slurm or hq").into());
        }
    }
    let groups = groups(&job.runs);
    let mut steps = Vec::new();
    for (number, runs) in groups.iter().enumerate() {
        let of_group = if groups.len() > 1 { format!(" {}", number + 1) } else { String::new() };
        let name = |step: &str| format!("{step}{of_group}");
        let after = |step: &str| json!([{ "dependsOn": name(step) }]);
        steps.push(step(name("Prepare"), runs, None, None, command("prepare", job, runs, &[])));
        let mut transfer = runs[0].warm_options();
        transfer.extend(["--frames".into(), "{{Task.Param.Frame}}".into()]);
        let transfer = command("run", job, runs, &transfer);
        steps.push(step(name("Transfer"), runs, Some(frames(job, runs[0])), Some(after("Prepare")), transfer));
        let merge = command("merge", job, runs, &runs[0].warm_options());
        steps.push(step(name("Merge"), runs, None, Some(after("Transfer")), merge));
    }
    let template = json!({
        "specificationVersion": "jobtemplate-2023-09",
        "extensions": ["TASK_CHUNKING"],
        "name": job_name(&job.name),
        "parameterDefinitions": [
            { "name": "Mimesh", "type": "STRING", "default": job.program, "description": "The program mimesh." },
            {
                "name": "Pipeline", "type": "PATH", "objectType": "FILE", "dataFlow": "IN", "default": job.pipeline,
                "description": "The pipeline's YAML file.",
            },
            {
                "name": "Cache", "type": "PATH", "objectType": "DIRECTORY", "dataFlow": "INOUT", "default": job.cache,
                "description": "The folder of results that all tasks share.",
            },
            {
                "name": "ChunkSize", "type": "INT", "minValue": 1, "default": job.chunk,
                "description": "The most poses of a task.",
            },
        ],
        "steps": steps,
    });
    Ok(vec![JobFile::data(TEMPLATE, format!("{template:#}\n"))])
}

/// How to go on.
pub fn next(folder: &str) -> String {
    let folder = in_quotes(&format!("{folder}/{TEMPLATE}"));
    format!("look at it: openjd check {folder}\nrun it here: openjd run {folder}\n")
}

/// Runs whose poses are split alike, since the tasks of a step are all combinations of runs and parts; runs without poses have none.
fn groups(runs: &[RunOfJob]) -> Vec<Vec<&RunOfJob>> {
    let mut by_parts: BTreeMap<_, Vec<&RunOfJob>> = BTreeMap::new();
    for run in runs.iter().filter(|run| run.poses > 0) {
        by_parts.entry((run.poses, run.chunk, run.warm)).or_default().push(run);
    }
    by_parts.into_values().flat_map(|runs| runs.chunks(MAX_VALUES).map(<[_]>::to_vec).collect::<Vec<_>>()).collect()
}

/// The parameter of a task that has its frames.
fn frames(job: &Job, run: &RunOfJob) -> Value {
    let chunk = if run.chunk == job.chunk { json!("{{Param.ChunkSize}}") } else { json!(run.chunk) };
    json!({
        "name": "Frame",
        "type": "CHUNK[INT]",
        "range": format!("0-{}", run.poses - 1),
        "chunks": { "defaultTaskCount": chunk, "rangeConstraint": "CONTIGUOUS" },
    })
}

/// A step whose tasks are runs, or runs and `frames` of them.
fn step(name: String, runs: &[&RunOfJob], frames: Option<Value>, dependencies: Option<Value>, on_run: Value) -> Value {
    let mut parameters = Vec::new();
    if has_names(runs) {
        let names: Vec<&String> = runs.iter().map(|run| &run.name).collect();
        parameters.push(json!({ "name": "Run", "type": "STRING", "range": names }));
    }
    parameters.extend(frames);
    let mut step = json!({ "name": name });
    if let Some(dependencies) = dependencies {
        step["dependencies"] = dependencies;
    }
    if !parameters.is_empty() {
        step["parameterSpace"] = json!({ "taskParameterDefinitions": parameters });
    }
    step["script"] = json!({ "actions": { "onRun": on_run } });
    step
}

/// The action that runs a subcommand for one run.
fn command(subcommand: &str, job: &Job, runs: &[&RunOfJob], more: &[String]) -> Value {
    let mut words = vec![subcommand.to_owned(), "{{Param.Pipeline}}".into()];
    if has_names(runs) {
        words.push("--run={{Task.Param.Run}}".into());
    }
    words.extend(more.iter().cloned());
    words.extend(["--cache", "{{Param.Cache}}", "--quiet", "--progress", "openjd"].map(str::to_owned));
    words.extend(job.options.iter().cloned());
    json!({ "command": "{{Param.Mimesh}}", "args": words })
}

/// Whether runs have names, as those of several targets do.
fn has_names(runs: &[&RunOfJob]) -> bool {
    runs.iter().any(|run| !run.name.is_empty())
}

/// A name that the specification allows: of at most 128 characters, none of them to control a terminal.
fn job_name(name: &str) -> String {
    name.replace("{{", "{ {").chars().filter(|c| !c.is_control()).take(MAX_NAME).collect()
}
