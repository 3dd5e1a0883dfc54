//! The page that shows several runs beside each other.

use std::collections::BTreeMap;

use maud::{Markup, html};
use serde_json::Value;

use super::{
    chart::{Axes, Line, chart},
    curves::{last_error, share_points, shares},
    elements::{Image, badge, document, picture},
    words::name,
};
use crate::{
    metrics::{PrimaryStatistic, primary_statistics},
    report::Report,
    text::{number, seconds},
};

/// A run that is compared with others.
#[derive(Clone, Debug)]
pub struct ComparedRun {
    /// The name of the run.
    pub name: String,
    /// The report of the run.
    pub report: Report,
    /// Pictures of the results of its poses.
    pub pictures: Vec<Image>,
}

/// Colours of lines, distinct to the colour-blind too.
const COLOURS: [&str; 8] = ["#2f6f8f", "#d1495b", "#7a9e3a", "#8d5fb0", "#e08e2b", "#3aa6a0", "#6b4f3a", "#444c56"];

/// Returns the page of several runs.
pub fn compare(title: &str, runs: &[ComparedRun]) -> String {
    document(
        title,
        None,
        html! {
            header { h1 { (name(title)) } }
            (averages(runs))
            (next_step(runs))
            (curves(runs))
            (poses(runs))
            (pictures(runs))
            (settings(runs))
        },
    )
}

/// Returns the main figures of all metrics that any run has.
pub fn columns(runs: &[ComparedRun]) -> Vec<PrimaryStatistic> {
    let mut all: Vec<PrimaryStatistic> = Vec::new();
    for column in runs.iter().flat_map(|run| primary_statistics(&run.report.poses)) {
        if !all.contains(&column) {
            all.push(column);
        }
    }
    all
}

/// Returns the average of a figure over the poses of a run.
pub fn average(report: &Report, column: &PrimaryStatistic) -> Option<f64> {
    report.metrics.get(&column.metric)?["average"][&column.statistic].as_f64()
}

/// Returns the index of the smallest value, if several runs have one.
///
/// Runs of different targets are not compared, so that none of them is best.
pub fn best(runs: &[ComparedRun], values: &[Option<f64>]) -> Option<usize> {
    let target =
        |run: &ComparedRun| (run.report.target.vertices, run.report.target.diagonal.to_bits(), run.report.poses.len());
    if runs.iter().any(|run| target(run) != target(&runs[0])) {
        return None;
    }
    let known = values.iter().enumerate().filter_map(|(i, value)| Some((i, value.as_ref()?.abs())));
    let best = known.clone().min_by(|a, b| a.1.total_cmp(&b.1))?;
    (known.clone().count() > 1 && known.clone().any(|(_, value)| value > best.1)).then_some(best.0)
}

fn averages(runs: &[ComparedRun]) -> Markup {
    html! {
        section {
            h2 { "Average over poses" }
            div.scroll tabindex="0" {
                table.numbers {
                    tr { th { "" } @for run in runs { th { (name(&run.name)) } } }
                    tr {
                        th { "verdict" }
                        @for run in runs { td { @if let Some(worst) = run.report.verdict { (badge(worst)) } } }
                    }
                    @for column in columns(runs) {
                        @let values: Vec<_> = runs.iter().map(|run| average(&run.report, &column)).collect();
                        (row(runs, &column.words(), &values))
                    }
                    tr { th { "markers" } @for run in runs { td { (run.report.markers) } } }
                    tr { th { "time" } @for run in runs { td { (seconds(run.report.seconds)) } } }
                }
            }
        }
    }
}

/// Returns what to do with the comparison.
fn next_step(runs: &[ComparedRun]) -> Markup {
    let column = columns(runs).into_iter().next();
    let values = |column: &PrimaryStatistic| runs.iter().map(|run| average(&run.report, column)).collect::<Vec<_>>();
    let best = column.as_ref().and_then(|column| Some((column, best(runs, &values(column))?)));
    html! {
        p {
            strong { "What to do next: " }
            @if let Some((column, best)) = best {
                code { (name(&runs[best].name)) } " is best by " (column.words()) ". Look at its pictures beside the others. If they \
                agree, take over its settings, which stand at the end of this page."
            } @else {
                "No run is best by the first metric. Look at the pictures, and at the settings that differ, at the end of this page."
            }
        }
    }
}

/// Returns a row of values with the best in bold.
fn row(runs: &[ComparedRun], name: &str, values: &[Option<f64>]) -> Markup {
    let best = best(runs, values);
    html! {
        tr {
            th { (self::name(name)) }
            @for (i, value) in values.iter().enumerate() {
                td {
                    @match value {
                        Some(value) if best == Some(i) => strong { (number(*value)) },
                        Some(value) => (number(*value)),
                        None => "–",
                    }
                }
            }
        }
    }
}

fn curves(runs: &[ComparedRun]) -> Markup {
    let of = |run: &ComparedRun| shares(&run.report.metrics.get("point_error")?["average"]);
    let all: Vec<(usize, Vec<f64>)> = runs.iter().enumerate().filter_map(|(i, run)| Some((i, of(run)?))).collect();
    let line = |(i, shares): &(usize, Vec<f64>)| {
        Line::new("thick", share_points(shares)).named(COLOURS[i % COLOURS.len()], &runs[*i].name)
    };
    let ends: Vec<Vec<f64>> = all.iter().map(|(_, shares)| shares.clone()).collect();
    let axes = Axes {
        title: "Vertices within an error of the truth, all poses",
        x: "error, % of the diagonal",
        y: "share, %",
        upto: [last_error(&ends), 100.0],
        counts: false,
        limit: None,
    };
    html! {
        @if !all.is_empty() {
            section {
                h2 { "Curves" }
                div.charts { (chart(&axes, &all.iter().map(line).collect::<Vec<_>>())) }
            }
        }
    }
}

/// Returns the names of the poses of all runs, in their order.
fn names(runs: &[ComparedRun]) -> Vec<&str> {
    let mut names: Vec<&str> = Vec::new();
    for pose in runs.iter().flat_map(|run| &run.report.poses) {
        if !names.contains(&pose.name.as_str()) {
            names.push(&pose.name);
        }
    }
    names
}

/// Returns the first of the main figures, pose by pose.
fn poses(runs: &[ComparedRun]) -> Markup {
    let Some(column) = columns(runs).into_iter().next() else { return html! {} };
    let value = |run: &ComparedRun, name: &str| {
        run.report.poses.iter().find(|pose| pose.name == name).and_then(|pose| column.of(pose))
    };
    html! {
        section {
            h2 { "Each pose: " (column.words()) }
            div.scroll tabindex="0" {
                table.numbers {
                    tr { th { "pose" } @for run in runs { th { (name(&run.name)) } } }
                    @for name in names(runs) {
                        (row(runs, name, &runs.iter().map(|run| value(run, name)).collect::<Vec<_>>()))
                    }
                }
            }
        }
    }
}

fn pictures(runs: &[ComparedRun]) -> Markup {
    let of = |run: &ComparedRun, name: &str| run.pictures.iter().find(|image| image.name == name).cloned();
    html! {
        @if runs.iter().any(|run| !run.pictures.is_empty()) {
            section {
                h2 { "Pictures" }
                div.scroll tabindex="0" {
                    table.pictures {
                        tr { th { "" } @for run in runs { th { (name(&run.name)) } } }
                        @for name in names(runs) {
                            tr {
                                th { (self::name(name)) }
                                @for run in runs { td { @if let Some(image) = of(run, name) { (picture(&image)) } } }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// Returns the settings that are not the same in all runs.
fn settings(runs: &[ComparedRun]) -> Markup {
    let flat: Vec<BTreeMap<String, String>> = runs.iter().map(|run| flattened(&run.report.settings)).collect();
    let mut keys: Vec<&String> = flat.iter().flat_map(BTreeMap::keys).collect();
    keys.sort();
    keys.dedup();
    let differs = |key: &&&String| flat.iter().any(|one| one.get(**key) != flat[0].get(**key));
    html! {
        section {
            h2 { "Settings that differ" }
            div.scroll tabindex="0" {
                table.facts {
                    tr { th { "" } @for run in runs { th { (name(&run.name)) } } }
                    @for key in keys.iter().filter(differs) {
                        tr {
                            th { code { (name(key)) } }
                            @for one in &flat { td { code { (name(one.get(*key).map_or("–", String::as_str))) } } }
                        }
                    }
                }
            }
        }
    }
}

/// Returns every value by its path.
fn flattened(value: &Value) -> BTreeMap<String, String> {
    fn walk(value: &Value, path: String, all: &mut BTreeMap<String, String>) {
        match value {
            Value::Object(map) => {
                for (key, value) in map {
                    walk(value, if path.is_empty() { key.clone() } else { format!("{path}.{key}") }, all);
                }
            }
            Value::String(text) => drop(all.insert(path, text.clone())),
            _ => drop(all.insert(path, value.to_string())),
        }
    }
    let mut all = BTreeMap::new();
    walk(value, String::new(), &mut all);
    all
}
