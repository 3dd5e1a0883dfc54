//! Curves as SVG, drawn in the page's own colours.

use maud::{Markup, html};

use crate::{
    pipeline::{
        Report,
        report::{Headline, headlines},
    },
    text::number,
};

/// Size of a chart, and the room around what it plots.
const SIZE: [f64; 2] = [480.0, 260.0];
const LEFT: f64 = 66.0;
const RIGHT: f64 = 12.0;
const ABOVE: f64 = 28.0;
const BELOW: f64 = 40.0;

/// A line with how it is drawn.
pub struct Line {
    /// Class in the style sheet, e.g. `thin`.
    pub class: &'static str,
    /// A colour instead of that of its class, and a name for the legend.
    pub named: Option<(String, String)>,
    /// From left to right; a gap where y is not finite.
    pub points: Vec<[f64; 2]>,
}

/// What a chart says around its lines.
pub struct Axes<'a> {
    pub title: &'a str,
    pub x: &'a str,
    pub y: &'a str,
    /// The largest values shown.
    pub upto: [f64; 2],
    /// Whether numbers along x are counts.
    pub counts: bool,
    /// A level that should not be crossed.
    pub limit: Option<f64>,
}

/// The curves of a run: the share of vertices within an error, and the main figure of each metric over poses.
pub fn curves(report: &Report) -> Markup {
    let shares: Vec<Vec<f64>> =
        report.poses.iter().filter_map(|pose| shares(pose.metrics.get("point_error")?)).collect();
    let columns = if report.poses.len() > 1 { headlines(&report.poses) } else { vec![] };
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

/// The curve `within` of a pose or of an average: shares of vertices with an error up to [`bound`].
pub fn shares(figures: &serde_json::Value) -> Option<Vec<f64>> {
    figures.get("within")?.as_array()?.iter().map(serde_json::Value::as_f64).collect()
}

/// As points, from no error on.
pub fn share_points(shares: &[f64]) -> Vec<[f64; 2]> {
    let point = |(k, share): (usize, &f64)| [bound(k, shares.len()), *share];
    std::iter::once([0.0, 0.0]).chain((1..).zip(shares).map(point)).collect()
}

/// The error of point `k` of `count`, in percent, as `point_error` says.
fn bound(k: usize, count: usize) -> f64 {
    10.0 * (k as f64 / count.max(1) as f64).powi(2)
}

/// Where most curves have come to their end.
pub fn far(curves: &[Vec<f64>]) -> f64 {
    let reached =
        |shares: &Vec<f64>| shares.iter().position(|s| *s > 99.5).map_or(10.0, |k| bound(k + 1, shares.len()));
    let far = curves.iter().map(reached).fold(0.0, f64::max);
    [0.5, 1.0, 2.0, 5.0, 10.0].into_iter().find(|end| *end >= far).unwrap_or(10.0)
}

fn within(all: &[Vec<f64>]) -> Markup {
    let mut lines: Vec<Line> =
        all.iter().map(|shares| Line { class: "thin", named: None, points: share_points(shares) }).collect();
    let average = (0..all[0].len()).map(|k| all.iter().filter_map(|s| s.get(k)).sum::<f64>() / all.len() as f64);
    lines.push(Line { class: "thick", named: None, points: share_points(&average.collect::<Vec<_>>()) });
    let axes = Axes {
        title: "Vertices within an error of the truth",
        x: "error, % of the diagonal",
        y: "share, %",
        upto: [far(all), 100.0],
        counts: false,
        limit: None,
    };
    chart(&axes, &lines)
}

/// A metric over poses, with that of the source where it tells it, and its gate.
fn over_poses(report: &Report, column: &Headline) -> Markup {
    let at = |k: usize, value: Option<f64>| [k as f64 + 1.0, value.unwrap_or(f64::NAN)];
    let of = |name: &str| -> Vec<[f64; 2]> {
        let column = Headline { metric: column.metric.clone(), figure: name.into() };
        report.poses.iter().enumerate().map(|(k, pose)| at(k, column.of(pose))).collect()
    };
    let mut lines = vec![Line { class: "thick", named: None, points: of(&column.figure) }];
    let source = of(&format!("source_{}", column.figure));
    if source.iter().any(|[_, y]| y.is_finite()) {
        lines[0].named = Some(("var(--accent)".into(), "result".into()));
        lines.push(Line { class: "source", named: Some(("var(--soft)".into(), "source".into())), points: source });
    }
    let flat = |line: &Line| line.points.iter().all(|p| p[1] == line.points[0][1] || !p[1].is_finite());
    // What is the same for every pose stands in the table.
    if lines.iter().all(flat) {
        return html! {};
    }
    let reasons = report.poses.iter().filter_map(|pose| pose.verdict.as_ref()).flat_map(|verdict| &verdict.reasons);
    let broken = reasons.filter(|r| r.metric == column.metric && r.figure == column.figure).map(|r| r.limit);
    let keys = [column.metric.clone(), format!("{}_{}", column.metric, column.figure)];
    let gate = keys.iter().find_map(|key| report.gates.get(key)?.as_f64());
    let limit = gate.or(broken.reduce(f64::min));
    let highest = lines.iter().flat_map(|line| &line.points).map(|p| p[1].abs()).filter(|y| y.is_finite());
    let top = nice(highest.fold(limit.unwrap_or(0.0), f64::max));
    let title = format!("{}, {}", column.metric, column.figure).replace('_', " ");
    let axes = Axes { title: &title, x: "pose", y: "", upto: [report.poses.len() as f64, top], counts: true, limit };
    chart(&axes, &lines)
}

/// The next of 1, 2, 5 times a power of ten.
fn nice(value: f64) -> f64 {
    if value <= 0.0 || !value.is_finite() {
        return 1.0;
    }
    let power = 10f64.powf(value.log10().floor());
    [1.0, 2.0, 5.0, 10.0].into_iter().map(|k| k * power).find(|top| *top >= value * 0.999).unwrap_or(10.0 * power)
}

/// A chart of lines.
pub fn chart(axes: &Axes<'_>, lines: &[Line]) -> Markup {
    let lowest = lines.iter().flat_map(|line| &line.points).map(|p| p[1]).filter(|y| y.is_finite());
    let bottom = if lowest.fold(0.0, f64::min) < 0.0 { -axes.upto[1] } else { 0.0 };
    let start = if axes.counts { 1.0 } else { 0.0 };
    let end = if axes.upto[0] > start { axes.upto[0] } else { start + 1.0 };
    let x = |value: f64| LEFT + (value - start) / (end - start) * (SIZE[0] - LEFT - RIGHT);
    let y = |value: f64| SIZE[1] - BELOW - (value - bottom) / (axes.upto[1] - bottom) * (SIZE[1] - ABOVE - BELOW);
    let ticks = |from: f64, to: f64| (0..=4).map(move |k| from + (to - from) * f64::from(k) / 4.0);
    let along_x: Vec<f64> = match axes.counts {
        true => counts(end as usize),
        false => ticks(start, end).collect(),
    };
    let named: Vec<&(String, String)> = lines.iter().filter_map(|line| line.named.as_ref()).collect();
    let height = SIZE[1] + 16.0 * named.len() as f64;
    html! {
        figure {
            svg viewBox=(format!("0 0 {} {height}", SIZE[0])) role="img" aria-label=(axes.title) {
                text.title x=(LEFT) y="16" { (axes.title) }
                @for tick in ticks(bottom, axes.upto[1]) {
                    line.grid x1=(LEFT) x2=(SIZE[0] - RIGHT) y1=(round(y(tick))) y2=(round(y(tick))) {}
                    text x=(LEFT - 6.0) y=(round(y(tick) + 4.0)) text-anchor="end" { (label(tick)) }
                }
                @for tick in along_x {
                    text x=(round(x(tick))) y=(SIZE[1] - BELOW + 18.0) text-anchor="middle" { (label(tick)) }
                }
                text x=((LEFT + SIZE[0] - RIGHT) / 2.0) y=(SIZE[1] - 6.0) text-anchor="middle" { (axes.x) }
                @if !axes.y.is_empty() {
                    text x="12" y=(SIZE[1] / 2.0) text-anchor="middle" transform=(format!("rotate(-90 12 {})", SIZE[1] / 2.0)) { (axes.y) }
                }
                @if let Some(limit) = axes.limit.filter(|limit| *limit <= axes.upto[1]) {
                    line.limit x1=(LEFT) x2=(SIZE[0] - RIGHT) y1=(round(y(limit))) y2=(round(y(limit))) {}
                    text x=(SIZE[0] - RIGHT) y=(round(y(limit) - 4.0)) text-anchor="end" { "limit" }
                }
                @for line in lines {
                    @let colour = line.named.as_ref().map(|(colour, _)| format!("stroke:{colour}"));
                    @for part in parts(&line.points, end) {
                        @if let [only] = part[..] {
                            circle cx=(round(x(only[0]))) cy=(round(y(only[1]))) r="3" {}
                        } @else {
                            @let path: Vec<String> = part.iter().map(|p| format!("{},{}", round(x(p[0])), round(y(p[1])))).collect();
                            polyline class=(line.class) style=[&colour] points=(path.join(" ")) {}
                        }
                    }
                }
                @for (k, (colour, name)) in named.iter().enumerate() {
                    @let at = SIZE[1] + 8.0 + 16.0 * k as f64;
                    line class=(lines.iter().find(|line| line.named.as_ref().is_some_and(|n| n.1 == *name)).map_or("thick", |line| line.class)) style=(format!("stroke:{colour}")) x1=(LEFT) x2=(LEFT + 24.0) y1=(at) y2=(at) {}
                    text x=(LEFT + 30.0) y=(at + 4.0) { (name) }
                }
            }
        }
    }
}

/// At most six whole numbers from 1 to `end`.
fn counts(end: usize) -> Vec<f64> {
    let step = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000].into_iter().find(|step| end / step < 6).unwrap_or(end);
    let mut all: Vec<f64> = (1..=end).step_by(step).map(|k| k as f64).collect();
    if end > 1 && all.last() != Some(&(end as f64)) && (end - 1) % step >= step / 2 {
        all.push(end as f64);
    }
    all
}

/// The pieces between gaps, as far as the chart goes.
fn parts(points: &[[f64; 2]], end: f64) -> Vec<Vec<[f64; 2]>> {
    let within: Vec<[f64; 2]> = points.iter().copied().filter(|p| p[0] <= end + 1e-9).collect();
    within.split(|p| !p[1].is_finite()).filter(|part| !part.is_empty()).map(<[_]>::to_vec).collect()
}

/// A number on an axis, without zeros at its end.
fn label(value: f64) -> String {
    let text = number(value);
    if !text.contains('.') || text.contains('e') {
        return text;
    }
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// For shorter text.
fn round(value: f64) -> f64 {
    (value * 10.0).round() / 10.0
}
