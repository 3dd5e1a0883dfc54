//! Charts of lines as SVG: in a page, in its own colours, or as a file.

use maud::{Markup, PreEscaped, html};

use crate::text::number;

/// The style sheet of charts, in the colours of a page.
pub const STYLE: &str = include_str!("chart.css");

/// The colours of a page in light, for a chart that stands alone.
const COLOURS: [(&str, &str); 5] = [
    ("var(--ink)", "#1b1f24"),
    ("var(--soft)", "#5b6570"),
    ("var(--line)", "#d9dee3"),
    ("var(--accent)", "#2f6f8f"),
    ("var(--bad)", "#b3261e"),
];

/// The size of a chart, and the room around its plot.
const SIZE: [f64; 2] = [480.0, 260.0];
const LEFT: f64 = 66.0;
const RIGHT: f64 = 12.0;
const ABOVE: f64 = 28.0;
const BELOW: f64 = 40.0;
/// The height of a line in the legend.
const LEGEND_LINE: f64 = 16.0;

/// A line of a chart.
#[derive(Clone, Debug, Default)]
pub struct Line {
    /// The class of the stroke in the style sheet, e.g. `thin`; without one only the dots are drawn.
    pub stroke: Option<&'static str>,
    /// Whether each point has a dot.
    pub dots: bool,
    /// A colour in place of that of the class, and a name for the legend.
    pub named: Option<(String, String)>,
    /// The points from left to right; the line has a gap where y is not finite.
    pub points: Vec<[f64; 2]>,
}

impl Line {
    /// Returns a line without dots or name.
    pub fn new(stroke: &'static str, points: Vec<[f64; 2]>) -> Self {
        Self { stroke: Some(stroke), points, ..Self::default() }
    }

    /// Returns the line in a colour, with a name in the legend.
    pub fn named(self, colour: &str, name: &str) -> Self {
        Self { named: Some((colour.into(), name.into())), ..self }
    }

    /// The style of its strokes or dots, as `property` of CSS.
    fn style(&self, property: &str) -> Option<String> {
        self.named.as_ref().map(|(colour, _)| format!("{property}:{colour}"))
    }
}

/// The title and the axes of a chart.
#[derive(Clone, Debug)]
pub struct Axes<'a> {
    /// The title above the chart.
    pub title: &'a str,
    /// The name of the values to the right.
    pub x: &'a str,
    /// The name of the values upwards; may be empty.
    pub y: &'a str,
    /// The largest values shown.
    pub upto: [f64; 2],
    /// Whether numbers along x are counts, which begin at 1.
    pub counts: bool,
    /// A level that should not be crossed.
    pub limit: Option<Limit>,
}

/// A level that values should not cross.
#[derive(Clone, Debug)]
pub struct Limit {
    /// The level.
    pub at: f64,
    /// What it is, with its unit: `bad above 60 %`.
    pub name: String,
}

/// Returns a chart as a figure of a page.
pub fn chart(axes: &Axes<'_>, lines: &[Line]) -> Markup {
    html! {
        figure {
            svg viewBox=(view_box(lines)) role="img" aria-label=(axes.title) { (content(axes, lines)) }
        }
    }
}

/// Returns a chart as an SVG file.
pub fn file(axes: &Axes<'_>, lines: &[Line]) -> String {
    let svg = html! {
        svg xmlns="http://www.w3.org/2000/svg" viewBox=(view_box(lines)) {
            style { (PreEscaped(STYLE)) }
            rect width="100%" height="100%" fill="white" {}
            (content(axes, lines))
        }
    };
    COLOURS.iter().fold(svg.into_string(), |text, (variable, colour)| text.replace(variable, colour)) + "\n"
}

/// Returns the least of 1, 2 and 5 times a power of ten that is not below `value`; 1 if it is not positive.
pub fn round_up(value: f64) -> f64 {
    if value <= 0.0 || !value.is_finite() {
        return 1.0;
    }
    let power = 10f64.powf(value.log10().floor());
    [1.0, 2.0, 5.0, 10.0].into_iter().map(|k| k * power).find(|top| *top >= value * 0.999).unwrap_or(10.0 * power)
}

fn view_box(lines: &[Line]) -> String {
    let named = lines.iter().filter(|line| line.named.is_some()).count();
    format!("0 0 {} {}", SIZE[0], SIZE[1] + LEGEND_LINE * named as f64)
}

fn content(axes: &Axes<'_>, lines: &[Line]) -> Markup {
    let plot = Plot::new(axes, lines);
    let middle = [(LEFT + SIZE[0] - RIGHT) / 2.0, SIZE[1] / 2.0];
    html! {
        text.title x=(LEFT) y="16" { (axes.title) }
        @for tick in ticks(plot.low[1], plot.high[1]) {
            line.grid x1=(LEFT) x2=(SIZE[0] - RIGHT) y1=(plot.y(tick)) y2=(plot.y(tick)) {}
            text x=(LEFT - 6.0) y=(round(plot.y(tick) + 4.0)) text-anchor="end" { (label(tick)) }
        }
        @for tick in plot.ticks_along_x(axes) {
            text x=(plot.x(tick)) y=(SIZE[1] - BELOW + 18.0) text-anchor="middle" { (label(tick)) }
        }
        text x=(middle[0]) y=(SIZE[1] - 6.0) text-anchor="middle" { (axes.x) }
        @if !axes.y.is_empty() {
            text x="12" y=(middle[1]) text-anchor="middle" transform=(format!("rotate(-90 12 {})", middle[1])) { (axes.y) }
        }
        @if let Some(limit) = axes.limit.as_ref().filter(|limit| limit.at <= axes.upto[1]) {
            line.limit x1=(LEFT) x2=(SIZE[0] - RIGHT) y1=(plot.y(limit.at)) y2=(plot.y(limit.at)) {}
            text x=(SIZE[0] - RIGHT) y=(round(plot.y(limit.at) - 4.0)) text-anchor="end" { (limit.name) }
        }
        @for line in lines { (stroke(&plot, line)) (dots(&plot, line)) }
        (legend(lines))
    }
}

fn stroke(plot: &Plot, line: &Line) -> Markup {
    html! {
        @if let Some(class) = line.stroke {
            @for piece in pieces(&line.points, plot.high[0]).iter().filter(|piece| piece.len() > 1) {
                @let path: Vec<String> = piece.iter().map(|p| format!("{},{}", plot.x(p[0]), plot.y(p[1]))).collect();
                polyline class=(class) style=[line.style("stroke")] points=(path.join(" ")) {}
            }
        }
    }
}

/// Returns the dots of a line, or of those of its points that stand alone.
fn dots(plot: &Plot, line: &Line) -> Markup {
    html! {
        @for piece in pieces(&line.points, plot.high[0]).iter().filter(|piece| line.dots || piece.len() == 1) {
            @for point in piece {
                circle style=[line.style("fill")] cx=(plot.x(point[0])) cy=(plot.y(point[1])) r="3" {}
            }
        }
    }
}

fn legend(lines: &[Line]) -> Markup {
    let named = lines.iter().filter_map(|line| Some((line, &line.named.as_ref()?.1)));
    html! {
        @for (k, (line, name)) in named.enumerate() {
            @let y = SIZE[1] + LEGEND_LINE * (k as f64 + 0.5);
            @if let Some(class) = line.stroke {
                line class=(class) style=[line.style("stroke")] x1=(LEFT) x2=(LEFT + 24.0) y1=(y) y2=(y) {}
            }
            @if line.dots { circle style=[line.style("fill")] cx=(LEFT + 12.0) cy=(y) r="3" {} }
            text x=(LEFT + 30.0) y=(y + 4.0) { (name) }
        }
    }
}

/// The values at the ends of a chart's axes.
struct Plot {
    low: [f64; 2],
    high: [f64; 2],
}

impl Plot {
    fn new(axes: &Axes<'_>, lines: &[Line]) -> Self {
        let least = lines.iter().flat_map(|line| &line.points).map(|p| p[1]).filter(|y| y.is_finite());
        let bottom = if least.fold(0.0, f64::min) < 0.0 { -axes.upto[1] } else { 0.0 };
        let start = if axes.counts { 1.0 } else { 0.0 };
        let end = if axes.upto[0] > start { axes.upto[0] } else { start + 1.0 };
        Self { low: [start, bottom], high: [end, axes.upto[1]] }
    }

    fn x(&self, value: f64) -> f64 {
        let share = (value - self.low[0]) / (self.high[0] - self.low[0]);
        round(LEFT + share * (SIZE[0] - LEFT - RIGHT))
    }

    fn y(&self, value: f64) -> f64 {
        let share = (value - self.low[1]) / (self.high[1] - self.low[1]);
        round(SIZE[1] - BELOW - share * (SIZE[1] - ABOVE - BELOW))
    }

    fn ticks_along_x(&self, axes: &Axes<'_>) -> Vec<f64> {
        if axes.counts { counts(self.high[0] as usize) } else { ticks(self.low[0], self.high[0]).collect() }
    }
}

/// Returns five numbers from one end of an axis to the other.
fn ticks(from: f64, to: f64) -> impl Iterator<Item = f64> {
    (0..=4).map(move |k| from + (to - from) * f64::from(k) / 4.0)
}

/// Rounds a place to a tenth of a pixel, which makes the text shorter.
fn round(value: f64) -> f64 {
    (value * 10.0).round() / 10.0
}

/// Returns at most six whole numbers from 1 on, and `end` besides if there is room for it.
fn counts(end: usize) -> Vec<f64> {
    let step =
        [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000].into_iter().find(|step| end.div_ceil(*step) <= 6).unwrap_or(end);
    let mut all: Vec<f64> = (1..=end).step_by(step).map(|k| k as f64).collect();
    if end > 1 && all.last() != Some(&(end as f64)) && (end - 1) % step >= step / 2 {
        all.push(end as f64);
    }
    all
}

/// Returns the pieces of a line between its gaps, as far as the chart goes.
fn pieces(points: &[[f64; 2]], end: f64) -> Vec<Vec<[f64; 2]>> {
    let within: Vec<[f64; 2]> = points.iter().copied().filter(|p| p[0] <= end + 1e-9).collect();
    within.split(|p| !p[1].is_finite()).filter(|piece| !piece.is_empty()).map(<[_]>::to_vec).collect()
}

/// Writes a number at an axis, without zeros at its end.
fn label(value: f64) -> String {
    let text = number(value);
    if !text.contains('.') || text.contains('e') {
        return text;
    }
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axes(counts: bool, upto: [f64; 2]) -> Axes<'static> {
        Axes { title: "a < b", x: "x", y: "", upto, counts, limit: None }
    }

    #[test]
    fn a_line_is_a_stroke_and_dots_at_its_values() {
        let line = Line { dots: true, ..Line::new("thick", vec![[0.0, 0.0], [10.0, 4.0]]) };
        let text = chart(&axes(false, [10.0, 4.0]), &[line]).into_string();
        assert!(text.contains(r#"<polyline class="thick" points="66,220 468,28">"#), "{text}");
        assert!(text.contains(r#"cx="66" cy="220" r="3""#) && text.contains(r#"cx="468" cy="28" r="3""#), "{text}");
        assert!(text.contains(">a &lt; b<") && text.contains(">2.5<") && text.contains(">3<"), "{text}");
    }

    #[test]
    fn a_gap_parts_a_line_and_a_point_alone_is_a_dot() {
        let points = vec![[1.0, 1.0], [2.0, 2.0], [3.0, f64::NAN], [4.0, 1.0]];
        let text = chart(&axes(true, [4.0, 2.0]), &[Line::new("thin", points)]).into_string();
        assert_eq!((text.matches("<polyline").count(), text.matches("<circle").count()), (1, 1), "{text}");
    }

    #[test]
    fn a_file_has_colours_of_its_own_that_are_those_of_a_page_in_light() {
        let named = Line { dots: true, points: vec![[1.0, 1.0]], ..Line::default() }.named("var(--bad)", "exchanged");
        let text = file(&axes(true, [4.0, 2.0]), &[Line::new("thick", vec![[1.0, 1.0], [2.0, 2.0]]), named]);
        assert!(text.starts_with("<svg xmlns=") && !text.contains("var("), "{text}");
        assert!(text.contains(r#"style="fill:#b3261e""#) && text.contains(">exchanged<"), "{text}");
        let light = include_str!("style.css").split('}').next().unwrap();
        for (variable, colour) in COLOURS {
            let name = &variable["var(".len()..variable.len() - 1];
            assert!(light.contains(&format!("{name}: {colour};")), "{name}");
        }
    }

    #[test]
    fn counts_are_few_and_reach_from_one_to_the_end() {
        assert_eq!(counts(1), [1.0]);
        assert_eq!(counts(12), [1.0, 3.0, 5.0, 7.0, 9.0, 11.0, 12.0]);
        assert_eq!(counts(100), [1.0, 21.0, 41.0, 61.0, 81.0, 100.0]);
    }

    #[test]
    fn the_top_of_an_axis_is_round() {
        assert_eq!([0.0, 0.3, 1.0, 7.0, 12.0, 400.0].map(round_up), [1.0, 0.5, 1.0, 10.0, 20.0, 500.0]);
    }
}
