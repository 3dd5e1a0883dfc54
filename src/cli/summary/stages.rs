//! Stages in the summary of a run: their times, figures and warnings.

use mimesh_core::Figures;
use mimesh_pipeline::{
    report::{Report, StageReport},
    text::{number, pairs, seconds},
};
use serde_json::Value;

/// The time of a stage, its figures and its warnings.
pub fn stage(stage: &StageReport, report: &Report) -> String {
    let name = if stage.name.is_empty() { String::new() } else { format!(" ({})", stage.name) };
    let mut text = if stage.reused {
        format!("\n{}{name}: cached by an earlier run\n", stage.stage)
    } else {
        let cpu = stage.cpu_seconds.map(|cpu| format!(", CPU {}", seconds(cpu))).unwrap_or_default();
        let poses = if stage.stage == "poses" { time_and_cache_of_poses(stage, report) } else { String::new() };
        format!("\n{}{name}: {}{cpu}{poses}\n", stage.stage, seconds(stage.seconds))
    };
    if stage.stage == "correspondence" {
        text += &correspondence(&stage.figures, report.target.triangles);
    }
    text += &figures(&stage.figures);
    for warning in &stage.figures.warnings {
        text += &format!("  warning: {warning}\n");
    }
    text
}

/// The time of one of several poses, and the number of poses from the cache.
fn time_and_cache_of_poses(stage: &StageReport, report: &Report) -> String {
    let (all, cached) = (report.poses.len(), report.poses.iter().filter(|pose| pose.reused).count());
    let mut text = String::new();
    if all > 1 {
        text += &format!(", {} a pose", seconds(stage.seconds / all as f64));
    }
    if cached > 0 {
        text += &format!(", {cached} of {all} cached");
    }
    text
}

/// The share of target triangles that correspond to triangles of the source.
fn correspondence(figures: &Figures, triangles: usize) -> String {
    let orphans = figures.number("orphans").unwrap_or_default() as usize;
    let found = triangles.saturating_sub(orphans);
    let share = 100.0 * found as f64 / triangles.max(1) as f64;
    format!("  correspondence found for {found} of {triangles} target triangles ({share:.1} %)\n")
}

/// The figures of a stage, a row each.
fn figures(figures: &Figures) -> String {
    let shown = figures.values.iter().filter(|(name, _)| *name != "orphans");
    let rows: Vec<_> = shown.map(|(name, value)| (name.replace('_', " "), figure(value))).collect();
    pairs(&rows)
}

/// A value in a line.
fn figure(value: &Value) -> String {
    match value {
        Value::Number(n) => n.as_u64().map(|n| n.to_string()).or(n.as_f64().map(number)).unwrap_or_default(),
        Value::String(text) => text.clone(),
        Value::Array(items) => items.iter().map(figure).collect::<Vec<_>>().join("  "),
        Value::Object(entries) => {
            entries.iter().map(|(key, value)| format!("{key} {}", figure(value))).collect::<Vec<_>>().join(", ")
        }
        other => other.to_string(),
    }
}
