//! The statistics of each metric over all poses, with their units, limits and meanings.

use maud::{Markup, html};
use mimesh_core::stage::{Limits, Statistic};
use serde_json::{Map, Value};

use super::words::together;
use crate::{
    metrics::{PrimaryStatistic, declared_statistic, limit_with_unit, unit, with_unit},
    report::Report,
};

/// Returns the average and the worst of each metric over poses.
pub fn averages(report: &Report) -> Markup {
    html! {
        @if !report.metrics.is_empty() {
            section {
                h2 { "Metrics over all poses" }
                p.note { "Lengths in % are of the diagonal of the mesh at rest." }
                @for (metric, summary) in &report.metrics {
                    details open[metric == "point_error"] {
                        summary { (metric.replace('_', " ")) }
                        div.scroll tabindex="0" { (table(report, metric, summary)) }
                    }
                }
            }
        }
    }
}

/// Returns the table of one metric, a row for each statistic.
fn table(report: &Report, metric: &str, summary: &Value) -> Markup {
    let average = summary["average"].as_object();
    let shown: Vec<&String> =
        average.into_iter().flatten().filter(|(_, v)| v.is_number()).map(|(name, _)| name).collect();
    let column = |statistic: &str| PrimaryStatistic { metric: metric.into(), statistic: statistic.into() };
    let is_of_rest = column("").is_of_rest();
    let has_baseline = summary["nothing"].as_object().is_some_and(|figures: &Map<_, _>| !figures.is_empty());
    let of = |statistic: &str| declared_statistic(metric, statistic);
    let limit = |statistic: &str, which: fn(Limits) -> f64| of(statistic)?.limits.map(which);
    let has_limits = shown.iter().any(|name| limit(name, |limits| limits.bad).is_some());
    let has_gate = shown.iter().any(|name| column(name).gate(report).is_some());
    let value = |over: &str, name: &str| cell(summary[over][name].as_f64(), unit(metric, name), with_unit);
    let limit_cell = |limit: Option<f64>, name: &str| cell(limit, unit(metric, name), limit_with_unit);
    html! {
        table.numbers {
            tr {
                th { "" }
                @if is_of_rest { th { "all poses" } } @else { th { "average" } th { "worst" } }
                @if has_baseline { th { "doing nothing" } }
                @if has_limits { th { "doubtful above" } th { "bad above" } }
                @if has_gate { th { "gate" } }
                th.word { "what it is" }
            }
            @for name in &shown {
                tr {
                    th { (name.replace('_', " ")) (unit_behind(of(name))) }
                    (value("average", name))
                    @if !is_of_rest { (value("worst", name)) }
                    @if has_baseline { (value("nothing", name)) }
                    @if has_limits {
                        (limit_cell(limit(name, |limits| limits.doubtful), name))
                        (limit_cell(limit(name, |limits| limits.bad), name))
                    }
                    @if has_gate { (limit_cell(column(name).gate(report), name)) }
                    td.word { (of(name).map_or("", |statistic| statistic.meaning)) }
                }
            }
        }
    }
}

/// Returns the unit of a statistic whose values are written without one.
fn unit_behind(statistic: Option<Statistic>) -> &'static str {
    match statistic.map_or("", |statistic| statistic.unit) {
        "count" => ", count",
        "0 or 1" => ", 0 or 1",
        _ => "",
    }
}

fn cell(value: Option<f64>, unit: &str, words: fn(f64, &str) -> String) -> Markup {
    html! { td { (together(&value.map_or("–".into(), |value| words(value, unit)))) } }
}
