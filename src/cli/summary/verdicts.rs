//! Verdicts in the summary of a run: the statistics that they judge, their reasons, and what helps.

use std::fmt::Write;

use mimesh_pipeline::{
    metrics::{Level, PrimaryStatistic, Reason, Verdict, faults, primary_statistics},
    report::{PoseReport, Report},
    text::{number, pairs, table},
};

use super::MAX_ROWS;

/// The verdict with its reasons, after a table of the primary statistics of all metrics but `point_error`.
pub fn verdicts(report: &Report) -> String {
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
