//! Poses one by one: the worst with pictures, and all in a table.

use maud::{Markup, html};

use super::elements::{self, Image, badge, picture};
use crate::{
    metrics::{Level, PrimaryStatistic, Verdict, faults, primary_statistics},
    report::{PoseReport, Report},
    text::number,
};

/// Returns the worst poses, each with a picture and the reasons of its verdict.
pub fn worst(report: &Report, images: &[Image]) -> Markup {
    let pose = |image: &Image| report.poses.iter().find(|pose| pose.name == image.name);
    let mut shown: Vec<(&Image, &PoseReport)> = images.iter().filter_map(|image| Some((image, pose(image)?))).collect();
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
                        (picture(image))
                        div {
                            h3 { (pose.name) " " @if let Some(verdict) = &pose.verdict { (badge(verdict.level)) } }
                            (reasons(pose.verdict.as_ref()))
                        }
                    }
                }
            }
        }
    }
}

/// Returns what is wrong with the run, in plain words.
pub fn meaning(report: &Report) -> Markup {
    let found = faults(report.verdicts());
    html! {
        @if !found.is_empty() {
            section {
                h2 { "What that means" }
                dl { @for (metric, fault) in &found { dt { (metric.replace('_', " ")) } dd { (fault) } } }
            }
        }
    }
}

/// Returns the reasons of a verdict as a list.
fn reasons(verdict: Option<&Verdict>) -> Markup {
    let reasons = verdict.into_iter().flat_map(|verdict| &verdict.reasons);
    html! { ul { @for one in reasons { li { (one.words()) } } } }
}

/// Returns what is wrong with map and markers, once for all poses.
pub fn shared(report: &Report) -> Markup {
    let verdict = report.rest_verdict.as_ref().filter(|verdict| verdict.level > Level::Good);
    html! {
        @if let Some(verdict) = verdict {
            section {
                h2 { "Map and markers " (badge(verdict.level)) }
                p.note { "These concern the whole run, whatever the poses." }
                (reasons(Some(verdict)))
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
    html! {
        section {
            h2 { "Verdict of each pose" }
            div.scroll {
                table.numbers {
                    tr {
                        th { "pose" } th.word { "verdict" }
                        @for column in &columns { th { (column.metric.replace('_', " ")) br; small { (column.statistic.replace('_', " ")) } } }
                    }
                    @for pose in &report.poses {
                        tr {
                            th.name { (pose.name) }
                            td.word {
                                @if let Some(error) = &pose.error {
                                    span.badge.failed { "not transferred" } " "
                                    @if let Some(file) = error["file"].as_str() { code { (file) } ": " }
                                    (error["message"].as_str().unwrap_or_default())
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
