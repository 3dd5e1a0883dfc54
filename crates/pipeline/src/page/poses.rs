//! Poses one by one: the worst with pictures, and all in a table.

use maud::{Markup, html};
use mimesh_core::stage::Limits;

use super::{
    elements::{self, PanelImages, badge, picture},
    words::{name, prose, together},
};
use crate::{
    metrics::{
        Level, PrimaryStatistic, Reason, Verdict, declared_statistic, faults, limit_with_unit, primary_statistics, unit,
    },
    report::{PoseReport, Report},
    text::number,
};

/// Returns the worst poses, each with a picture and the reasons of its verdict.
pub fn worst(report: &Report, images: &[PanelImages]) -> Markup {
    let pose = |image: &PanelImages| report.poses.iter().find(|pose| pose.name == image.name);
    let mut shown: Vec<(&PanelImages, &PoseReport)> =
        images.iter().filter_map(|image| Some((image, pose(image)?))).collect();
    let is_fine = |pose: &PoseReport| pose.verdict.as_ref().is_none_or(|verdict| verdict.level == Level::Good);
    let fine = report.poses.iter().all(is_fine);
    // Beside what is wrong, what is good needs no second look; where all is good, the largest errors are of interest.
    shown.retain(|(_, pose)| fine || pose.verdict.as_ref().is_some_and(|verdict| verdict.level > Level::Good));
    let measured = shown.iter().any(|(_, pose)| pose.metrics.metrics().any(|metric| metric == "point_error"));
    html! {
        @if !shown.is_empty() && (!fine || measured) {
            section {
                h2 { @if fine { "Largest errors" } @else { "Look at these" } }
                @for (image, pose) in shown {
                    article.worst {
                        div.panels { @for panel in &image.panels { (picture(panel)) } }
                        div {
                            h3 { (name(&pose.name)) " " @if let Some(verdict) = &pose.verdict { (badge(verdict.level)) } }
                            (reasons(pose.verdict.as_ref()))
                        }
                    }
                }
            }
        }
    }
}

/// Returns what is wrong with the poses, in plain words; what is wrong with map and markers stands with these.
pub fn meaning(report: &Report) -> Markup {
    let found = faults(report.poses.iter().filter_map(|pose| pose.verdict.as_ref()));
    html! {
        @if !found.is_empty() {
            section {
                h2 { "What that means" }
                dl { @for (metric, fault) in &found { dt { (metric.replace('_', " ")) } dd { (prose(fault)) } } }
            }
        }
    }
}

/// Returns the reasons of a verdict as a list.
fn reasons(verdict: Option<&Verdict>) -> Markup {
    let reasons = verdict.into_iter().flat_map(|verdict| &verdict.reasons);
    html! { ul { @for one in reasons { li { (prose(&one.words())) @if let Some(limits) = limits(one) { (limits) } } } } }
}

/// Returns the other limit of a statistic, so that a reader sees how bad its value is.
fn limits(reason: &Reason) -> Option<Markup> {
    let limits = declared_statistic(&reason.metric, &reason.statistic)?.limits?;
    let unit = unit(&reason.metric, &reason.statistic);
    let (level, limit) = match reason.level {
        Level::Doubtful => ("bad", limits.bad),
        Level::Bad => ("doubtful", limits.doubtful),
        Level::Failed | Level::Good => return None,
    };
    // A known result says more than a suspicion, which then makes nothing worse than doubtful.
    let is_held_back = reason.level == Level::Doubtful && reason.value.is_some_and(|value| value.abs() > limits.bad);
    let otherwise = if is_held_back { " where no result is known" } else { "" };
    Some(html! { span.note { " (" (level) " above " (together(&limit_with_unit(limit, unit))) (otherwise) ")" } })
}

/// Returns what is wrong with map and markers, once for all poses.
pub fn shared(report: &Report) -> Markup {
    let verdict = report.rest_verdict.as_ref().filter(|verdict| verdict.level > Level::Good);
    html! {
        @if let Some(verdict) = verdict {
            section {
                h2 { "Map and markers " (badge(verdict.level)) }
                p.note { "All poses share this, so it stands here once." }
                (reasons(Some(verdict)))
                @for (_, fault) in faults([verdict]) { p { (prose(&sentence(fault))) } }
            }
        }
    }
}

/// Returns words as a sentence.
fn sentence(words: &str) -> String {
    let mut letters = words.chars();
    letters.next().map(|first| format!("{}{}.", first.to_uppercase(), letters.as_str())).unwrap_or_default()
}

/// Returns the row of limits of one level in the table of poses; nothing if no column has one.
fn limit_row(heading: &str, limits: &[Option<f64>]) -> Markup {
    html! {
        @if limits.iter().any(Option::is_some) {
            tr.limits {
                th { (heading) } td.word { "" }
                @for limit in limits { td { @if let Some(limit) = limit { (limit_with_unit(*limit, "")) } } }
            }
        }
    }
}

/// Returns a table with a row for each pose.
pub fn table(report: &Report) -> Markup {
    let mut columns = primary_statistics(&report.poses);
    columns.retain(|column| !column.is_of_rest());
    let value = |pose: &PoseReport, column: &PrimaryStatistic| match column.of(pose) {
        Some(value) => number(value),
        None => "–".into(),
    };
    let breaks = |pose: &PoseReport, column: &PrimaryStatistic| {
        let reasons = pose.verdict.iter().flat_map(|verdict| &verdict.reasons);
        let level =
            reasons.filter(|r| r.metric == column.metric && r.statistic == column.statistic).map(|r| r.level).max();
        level.map(elements::class).unwrap_or_default()
    };
    let limits = |of: fn(Limits) -> f64| -> Vec<Option<f64>> {
        let declared = |column: &PrimaryStatistic| declared_statistic(&column.metric, &column.statistic)?.limits;
        columns.iter().map(|column| declared(column).map(of)).collect()
    };
    let gates: Vec<Option<f64>> = columns.iter().map(|column| column.gate(report)).collect();
    html! {
        section {
            h2 { "Verdict of each pose" }
            div.scroll tabindex="0" {
                table.numbers {
                    tr {
                        th { "pose" } th.word { "verdict" }
                        @for column in &columns { th { (column.metric.replace('_', " ")) br; small { (column.statistic.replace('_', " ")) (column.unit_behind()) } } }
                    }
                    (limit_row("doubtful above", &limits(|limits| limits.doubtful)))
                    (limit_row("bad above", &limits(|limits| limits.bad)))
                    (limit_row("gate", &gates))
                    @for pose in &report.poses {
                        tr {
                            th.name { (name(&pose.name)) }
                            td.word {
                                @if let Some(error) = &pose.error {
                                    span.badge.failed { "not transferred" } " "
                                    @if let Some(file) = error["file"].as_str() { code { (name(file)) } ": " }
                                    (prose(error["message"].as_str().unwrap_or_default()))
                                } @else if let Some(verdict) = &pose.verdict {
                                    (badge(verdict.level))
                                }
                            }
                            @for column in &columns { td class=(breaks(pose, column)) { (value(pose, column)) } }
                        }
                    }
                }
            }
        }
    }
}
