//! The bar that explains the colours of values.

use crate::colour::{FAINT, INK};
use crate::picture::{Picture, Rect};
use crate::scale::Scale;
use crate::text::Size;

const SIZE: Size = Size::Small;
/// The length of a tick in pixels.
const TICK: u32 = 4;
/// Pixels of the bar's shorter side, and of the tip for values over the end.
const THICKNESS: u32 = 12;
const TIP: u32 = 7;
/// The greatest length of a bar in pixels; a longer one would take time and no picture shows it.
const MAX_LENGTH: u32 = 1 << 14;

/// Draws a scale's colours as a bar with round numbers and a unit into an area of a picture.
///
/// The bar runs along the longer side of the area, to the right or upwards. If values lie over its end, it has a tip
/// there, and the number begins with ">". About 200 × 30 or 80 × 150 pixels read well; a smaller area lacks numbers.
pub fn legend(picture: &mut Picture, area: Rect, scale: &Scale, unit: &str) {
    let area = area.within_reach();
    if area.width >= area.height { across(picture, area, scale, unit) } else { upwards(picture, area, scale, unit) }
}

fn across(picture: &mut Picture, area: Rect, scale: &Scale, unit: &str) {
    let unit = SIZE.shortened(unit, area.width / 3);
    // Half a number hangs over either end; the unit stands to the right of the bar.
    let labels = labels(scale, 6);
    let overhang = labels.iter().map(|label| SIZE.width(&label.text)).max().unwrap_or(0) / 2;
    let tip = if scale.over { TIP } else { 0 };
    let right = if unit.is_empty() { overhang.max(tip) } else { (SIZE.width(&unit) + 6 + tip).max(overhang) };
    let length = area.width.saturating_sub(overhang + right).min(MAX_LENGTH);
    if length < 8 || area.height < SIZE.height() {
        return;
    }
    let left = area.x + overhang as i32;
    for column in 0..length + tip {
        let colour = Scale::colour_at(column as f32 / (length - 1) as f32);
        let narrow = (column.saturating_sub(length) * THICKNESS / 2).checked_div(tip).unwrap_or(0);
        let rect =
            Rect { x: left + column as i32, y: area.y + narrow as i32, width: 1, height: THICKNESS - 2 * narrow };
        picture.fill(rect, colour);
    }
    if !scale.over {
        picture.frame(Rect { x: left, y: area.y, width: length, height: THICKNESS }, FAINT);
    }
    picture.text(left + (length + tip) as i32 + 6, area.y, &unit, SIZE, INK);
    if area.height < THICKNESS + TICK + SIZE.height() {
        return;
    }
    let mut taken: Option<Rect> = None;
    for label in labels.iter().rev() {
        let x = left + (f64::from(length - 1) * label.place).round() as i32;
        picture.fill(Rect { x, y: area.y + THICKNESS as i32, width: 1, height: TICK }, FAINT);
        let width = SIZE.width(&label.text);
        // A ">" before the last number must not push its digits off their tick.
        let shift = if label.over { SIZE.advance() as i32 } else { 0 };
        let at = x - (width as i32 - shift) / 2 - shift;
        let rect = Rect { x: at, y: area.y + (THICKNESS + TICK) as i32, width: width + 4, height: SIZE.height() };
        if taken.is_none_or(|taken| !taken.overlaps(&rect)) {
            picture.text(rect.x, rect.y, &label.text, SIZE, INK);
            taken = Some(rect);
        }
    }
}

fn upwards(picture: &mut Picture, area: Rect, scale: &Scale, unit: &str) {
    let half = SIZE.height() / 2;
    let unit = SIZE.shortened(unit, area.width);
    let heading = if unit.is_empty() { 0 } else { SIZE.height() + 3 };
    let tip = if scale.over { TIP } else { 0 };
    let above = heading + half.max(tip);
    let length = area.height.saturating_sub(above + half).min(MAX_LENGTH);
    if length < 8 || area.width < THICKNESS {
        return;
    }
    picture.text(area.x, area.y, &unit, SIZE, INK);
    let bottom = area.y + (above + length) as i32 - 1;
    for row in 0..length + tip {
        let colour = Scale::colour_at(row as f32 / (length - 1) as f32);
        let narrow = (row.saturating_sub(length) * THICKNESS / 2).checked_div(tip).unwrap_or(0);
        let rect = Rect { x: area.x + narrow as i32, y: bottom - row as i32, width: THICKNESS - 2 * narrow, height: 1 };
        picture.fill(rect, colour);
    }
    if !scale.over {
        picture.frame(Rect { x: area.x, y: area.y + above as i32, width: THICKNESS, height: length }, FAINT);
    }
    let max_count = (length / (SIZE.height() + 4)).clamp(2, 6);
    for label in labels(scale, max_count as usize) {
        let y = bottom - (f64::from(length - 1) * label.place).round() as i32;
        let x = area.x + THICKNESS as i32;
        picture.fill(Rect { x, y, width: TICK, height: 1 }, FAINT);
        let room = area.width.saturating_sub(THICKNESS + TICK + 2);
        if SIZE.width(&label.text) <= room {
            picture.text(x + TICK as i32 + 2, y - half as i32, &label.text, SIZE, INK);
        }
    }
}

/// A number beside the bar.
#[derive(Debug, PartialEq)]
struct Label {
    /// The place along the bar: 0 at the low end, 1 at the high end.
    place: f64,
    text: String,
    /// Whether the text begins with ">".
    over: bool,
}

/// Returns at most `max_count` numbers of a scale; with values over the end, the last is the end itself.
fn labels(scale: &Scale, max_count: usize) -> Vec<Label> {
    let ticks = scale.ticks(max_count);
    let length = scale.high - scale.low;
    let (Some(first), Some(last)) = (ticks.first(), ticks.last()) else { return Vec::new() };
    let step = if ticks.len() > 1 { (last - first) / (ticks.len() - 1) as f64 } else { length };
    let mut labels: Vec<Label> = ticks
        .iter()
        .map(|tick| Label {
            place: ((tick - scale.low) / length).clamp(0.0, 1.0),
            text: number(*tick, step),
            over: false,
        })
        .collect();
    if scale.over {
        labels.retain(|label| label.place < 1.0 - 1e-6);
        labels.push(Label { place: 1.0, text: format!(">{}", number(scale.high, step)), over: true });
    }
    labels
}

/// Writes a number with the decimals that a step of this size needs.
fn number(value: f64, step: f64) -> String {
    let exponent = (step.abs() * (1.0 + 1e-9)).log10().floor();
    let value = if value.abs() < step * 1e-6 { 0.0 } else { value };
    if value == 0.0 && exponent < -4.0 {
        return "0".to_string();
    }
    // At most seven characters stand in a row of zeros; beyond that the exponent is easier to read.
    if value != 0.0 && (exponent < -4.0 || value.abs() >= 1e6) {
        let digits = (value.abs().log10().floor() - exponent).clamp(0.0, 6.0) as usize;
        return format!("{value:.digits$e}");
    }
    format!("{value:.*}", (-exponent).clamp(0.0, 12.0) as usize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::colour::WHITE;
    use proptest::prelude::*;

    fn texts(scale: &Scale) -> Vec<String> {
        labels(scale, 6).into_iter().map(|label| label.text).collect()
    }

    #[test]
    fn numbers_are_round_and_as_long_as_their_step_needs() {
        assert_eq!(texts(&Scale::new(0.0, 1.0)), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(texts(&Scale::new(0.0, 0.02)), ["0.000", "0.005", "0.010", "0.015", "0.020"]);
        assert_eq!(texts(&Scale::new(-100.0, 150.0)), ["-100", "-50", "0", "50", "100", "150"]);
        assert_eq!(texts(&Scale::new(0.0, 3e-6)), ["0", "1e-6", "2e-6", "3e-6"]);
    }

    #[test]
    fn values_over_the_end_are_marked() {
        assert_eq!(texts(&Scale { low: 0.0, high: 20.0, over: true }), ["0", "5", "10", "15", ">20"]);
    }

    #[test]
    fn the_bar_shows_the_scale_from_its_low_to_its_high_end() {
        for area in [Rect { x: 5, y: 5, width: 200, height: 32 }, Rect { x: 5, y: 5, width: 70, height: 180 }] {
            let scale = Scale::new(0.0, 4.0);
            let mut picture = Picture::new(220, 200, WHITE);
            legend(&mut picture, area, &scale, "%");
            let has = |colour| picture.pixels.contains(&colour);
            assert!(has(scale.colour(0.5)) && has(scale.colour(2.0)) && has(scale.colour(3.5)));
            let outside = (0..200).flat_map(|y| (0..220).map(move |x| (x, y)));
            let outside = outside.filter(|&(x, y)| !area.contains(&Rect { x, y, width: 1, height: 1 }));
            assert!(outside.into_iter().all(|(x, y)| picture.at(x, y) == Some(WHITE)));
        }
    }

    proptest! {
        #[test]
        fn any_area_and_scale_are_drawn_without_harm(
            x in -300i32..300, y in -300i32..300, width in 0u32..300, height in 0u32..300, low: f64, high: f64, over: bool
        ) {
            let mut picture = Picture::new(100, 100, WHITE);
            legend(&mut picture, Rect { x, y, width, height }, &Scale { low, high, over }, "% of the diagonal");
        }
    }
}
