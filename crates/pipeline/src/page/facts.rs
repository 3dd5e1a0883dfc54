//! The outcome of a run, its settings, inputs and times.

use maud::{Markup, html};
use serde_json::Value;

use super::elements::badge;
use crate::{
    metrics::Level,
    report::{InputReport, MeshFigures, Report, StageReport},
    text::{bytes, count, number, seconds},
};

/// Returns the outcome in a few lines.
pub fn head(report: &Report, title: &str) -> Markup {
    let failed = report.poses.iter().filter(|pose| pose.error.is_some()).count();
    let of = |wanted: Level| {
        report.poses.iter().filter(|pose| pose.verdict.as_ref().is_some_and(|verdict| verdict.level == wanted)).count()
    };
    let levels = [Level::Failed, Level::Bad, Level::Doubtful, Level::Good];
    html! {
        header {
            h1 { (title) }
            p.verdict {
                @if let Some(worst) = report.verdict { (badge(worst)) " " } @else { span.badge { "not measured" } " " }
                (count(report.poses.len(), "pose", "poses"))
                @for one in levels { @if of(one) > 0 { ", " (of(one)) " " (one.word()) } }
                @if failed > 0 { ", " strong { (failed) " not transferred" } }
            }
            table.facts {
                tr { th { "Source" } td { (mesh(&report.source)) } }
                tr { th { "Target" } td { (mesh(&report.target)) } }
                tr { th { "Markers" } td { (report.markers) } }
                @for stage in report.stages.iter().filter(|stage| !stage.name.is_empty()) {
                    tr { th { (capital(&stage.stage)) } td { code { (stage.name) } } }
                }
                tr { th { "Time" } td { (seconds(report.seconds)) " on " (count(report.threads, "thread", "threads")) } }
            }
        }
    }
}

fn mesh(mesh: &MeshFigures) -> String {
    let mut text =
        format!("{}, {}", count(mesh.vertices, "vertex", "vertices"), count(mesh.triangles, "triangle", "triangles"));
    if mesh.components > 1 {
        text += &format!(", {}", count(mesh.components, "component", "components"));
    }
    format!("{text}, diagonal {}", number(mesh.diagonal))
}

fn capital(word: &str) -> String {
    let mut letters = word.replace('_', " ");
    if let Some(first) = letters.get_mut(0..1) {
        first.make_ascii_uppercase();
    }
    letters
}

/// Returns the average and the worst of each metric over poses.
pub fn averages(report: &Report) -> Markup {
    let cell = |summary: &Value, over: &str, figure: &str| match summary[over][figure].as_f64() {
        Some(value) => number(value),
        None => "–".into(),
    };
    html! {
        @if !report.metrics.is_empty() {
            section {
                h2 { "Metrics over all poses" }
                p.note { "The descriptions of the metrics say what each figure is." }
                @for (metric, summary) in &report.metrics {
                    @let baseline = summary["nothing"].as_object().is_some_and(|figures| !figures.is_empty());
                    details open[metric == "point_error"] {
                        summary { (metric.replace('_', " ")) }
                        div.scroll {
                            table.numbers {
                                tr {
                                    th { "" } th { "average" } th { "worst" }
                                    @if baseline { th { "doing nothing" } }
                                }
                                @for (figure, value) in summary["average"].as_object().into_iter().flatten() {
                                    @if value.is_number() {
                                        tr {
                                            th { (figure.replace('_', " ")) }
                                            td { (cell(summary, "average", figure)) }
                                            td { (cell(summary, "worst", figure)) }
                                            @if baseline { td { (cell(summary, "nothing", figure)) } }
                                        }
                                    }
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// Returns what was chosen for the user, and why.
pub fn choices(report: &Report) -> Markup {
    html! {
        @if !report.choices.is_empty() {
            section {
                h2 { "Chosen by the meshes" }
                table.facts {
                    @for choice in &report.choices {
                        tr { th { (capital(&choice.stage.replace('.', " "))) } td { code { (choice.chosen) } ": " (choice.why) } }
                    }
                }
            }
        }
    }
}

/// Returns the warnings of the run and of its stages.
pub fn warnings(report: &Report) -> Markup {
    let of_stages = report.stages.iter().flat_map(|stage| &stage.figures.warnings);
    let mut all: Vec<&String> = report.warnings.iter().collect();
    all.extend(of_stages.filter(|warning| !report.warnings.contains(warning)));
    html! {
        @if !all.is_empty() {
            section {
                h2 { "Warnings" }
                ul { @for warning in all { li { (warning) } } }
            }
        }
    }
}

/// Returns times and figures of stages.
pub fn stages(report: &Report) -> Markup {
    let longest = report.stages.iter().map(|stage| stage.seconds).fold(0.0, f64::max);
    let share = |stage: &StageReport| if longest > 0.0 { 100.0 * stage.seconds / longest } else { 0.0 };
    html! {
        section {
            h2 { "Stages" }
            div.scroll {
                table.numbers {
                    tr { th { "stage" } th { "type" } th { "time" } th.bar { "" } }
                    @for stage in &report.stages {
                        tr {
                            th { (stage.stage.replace('_', " ")) }
                            td.word { (stage.name) }
                            td { @if stage.reused { "cached" } @else { (seconds(stage.seconds)) } }
                            td.bar { span style=(format!("width:{:.1}%", share(stage))) {} }
                        }
                    }
                }
            }
            @for stage in report.stages.iter().filter(|stage| !stage.figures.values.is_empty()) {
                details {
                    summary { (stage.stage) " (" (stage.name) ")" }
                    table.facts {
                        @for (name, value) in &stage.figures.values {
                            tr { th { (name.replace('_', " ")) } td { (short(value)) } }
                        }
                    }
                }
            }
        }
    }
}

fn short(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Number(_) => value.as_f64().map(number).unwrap_or_default(),
        Value::Array(list) if list.len() > 12 => format!("{} values", list.len()),
        _ => value.to_string(),
    }
}

/// Returns the files that were read and written, with all settings.
pub fn provenance(report: &Report) -> Markup {
    let settings = format!("{:#}", report.settings);
    let poses: Vec<&InputReport> = report.inputs.iter().filter(|input| input.role == "pose").collect();
    html! {
        section {
            h2 { "Provenance" }
            table.facts {
                tr { th { "Pipeline" } td { code { (report.pipeline.display()) } } }
                tr { th { "mimesh" } td { (report.mimesh) } }
                @if !report.set.is_empty() { tr { th { "Set" } td { @for set in &report.set { code { (set) } " " } } } }
                @if let Some(peak) = report.process.peak_memory_bytes { tr { th { "Memory" } td { "at most " (bytes(peak)) } } }
            }
            details {
                summary { "Settings in full" }
                pre { (settings) }
            }
            details {
                summary { (count(report.inputs.len(), "file", "files")) " read" }
                p.note { "Size and BLAKE3 hash" @if !poses.is_empty() { "; " (poses.len()) " of them poses" } "." }
                div.scroll {
                    table.facts {
                        @for input in &report.inputs {
                            tr {
                                th { (input.role) }
                                td { code { (input.path.display()) } }
                                td { (bytes(input.bytes)) }
                                td { code title=(input.blake3) { (input.blake3.get(..16).unwrap_or(&input.blake3)) "…" } }
                            }
                        }
                    }
                }
            }
            details {
                summary { "Files written beside this page" }
                div.scroll {
                    table.facts {
                        @for output in &report.outputs {
                            tr { td { code { (output.path.display()) } } td { (bytes(output.bytes)) } }
                        }
                    }
                }
            }
        }
    }
}
