//! The curves of a run: errors of vertices, and the main figure of each metric over poses.

use maud::{Markup, html};
use serde_json::Value;

use super::chart::{Axes, Limit, Line, chart, round_up};
use crate::{
    metrics::{PrimaryStatistic, declared_statistic, limit_with_unit, primary_statistics, unit},
    report::Report,
};

/// Values above this share of the doubtful limit have it in their chart.
const NEAR_LIMIT: f64 = 0.3;

/// Returns the share of vertices within an error, and the main figure of each metric over poses.
pub fn curves(report: &Report) -> Markup {
    let shares: Vec<Vec<f64>> =
        report.poses.iter().filter_map(|pose| shares(&Value::Object(pose.metrics.get("point_error")?))).collect();
    let columns = if report.poses.len() > 1 { primary_statistics(&report.poses) } else { vec![] };
    html! {
        @if !shares.is_empty() || !columns.is_empty() {
            section {
                h2 { "Curves" }
                div.charts {
                    @if !shares.is_empty() { (within(&shares)) }
                    @for column in &columns { (over_poses(report, column)) }
                }
            }
        }
    }
}

/// Returns the curve `within` of a pose or of an average: the shares of vertices, in percent, with an error up to each [`bound`].
pub fn shares(figures: &serde_json::Value) -> Option<Vec<f64>> {
    figures.get("within")?.as_array()?.iter().map(serde_json::Value::as_f64).collect()
}

/// Returns shares as points over errors, from no error on.
pub fn share_points(shares: &[f64]) -> Vec<[f64; 2]> {
    let point = |(k, share): (usize, &f64)| [bound(k, shares.len()), *share];
    std::iter::once([0.0, 0.0]).chain((1..).zip(shares).map(point)).collect()
}

/// Returns the error of point `k` of `count`, in percent of the diagonal, as `point_error` defines it.
fn bound(k: usize, count: usize) -> f64 {
    10.0 * (k as f64 / count.max(1) as f64).powi(2)
}

/// Returns a round error, in percent, that nearly all vertices of all curves stay below.
pub fn last_error(curves: &[Vec<f64>]) -> f64 {
    let reached =
        |shares: &Vec<f64>| shares.iter().position(|s| *s > 99.5).map_or(10.0, |k| bound(k + 1, shares.len()));
    let far = curves.iter().map(reached).fold(0.0, f64::max);
    [0.5, 1.0, 2.0, 5.0, 10.0].into_iter().find(|end| *end >= far).unwrap_or(10.0)
}

fn within(all: &[Vec<f64>]) -> Markup {
    let mut lines: Vec<Line> = all.iter().map(|shares| Line::new("thin", share_points(shares))).collect();
    let average = (0..all[0].len()).map(|k| all.iter().filter_map(|s| s.get(k)).sum::<f64>() / all.len() as f64);
    lines.push(Line::new("thick", share_points(&average.collect::<Vec<_>>())));
    let axes = Axes {
        title: "Vertices within an error of the truth",
        x: "error, % of the diagonal",
        y: "share, %",
        upto: [last_error(all), 100.0],
        counts: false,
        limit: None,
    };
    chart(&axes, &lines)
}

/// Returns a metric over poses, with its limit, and with the values of the source where the metric has them.
fn over_poses(report: &Report, column: &PrimaryStatistic) -> Markup {
    let at = |k: usize, value: Option<f64>| [k as f64 + 1.0, value.unwrap_or(f64::NAN)];
    let of = |name: &str| -> Vec<[f64; 2]> {
        let column = PrimaryStatistic { metric: column.metric.clone(), statistic: name.into() };
        report.poses.iter().enumerate().map(|(k, pose)| at(k, column.of(pose))).collect()
    };
    let mut lines = vec![Line::new("thick", of(&column.statistic))];
    let source = of(&format!("source_{}", column.statistic));
    if source.iter().any(|[_, y]| y.is_finite()) {
        lines[0].named = Some(("var(--accent)".into(), "result".into()));
        lines.push(Line::new("source", source).named("var(--soft)", "source"));
    }
    let flat = |line: &Line| line.points.iter().all(|p| p[1] == line.points[0][1] || !p[1].is_finite());
    // What is the same for every pose stands in the table.
    if lines.iter().all(flat) {
        return html! {};
    }
    let reasons = report.poses.iter().filter_map(|pose| pose.verdict.as_ref()).flat_map(|verdict| &verdict.reasons);
    let broken = reasons.filter(|r| r.metric == column.metric && r.statistic == column.statistic).map(|r| r.limit);
    let unit = unit(&column.metric, &column.statistic);
    let highest = lines.iter().flat_map(|line| &line.points).map(|p| p[1].abs()).filter(|y| y.is_finite());
    let highest = highest.fold(0.0, f64::max);
    let declared = declared_statistic(&column.metric, &column.statistic).and_then(|declared| declared.limits);
    // Far below the limit the curve would be flat.
    let near = declared.map(|limits| limits.doubtful).filter(|doubtful| highest > NEAR_LIMIT * doubtful);
    let named = |what: &str, at: f64| Limit { at, name: format!("{what} {}", limit_with_unit(at, unit)) };
    let own = broken.reduce(f64::min).or(near).map(|at| {
        let is_bad = declared.is_some_and(|limits| at == limits.bad && at > limits.doubtful);
        named(if is_bad { "bad above" } else { "doubtful above" }, at)
    });
    let limit = column.gate(report).map(|at| named("gate", at)).or(own);
    let top = round_up(limit.as_ref().map_or(highest, |limit| highest.max(limit.at)));
    let title = format!("{}, {}", column.metric, column.statistic).replace('_', " ");
    let axes = Axes { title: &title, x: "pose", y: unit, upto: [report.poses.len() as f64, top], counts: true, limit };
    chart(&axes, &lines)
}
