use super::Entry;
use crate::{
    pipeline::Report,
    text::{self, seconds},
};

/// A column: its heading, and its figure of `point_error` over poses.
const COLUMNS: [(&str, &str, &str); 5] = [
    ("mean", "average", "mean"),
    ("rms", "average", "rms"),
    ("p95", "average", "p95"),
    ("worst pose", "worst", "mean"),
    ("worst component", "worst", "comp_max"),
];

/// The table: a row for doing nothing in each case, and one for each method; errors in percent of the diagonal.
pub fn rows(entries: &[Entry]) -> Vec<Vec<String>> {
    let mut rows: Vec<Vec<String>> = vec![
        ["case", "method", "clicks"]
            .into_iter()
            .chain(COLUMNS.map(|(heading, ..)| heading))
            .chain(["verdict", "time"])
            .map(str::to_owned)
            .collect(),
    ];
    let mut case = "";
    for entry in entries {
        let report = match &entry.ended {
            Ok(report) => report,
            Err(_) => {
                let mut row = vec![entry.case.clone(), entry.method.into(), "-".into()];
                row.extend(COLUMNS.map(|_| "-".to_owned()));
                row.extend(["failed".into(), "-".into()]);
                rows.push(row);
                continue;
            }
        };
        if entry.case != case {
            case = &entry.case;
            let mut row = vec![entry.case.clone(), "doing nothing".into(), "0".into()];
            row.extend(COLUMNS.map(|(_, over, figure)| match over {
                "average" => figure_of(report, "nothing", figure),
                _ => "-".into(),
            }));
            row.extend(["-".into(), "-".into()]);
            rows.push(row);
        }
        let mut row = vec![entry.case.clone(), entry.method.into(), report.markers.to_string()];
        row.extend(COLUMNS.map(|(_, over, figure)| figure_of(report, over, figure)));
        let verdict = report.verdict.map_or("-", |level| level.word());
        row.push(match entry.failed.len() {
            0 => verdict.into(),
            failed => format!("{verdict}, {failed} of {} poses failed", report.poses.len()),
        });
        row.push(seconds(report.seconds));
        rows.push(row);
    }
    rows
}

fn figure_of(report: &Report, over: &str, figure: &str) -> String {
    let value = report.metrics.get("point_error").and_then(|summary| summary[over][figure].as_f64());
    value.map_or("-".into(), |value| format!("{value:.3}"))
}

/// As a table of a page.
pub fn markdown(entries: &[Entry]) -> String {
    text::markdown(&rows(entries), 2)
}

/// As comma-separated values.
pub fn csv(entries: &[Entry]) -> String {
    text::csv(&rows(entries))
}
