//! The summary of a run, and the table of several runs, as text.

use std::{fmt::Write, path::Path};

use mimesh_pipeline::{
    choices,
    report::{MeshFigures, PartReport, PoseReport, Report, Results, RunOutcome},
    text::{bytes, count, pairs, seconds, table},
};
use serde_json::{Map, Value};

mod stages;
mod verdicts;

pub use verdicts::reasons;

/// The largest number of rows in a table. `run.json` has all of them.
const MAX_ROWS: usize = 24;

/// The summary of a run whose report is at `path`.
pub fn of_run(report: &Report, path: &Path) -> String {
    let poses = match &report.part {
        Some(part) => poses_of_part(part),
        None => count(report.poses.len(), "pose", "poses"),
    };
    let rows = [
        ("source".to_owned(), format!("{}, {poses}", mesh(&report.source))),
        ("target".to_owned(), mesh(&report.target)),
        ("markers".to_owned(), report.markers.to_string()),
    ];
    let mut text = pairs(&rows);
    if !report.choices.is_empty() {
        text += &format!("\nchosen by the meshes\n{}", choices::rows(&report.choices));
    }
    report.stages.iter().for_each(|step| text += &stages::stage(step, report));
    if let Some(values) = report.metrics.get("point_error") {
        text += &format!("\npoint_error, % of the diagonal\n{}", scores("point_error", values, &report.poses));
    }
    text += &verdicts::verdicts(report);
    let failed: Vec<_> = report.poses.iter().filter(|pose| pose.error.is_some()).map(|pose| &*pose.name).collect();
    if !failed.is_empty() {
        text += &format!("\nfailed: {} ({} of {})\n", failed.join(", "), failed.len(), report.poses.len());
    }
    text += &written(report, path);
    let cpu = report.process.cpu_seconds.map(|cpu| format!(", CPU {}", seconds(cpu))).unwrap_or_default();
    let memory =
        report.process.peak_memory_bytes.map(|peak| format!(", at most {} of memory", bytes(peak))).unwrap_or_default();
    let threads = count(report.threads, "thread", "threads");
    text + &format!("\n{} in {} on {threads}{cpu}{memory}\n", status(report), seconds(report.seconds))
}

/// The poses of a part of a run.
fn poses_of_part(part: &PartReport) -> String {
    let shard = part.shard.as_ref().map(|shard| format!("shard {shard}, ")).unwrap_or_default();
    match part.poses {
        0 => format!("{shard}which has none of {}", count(part.of, "pose", "poses")),
        _ => format!("{shard}frames {} of {}", part.frames, count(part.of, "pose", "poses")),
    }
}

/// The written files with their sizes; the report, at `path`, is the last.
fn written(report: &Report, path: &Path) -> String {
    let shown = report.outputs.len().min(MAX_ROWS);
    let mut rows: Vec<_> =
        report.outputs[..shown].iter().map(|file| vec![file.path.display().to_string(), bytes(file.bytes)]).collect();
    if shown < report.outputs.len() {
        rows.push(vec![format!("… and {} more", report.outputs.len() - shown)]);
    }
    // A part leaves the report to the merge.
    if report.part.is_none() {
        rows.push(vec![path.display().to_string()]);
    }
    if rows.is_empty() { String::new() } else { format!("\nwritten\n{}", table(&rows)) }
}

/// The table of all runs of a pipeline, with a line on how they ended.
pub fn of_runs(results: &Results) -> String {
    let mut text = table(&results.table());
    let measured =
        results.rows.iter().any(|row| matches!(&row.outcome, RunOutcome::Report(report) if !report.metrics.is_empty()));
    if measured {
        text += "  metrics are averages over poses, in their own units (`mimesh show metric TYPE`)\n";
    }
    let (done, all) = (count_status(results, "done"), results.rows.len());
    let time = seconds(results.rows.iter().map(|row| row.seconds).sum());
    if done == all {
        let _ = writeln!(text, "\n{} done in {time}", count(all, "run", "runs"));
    } else {
        let others = [("gate", "with a broken gate"), ("partly", "partly done"), ("failed", "failed")];
        let others = others.map(|(status, words)| (count_status(results, status), words));
        let others: Vec<_> = others.iter().filter(|(n, _)| *n > 0).map(|(n, words)| format!("{n} {words}")).collect();
        let _ = writeln!(text, "\n{done} of {} done, {}, in {time}", count(all, "run", "runs"), others.join(", "));
    }
    text
}

/// The number of runs that ended with `status`.
fn count_status(results: &Results, status: &str) -> usize {
    results.rows.iter().filter(|row| row.status() == status).count()
}

/// A table of the statistics of `metric`, with a row for each pose, the average, the worst and the mesh at rest.
pub fn scores(metric: &str, summary: &Value, poses: &[PoseReport]) -> String {
    let scored: Vec<(&str, Map<String, Value>)> =
        poses.iter().filter_map(|pose| Some((pose.name.as_str(), pose.metrics.get(metric)?))).collect();
    let mut columns: Vec<&String> = Vec::new();
    for key in scored.iter().flat_map(|(_, statistics)| statistics.keys()) {
        // The table leaves out counts that are 0 everywhere.
        let is_shown = scored.iter().any(|(_, statistics)| statistics.get(key).is_some_and(is_informative));
        if is_shown && key != "vertices" && key != "warnings" && !columns.contains(&key) {
            columns.push(key);
        }
    }
    let row = |name: &str, statistics: &Map<String, Value>| -> Vec<String> {
        let cell = |key: &&String| {
            statistics.get(*key).and_then(Value::as_f64).map_or("-".into(), |value| format!("{value:.3}"))
        };
        std::iter::once(name.to_owned()).chain(columns.iter().map(cell)).collect()
    };
    let mut rows = vec![std::iter::once(String::new()).chain(columns.iter().map(|key| key.to_string())).collect()];
    rows.extend(scored.iter().take(MAX_ROWS).map(|(name, statistics)| row(name, statistics)));
    if scored.len() > MAX_ROWS {
        rows.push(vec![format!("… {} more", scored.len() - MAX_ROWS)]);
    }
    for (key, name) in [("average", "average"), ("worst", "worst"), ("nothing", "doing nothing")] {
        if let Some(statistics) = summary.get(key).and_then(Value::as_object).filter(|values| !values.is_empty()) {
            rows.push(row(name, statistics));
        }
    }
    table(&rows)
}

/// Whether a value is more than a count of 0.
fn is_informative(value: &Value) -> bool {
    value.is_f64() || value.as_f64().is_some_and(|value| value != 0.0)
}

/// The sizes of a mesh.
fn mesh(figures: &MeshFigures) -> String {
    let mut text = format!(
        "{}, {}",
        count(figures.vertices, "vertex", "vertices"),
        count(figures.polygons, "polygon", "polygons")
    );
    if figures.components != 1 {
        text += &format!(", {}", count(figures.components, "component", "components"));
    }
    if figures.welded_vertices != figures.vertices {
        text += &format!(", {} after welding seams", count(figures.welded_vertices, "vertex", "vertices"));
    }
    text
}

/// How the run ended.
fn status(report: &Report) -> String {
    let failed = report.poses.iter().filter(|pose| pose.error.is_some()).count();
    match failed {
        0 => "done".into(),
        _ => format!("partly done ({failed} of {} poses failed)", report.poses.len()),
    }
}
