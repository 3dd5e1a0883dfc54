//! The summary of a run, and the table of several runs, as text.

use std::{fmt::Write, path::Path};

use mimesh_core::Figures;
use mimesh_pipeline::{
    choices,
    metrics::{Level, PrimaryStatistic, Reason, Verdict, faults, primary_statistics},
    report::{MeshFigures, PartReport, PoseReport, Report, Results, RunOutcome, StageReport},
    text::{bytes, count, number, pairs, seconds, table},
};
use serde_json::{Map, Value};

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
    report.stages.iter().for_each(|step| text += &stage(step, report));
    if let Some(values) = report.metrics.get("point_error") {
        text += &format!("\npoint_error, % of the diagonal\n{}", scores("point_error", values, &report.poses));
    }
    text += &verdicts(report);
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

/// The time of a stage, its figures and its warnings.
fn stage(stage: &StageReport, report: &Report) -> String {
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

/// The verdict with its reasons, after a table of the primary statistics of all metrics but `point_error`.
fn verdicts(report: &Report) -> String {
    let statistics = primary_statistics(&report.poses).into_iter().filter(|column| column.metric != "point_error");
    let (shared, columns): (Vec<_>, Vec<_>) = statistics.partition(PrimaryStatistic::is_of_rest);
    let Some(worst) = report.verdict else { return String::new() };
    let mut text = String::new();
    if !columns.is_empty() {
        let metrics = columns.iter().map(|column| column.metric.replace('_', " "));
        let statistics = columns.iter().map(|column| column.statistic.replace('_', " "));
        let mut rows: Vec<Vec<String>> = vec![
            std::iter::once(String::new()).chain(metrics).collect(),
            std::iter::once(String::new()).chain(statistics).collect(),
        ];
        let row = |pose: &PoseReport| {
            let cell = |column: &PrimaryStatistic| column.of(pose).map_or("-".into(), number);
            std::iter::once(pose.name.clone()).chain(columns.iter().map(cell)).collect()
        };
        rows.extend(report.poses.iter().take(MAX_ROWS).map(row));
        if report.poses.len() > MAX_ROWS {
            rows.push(vec![format!("… {} more", report.poses.len() - MAX_ROWS)]);
        }
        let _ = write!(text, "\nmetrics (`mimesh show metric NAME` explains them)\n{}", table(&rows));
    }
    let value = |column: &PrimaryStatistic| report.poses.iter().find_map(|pose| column.of(pose));
    let name = |column: &PrimaryStatistic| format!("{} {}", column.metric, column.statistic).replace('_', " ");
    let rows: Vec<_> = shared.iter().filter_map(|column| Some((name(column), number(value(column)?)))).collect();
    if !rows.is_empty() {
        let _ = write!(text, "\nmap and markers, the same for all poses\n{}", pairs(&rows));
    }
    let _ = writeln!(text, "\nverdict: {}", worst.word());
    let lines = reasons(report, Level::Doubtful);
    lines.iter().take(MAX_ROWS).for_each(|line| text += &format!("  {line}\n"));
    if lines.len() > MAX_ROWS {
        let _ = writeln!(text, "  … and {} more", lines.len() - MAX_ROWS);
    }
    let of_metrics = faults(report.verdicts()).into_iter();
    let of_metrics = of_metrics.map(|(metric, fault)| (metric.replace('_', " "), fault.to_owned()));
    let meaning: Vec<_> = if worst == Level::Good { vec![] } else { of_metrics.chain(help(report)).collect() };
    if !meaning.is_empty() {
        let _ = write!(text, "\nwhat that means\n{}", pairs(&meaning));
    }
    text
}

/// What helps where a verdict is not good: better landmarks, if a stage proposed them, and the page, if there is none.
fn help(report: &Report) -> Vec<(String, String)> {
    let mut help = Vec::new();
    if !report.proposed_markers.is_empty() {
        let landmarks = "`mimesh markers propose SOURCE TARGET` draws them on both meshes and writes them to be corrected; `mimesh markers \
                         suggest` names the point whose click helps most";
        help.push(("landmarks".into(), landmarks.into()));
    }
    if !report.outputs.iter().any(|file| file.path.extension().is_some_and(|extension| extension == "html")) {
        let page = "a `.html` among the outputs (`-o FILE.html`) colours on each pose where that is";
        help.push(("page".into(), page.into()));
    }
    help
}

/// A line for map and markers and one for each pose, if the verdict on them is `level` or worse; poses come the worst first.
///
/// Poses with the same reasons share a line, with the worst values.
pub fn reasons(report: &Report, level: Level) -> Vec<String> {
    let of_rest = report.rest_verdict.as_ref().filter(|verdict| verdict.level >= level);
    of_rest
        .map(|verdict| format!("map and markers, {}", line(verdict)))
        .into_iter()
        .chain(of_poses(report, level))
        .collect()
}

/// How many reasons a line has.
const MAX_REASONS: usize = 3;

/// The level of a verdict and its first reasons.
fn line(verdict: &Verdict) -> String {
    line_of(verdict.level, verdict.reasons.iter().map(Reason::words).collect())
}

fn line_of(level: Level, mut reasons: Vec<String>) -> String {
    let more = reasons.len().saturating_sub(MAX_REASONS);
    reasons.truncate(MAX_REASONS);
    if more > 0 {
        reasons.push(format!("and {more} more"));
    }
    format!("{}: {}", level.word(), reasons.join("; "))
}

/// The line of verdicts with the same reasons: the worst value of each.
fn line_of_all(verdicts: &[&Verdict]) -> String {
    let Some(first) = verdicts.first() else { return String::new() };
    let worst = |k: usize| {
        let all = verdicts.iter().map(|verdict| &verdict.reasons[k]);
        let worst = all.clone().reduce(|worst, one| if one.excess() > worst.excess() { one } else { worst });
        let worst = worst.unwrap_or(&first.reasons[k]);
        let is_one = all.clone().all(|one| one.words() == worst.words());
        if is_one { worst.words() } else { worst.words_of_worst() }
    };
    line_of(first.level, (0..first.reasons.len()).map(worst).collect())
}

/// Whether two verdicts find the same things wrong.
fn are_alike(a: &Verdict, b: &Verdict) -> bool {
    let same = |(a, b): (&Reason, &Reason)| (&a.metric, &a.statistic, a.level) == (&b.metric, &b.statistic, b.level);
    a.level == b.level && a.reasons.len() == b.reasons.len() && a.reasons.iter().zip(&b.reasons).all(same)
}

/// The lines of [`reasons`] for poses.
fn of_poses(report: &Report, level: Level) -> Vec<String> {
    let verdicts = report.poses.iter().filter_map(|pose| Some((pose, pose.verdict.as_ref()?)));
    let mut verdicts: Vec<_> = verdicts.filter(|(_, verdict)| verdict.level >= level).collect();
    verdicts.sort_by_key(|(_, verdict)| std::cmp::Reverse(verdict.level));
    let mut groups: Vec<(Vec<&Verdict>, Vec<&str>)> = Vec::new();
    for (pose, verdict) in verdicts {
        match groups.iter_mut().find(|(others, _)| are_alike(others[0], verdict)) {
            Some((others, poses)) => {
                others.push(verdict);
                poses.push(&pose.name);
            }
            None => groups.push((vec![verdict], vec![&pose.name])),
        }
    }
    let lines = groups.into_iter().map(|(verdicts, poses)| (line_of_all(&verdicts), poses));
    let named = |(line, poses): (String, Vec<&str>)| match poses.len() {
        count if count == report.poses.len() && count > 1 => format!("all poses, {line}"),
        count if count > 4 => format!("{} and {} more, {line}", poses[..3].join(", "), count - 3),
        _ => format!("{}, {line}", poses.join(", ")),
    };
    lines.map(named).collect()
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

/// How the run ended.
fn status(report: &Report) -> String {
    let failed = report.poses.iter().filter(|pose| pose.error.is_some()).count();
    match failed {
        0 => "done".into(),
        _ => format!("partly done ({failed} of {} poses failed)", report.poses.len()),
    }
}
