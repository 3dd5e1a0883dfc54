//! What a run did, for people.

use std::{fmt::Write, path::Path};

use serde_json::{Map, Value};

use crate::text::{bytes, count, number, pairs, seconds, table};
use crate::{
    core::Figures,
    pipeline::{
        compose::{Ended, Results},
        judge::{Level, Reason},
        report::{Headline, MeshFigures, PoseReport, Report, headlines},
    },
};

/// More rows than this are shortened in tables; `run.json` has them all.
const MOST_ROWS: usize = 24;

/// The summary of a run whose report is at `path`.
pub fn of(report: &Report, path: &Path) -> String {
    let mut text = String::new();
    let failed: Vec<_> = report.poses.iter().filter(|pose| pose.error.is_some()).collect();
    let rows = [
        ("source".to_owned(), format!("{}, {}", mesh(&report.source), count(report.poses.len(), "pose", "poses"))),
        ("target".to_owned(), mesh(&report.target)),
        ("markers".to_owned(), report.markers.to_string()),
    ];
    text += &pairs(&rows);
    for stage in &report.stages {
        let name = if stage.name.is_empty() { String::new() } else { format!(" ({})", stage.name) };
        let cpu = stage.cpu_seconds.map(|cpu| format!(", CPU {}", seconds(cpu))).unwrap_or_default();
        let each = match report.poses.len() {
            count if stage.stage == "poses" && count > 1 => {
                format!(", {} a pose", seconds(stage.seconds / count as f64))
            }
            _ => String::new(),
        };
        let kept = match report.poses.iter().filter(|pose| pose.reused).count() {
            count if stage.stage == "poses" && count > 0 => format!(", {count} of {} kept", report.poses.len()),
            _ => String::new(),
        };
        if stage.reused {
            let _ = writeln!(text, "\n{}{name}: kept from an earlier run", stage.stage);
        } else {
            let _ = writeln!(text, "\n{}{name}: {}{cpu}{each}{kept}", stage.stage, seconds(stage.seconds));
        }
        if stage.stage == "correspondence" {
            text += &partners(&stage.figures, report.target.triangles);
        }
        text += &figures(&stage.figures);
        for warning in &stage.figures.warnings {
            let _ = writeln!(text, "  warning: {warning}");
        }
    }
    for (metric, values) in report.metrics.iter().filter(|(metric, _)| *metric == "point_error") {
        let _ = writeln!(text, "\n{metric}, % of the diagonal");
        text += &scores(metric, values, &report.poses);
    }
    text += &verdicts(report);
    if !failed.is_empty() {
        let names: Vec<_> = failed.iter().map(|pose| pose.name.as_str()).collect();
        let _ = writeln!(text, "\nfailed: {} ({} of {})", names.join(", "), failed.len(), report.poses.len());
    }
    text += "\nwritten\n";
    let shown = report.outputs.len().min(MOST_ROWS);
    let mut rows: Vec<_> =
        report.outputs[..shown].iter().map(|file| vec![file.path.display().to_string(), bytes(file.bytes)]).collect();
    if shown < report.outputs.len() {
        rows.push(vec![format!("… and {} more", report.outputs.len() - shown)]);
    }
    rows.push(vec![path.display().to_string()]);
    text += &table(&rows);
    let cpu = report.process.cpu_seconds.map(|cpu| format!(", CPU {}", seconds(cpu))).unwrap_or_default();
    let memory =
        report.process.peak_memory_bytes.map(|peak| format!(", at most {} of memory", bytes(peak))).unwrap_or_default();
    let threads = count(report.threads, "thread", "threads");
    let _ = writeln!(text, "\n{} in {} on {threads}{cpu}{memory}", done(report), seconds(report.seconds));
    text
}

/// The table of the runs of one file.
pub fn of_all(results: &Results) -> String {
    let mut text = table(&results.table());
    let measured =
        results.rows.iter().any(|row| matches!(&row.ended, Ended::Report(report) if !report.metrics.is_empty()));
    if measured {
        text += "  metrics are averages over poses, in their own units (`mimesh show metric TYPE`)\n";
    }
    let ended = |status: &str| results.rows.iter().filter(|row| row.status() == status).count();
    let (done, all) = (ended("done"), results.rows.len());
    let time = seconds(results.rows.iter().map(|row| row.seconds).sum());
    if done == all {
        let _ = writeln!(text, "\n{} done in {time}", count(all, "run", "runs"));
    } else {
        let rest =
            [("with a broken gate", ended("gate")), ("partly done", ended("partly")), ("failed", ended("failed"))];
        let rest: Vec<_> = rest.iter().filter(|(_, n)| *n > 0).map(|(what, n)| format!("{n} {what}")).collect();
        let _ = writeln!(text, "\n{done} of {} done, {}, in {time}", count(all, "run", "runs"), rest.join(", "));
    }
    text
}

/// What is to be said of each pose, with the main figures of the other metrics.
fn verdicts(report: &Report) -> String {
    let columns: Vec<_> =
        headlines(&report.poses).into_iter().filter(|column| column.metric != "point_error").collect();
    let Some(worst) = report.verdict else { return String::new() };
    let mut text = String::new();
    if !columns.is_empty() {
        let names = |part: fn(&Headline) -> &str| columns.iter().map(move |column| part(column).replace('_', " "));
        let mut rows: Vec<Vec<String>> = vec![
            std::iter::once(String::new()).chain(names(|column| &column.metric)).collect(),
            std::iter::once(String::new()).chain(names(|column| &column.figure)).collect(),
        ];
        let row = |pose: &PoseReport| {
            let cell = |column: &Headline| column.of(pose).map_or("-".into(), number);
            std::iter::once(pose.name.clone()).chain(columns.iter().map(cell)).collect()
        };
        rows.extend(report.poses.iter().take(MOST_ROWS).map(row));
        if report.poses.len() > MOST_ROWS {
            rows.push(vec![format!("… {} more", report.poses.len() - MOST_ROWS)]);
        }
        let _ = write!(text, "\nmetrics (`mimesh show metric NAME` tells what they are)\n{}", table(&rows));
    }
    let _ = writeln!(text, "\nverdict: {}", worst.word());
    let told = reasons(report, Level::Doubtful);
    told.iter().take(MOST_ROWS).for_each(|line| text += &format!("  {line}\n"));
    if told.len() > MOST_ROWS {
        let _ = writeln!(text, "  … and {} more", told.len() - MOST_ROWS);
    }
    text
}

/// A line for each pose that is judged `from` or worse, worst first; poses of one and the same fault share a line.
pub fn reasons(report: &Report, from: Level) -> Vec<String> {
    let judged = report.poses.iter().filter_map(|pose| Some((pose, pose.verdict.as_ref()?)));
    let mut told: Vec<_> = judged.filter(|(_, verdict)| verdict.level >= from).collect();
    told.sort_by_key(|(_, verdict)| std::cmp::Reverse(verdict.level));
    let mut lines: Vec<(String, Vec<&str>)> = Vec::new();
    for (pose, verdict) in told {
        let mut reasons: Vec<_> = verdict.reasons.iter().take(3).map(Reason::words).collect();
        if verdict.reasons.len() > reasons.len() {
            reasons.push(format!("and {} more", verdict.reasons.len() - reasons.len()));
        }
        let line = format!("{}: {}", verdict.level.word(), reasons.join("; "));
        match lines.iter_mut().find(|(other, _)| *other == line) {
            Some((_, poses)) => poses.push(&pose.name),
            None => lines.push((line, vec![&pose.name])),
        }
    }
    let named = |(line, poses): (String, Vec<&str>)| match poses.len() {
        count if count == report.poses.len() && count > 1 => format!("all poses, {line}"),
        count if count > 4 => format!("{} and {} more, {line}", poses[..3].join(", "), count - 3),
        _ => format!("{}, {line}", poses.join(", ")),
    };
    lines.into_iter().map(named).collect()
}

/// Scores of poses with their average, in a table of the figures of `metric`.
pub fn scores(metric: &str, summary: &Value, poses: &[PoseReport]) -> String {
    let figures_of = |pose: &PoseReport| pose.metrics.get(metric).and_then(Value::as_object).cloned();
    let scored: Vec<(&str, Map<String, Value>)> =
        poses.iter().filter_map(|pose| Some((pose.name.as_str(), figures_of(pose)?))).collect();
    let mut columns: Vec<&String> = Vec::new();
    for key in scored.iter().flat_map(|(_, figures)| figures.keys()) {
        // Counts that say nothing are left out of the table.
        let telling =
            scored.iter().any(|(_, f)| f.get(key).is_some_and(|v| v.is_f64() || v.as_f64().is_some_and(|v| v != 0.0)));
        if telling && key != "vertices" && key != "warnings" && !columns.contains(&key) {
            columns.push(key);
        }
    }
    let row = |name: &str, figures: &Map<String, Value>| -> Vec<String> {
        let cell =
            |key: &&String| figures.get(*key).and_then(Value::as_f64).map_or("-".into(), |value| format!("{value:.3}"));
        std::iter::once(name.to_owned()).chain(columns.iter().map(cell)).collect()
    };
    let mut rows = vec![std::iter::once(String::new()).chain(columns.iter().map(|key| key.to_string())).collect()];
    rows.extend(scored.iter().take(MOST_ROWS).map(|(name, figures)| row(name, figures)));
    if scored.len() > MOST_ROWS {
        rows.push(vec![format!("… {} more", scored.len() - MOST_ROWS)]);
    }
    for (key, name) in [("average", "average"), ("worst", "worst"), ("nothing", "doing nothing")] {
        if let Some(figures) = summary.get(key).and_then(Value::as_object).filter(|figures| !figures.is_empty()) {
            rows.push(row(name, figures));
        }
    }
    table(&rows)
}

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

fn partners(figures: &Figures, triangles: usize) -> String {
    let orphans = figures.number("orphans").unwrap_or_default() as usize;
    let found = triangles.saturating_sub(orphans);
    let share = 100.0 * found as f64 / triangles.max(1) as f64;
    format!("  partners found for {found} of {triangles} target triangles ({share:.1} %)\n")
}

fn figures(figures: &Figures) -> String {
    let shown = figures.values.iter().filter(|(name, _)| *name != "orphans");
    let rows: Vec<_> = shown.map(|(name, value)| (name.replace('_', " "), figure(value))).collect();
    pairs(&rows)
}

fn figure(value: &Value) -> String {
    match value {
        Value::Number(n) => n.as_u64().map(|n| n.to_string()).or(n.as_f64().map(number)).unwrap_or_default(),
        Value::String(text) => text.clone(),
        Value::Array(list) => list.iter().map(figure).collect::<Vec<_>>().join("  "),
        Value::Object(map) => {
            map.iter().map(|(key, value)| format!("{key} {}", figure(value))).collect::<Vec<_>>().join(", ")
        }
        other => other.to_string(),
    }
}

fn done(report: &Report) -> String {
    let failed = report.poses.iter().filter(|pose| pose.error.is_some()).count();
    match failed {
        0 => "done".into(),
        _ => format!("partly done ({failed} of {} poses failed)", report.poses.len()),
    }
}
