//! Poses one by one: the worst with pictures, and all in a table.

use maud::{Markup, html};

use super::elements::{self, Image, badge, picture};
use crate::{
    metrics::{Level, PrimaryStatistic, primary_statistics},
    report::{PoseReport, Report},
    text::number,
};

/// Returns the worst poses, each with a picture and the reasons of its verdict.
pub fn worst(report: &Report, images: &[Image]) -> Markup {
    let pose = |image: &Image| report.poses.iter().find(|pose| pose.name == image.name);
    let mut shown: Vec<(&Image, &PoseReport)> = images.iter().filter_map(|image| Some((image, pose(image)?))).collect();
    let fine = report.verdict.is_none_or(|verdict| verdict == Level::Good);
    // Beside what is wrong, what is good needs no second look; where all is good, the largest errors are of interest.
    shown.retain(|(_, pose)| fine || pose.verdict.as_ref().is_some_and(|verdict| verdict.level > Level::Good));
    let measured = shown.iter().any(|(_, pose)| pose.metrics.contains_key("point_error"));
    html! {
        @if !shown.is_empty() && (!fine || measured) {
            section {
                h2 { @if fine { "Largest errors" } @else { "Look at these" } }
                @for (image, pose) in shown {
                    article.worst {
                        (picture(image))
                        div {
                            h3 { (pose.name) " " @if let Some(verdict) = &pose.verdict { (badge(verdict.level)) } }
                            (reasons(pose))
                        }
                    }
                }
            }
        }
    }
}

fn reasons(pose: &PoseReport) -> Markup {
    let reasons = pose.verdict.iter().flat_map(|verdict| &verdict.reasons);
    html! { ul { @for one in reasons { li { (one.words()) } } } }
}

/// Returns a table with a row for each pose.
pub fn table(report: &Report) -> Markup {
    let columns = primary_statistics(&report.poses);
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
