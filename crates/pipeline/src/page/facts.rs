//! The outcome of a run, its settings, inputs and times.

use maud::{Markup, html};
use serde_json::Value;

use super::{
    elements::badge,
    words::{name, prose},
};
use crate::{
    metrics::{Level, with_unit},
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
            h1 { (name(title)) }
            p.verdict {
                @if let Some(worst) = report.verdict { (badge(worst)) " " } @else { span.badge { "not measured" } " " }
                (count(report.poses.len(), "pose", "poses"))
                @for one in levels { @if of(one) > 0 { ", " (of(one)) " " (one.word()) } }
                @if failed > 0 { ", " strong { (failed) " not transferred" } }
            }
            table.facts {
                tr { th { "Source" } td { (mesh(&report.source, report.settings["source"]["unit"].as_str())) } }
                tr { th { "Target" } td { (mesh(&report.target, report.settings["target"]["unit"].as_str())) } }
                tr { th { "Markers" } td { (report.markers) } }
                @for stage in report.stages.iter().filter(|stage| !stage.name.is_empty()) {
                    tr { th { (capital(&stage.stage)) } td { code { (name(&stage.name)) } } }
                }
                tr { th { "Time" } td { (seconds(report.seconds)) " on " (count(report.threads, "thread", "threads")) } }
            }
        }
    }
}

/// Returns the sizes of a mesh; `unit` is that of its file, if the pipeline says it.
fn mesh(mesh: &MeshFigures, unit: Option<&str>) -> String {
    let mut text =
        format!("{}, {}", count(mesh.vertices, "vertex", "vertices"), count(mesh.triangles, "triangle", "triangles"));
    if mesh.components > 1 {
        text += &format!(", {}", count(mesh.components, "component", "components"));
    }
    format!("{text}, diagonal {} {}", number(mesh.diagonal), unit.unwrap_or("units of the file"))
}

fn capital(word: &str) -> String {
    let mut letters = word.replace('_', " ");
    if let Some(first) = letters.get_mut(0..1) {
        first.make_ascii_uppercase();
    }
    letters
}

/// Returns what was chosen for the user, and why.
pub fn choices(report: &Report) -> Markup {
    html! {
        @if !report.choices.is_empty() {
            section {
                h2 { "Chosen by the meshes" }
                table.facts {
                    @for choice in &report.choices {
                        tr { th { (capital(&choice.stage.replace('.', " "))) } td { code { (name(&choice.chosen)) } ": " (prose(&choice.why)) } }
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
                ul { @for warning in all { li { (prose(warning)) } } }
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
            div.scroll tabindex="0" {
                table.numbers {
                    tr { th { "stage" } th { "type" } th { "time" } th.bar { "" } }
                    @for stage in &report.stages {
                        tr {
                            th { (stage.stage.replace('_', " ")) }
                            td.word { (name(&stage.name)) }
                            td { @if stage.reused { "cached" } @else { (seconds(stage.seconds)) } }
                            td.bar { span style=(format!("width:{:.1}%", share(stage))) {} }
                        }
                    }
                }
            }
            @for stage in report.stages.iter().filter(|stage| !stage.figures.values.is_empty()) {
                details {
                    summary { (name(&stage.stage)) " (" (name(&stage.name)) ")" }
                    table.facts {
                        @for (figure, value) in &stage.figures.values {
                            @let (words, unit) = figure_and_unit(figure);
                            tr { th { (words) } td { (short(value, unit)) } }
                        }
                    }
                }
            }
        }
    }
}

/// Returns the name of a stage's figure in words, and its unit, which the end of the name says.
fn figure_and_unit(figure: &str) -> (String, &'static str) {
    let units = [("_percent", "%"), ("_degrees", "°")];
    let found = units.iter().find_map(|(end, unit)| Some((figure.strip_suffix(end)?, *unit)));
    let (words, unit) = found.unwrap_or((figure, if figure.ends_with("ratio") { "ratio" } else { "" }));
    (words.replace('_', " "), unit)
}

/// Returns a figure of a stage with its unit, lists of a few numbers in full.
fn short(value: &Value, unit: &str) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Number(_) => value.as_f64().map(|value| with_unit(value, unit)).unwrap_or_default(),
        Value::Array(list) if list.len() > 12 => format!("{} values", list.len()),
        Value::Array(list) => list.iter().map(|value| short(value, unit)).collect::<Vec<_>>().join(", "),
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
                tr { th { "Pipeline" } td { code { (name(&report.pipeline.display().to_string())) } } }
                tr { th { "Version" } td { (report.mimesh) } }
                @if !report.set.is_empty() { tr { th { "Set" } td { @for set in &report.set { code { (name(set)) } " " } } } }
                @if let Some(peak) = report.process.peak_memory_bytes { tr { th { "Memory" } td { "at most " (bytes(peak)) } } }
            }
            details {
                summary { "Settings in full" }
                pre { (settings) }
            }
            details {
                summary { (count(report.inputs.len(), "file", "files")) " read" }
                p.note { "Size and BLAKE3 hash" @if !poses.is_empty() { "; " (poses.len()) " of them poses" } "." }
                div.scroll tabindex="0" {
                    table.facts {
                        @for input in &report.inputs {
                            tr {
                                th { (input.role) }
                                td { code { (name(&input.path.display().to_string())) } }
                                td { (bytes(input.bytes)) }
                                td { code title=(input.blake3) { (input.blake3.get(..16).unwrap_or(&input.blake3)) "…" } }
                            }
                        }
                    }
                }
            }
            details {
                summary { "Files written beside this page" }
                div.scroll tabindex="0" {
                    table.facts {
                        @for output in &report.outputs {
                            tr { td { code { (name(&output.path.display().to_string())) } } td { (bytes(output.bytes)) } }
                        }
                    }
                }
            }
        }
    }
}
