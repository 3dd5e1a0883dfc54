//! The colours of values.

use crate::colour::{Colour, from_oklab};
use std::sync::LazyLock;

/// The anchors of the colour map as chroma and hue (degrees) in OKLab: sand, ochre, vermilion, crimson, violet.
const ANCHORS: [(f64, f64); 5] = [(0.022, 95.0), (0.112, 80.0), (0.165, 45.0), (0.160, 10.0), (0.100, -48.0)];
/// OKLab lightness at the low and the high end.
const LIGHTNESS: [f64; 2] = [0.945, 0.27];

/// A scale of colours from `low` (light) to `high` (dark).
///
/// Lightness falls evenly in OKLab while the hue goes from sand over vermilion to violet. So the order of values shows in
/// grey print and to the colour-blind, and on a white page much of a quantity is much ink.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// The value of the lightest colour.
    pub low: f64,
    /// The value of the darkest colour; greater values have it too.
    pub high: f64,
    /// Whether there are values above `high`, which the [legend](crate::legend()) shows.
    pub over: bool,
}

impl Scale {
    /// Returns a scale from `low` to `high`, with no values above it.
    pub fn new(low: f64, high: f64) -> Self {
        Self { low, high, over: false }
    }

    /// Returns a scale with round ends for values, to be taken over all poses of a comparison.
    ///
    /// It begins at 0, or at the least value if that is negative. It ends where all but the greatest two in a hundred lie,
    /// so that a few outliers do not make all else look alike. Values that are not finite do not count; without any the
    /// scale is 0 to 1.
    pub fn covering(values: impl IntoIterator<Item = f64>) -> Self {
        let mut values: Vec<f64> = values.into_iter().filter(|value| value.is_finite()).collect();
        values.sort_unstable_by(f64::total_cmp);
        let (Some(&least), Some(&greatest)) = (values.first(), values.last()) else { return Self::new(0.0, 1.0) };
        // Rounded up, so that with few values none is an outlier.
        let common = values[((values.len() - 1) as f64 * 0.98).ceil() as usize];
        let low = least.min(0.0);
        let high = if common > low { common } else { greatest };
        let step = step(high - low, 5);
        if !(step.is_finite() && step > 0.0) {
            return Self::new(low, if low < 0.0 { 0.0 } else { 1.0 });
        }
        let (low, high) = ((low / step).floor(), (high / step - 1e-9).ceil());
        let (low, high) = (multiple(low, step), multiple(high, step));
        Self { low, high, over: greatest > high }
    }

    /// Returns the colour of a value: beyond an end that of the end, and for NaN [grey](crate::colour::GREY).
    pub fn colour(&self, value: f64) -> Colour {
        let place = self.place(value);
        if place.is_nan() { crate::colour::GREY } else { Self::colour_at(place) }
    }

    /// Returns at most `max_count` round numbers on the scale, 1, 2 or 5 times a power of ten apart.
    ///
    /// A `max_count` below 2 counts as 2. An empty scale has none.
    pub fn ticks(&self, max_count: usize) -> Vec<f64> {
        let max_count = max_count.max(2);
        // As many parts as numbers may give one number too many, where both ends are round.
        let ticks = |parts: usize| -> Option<Vec<f64>> {
            let step = step(self.high - self.low, parts);
            let (first, last) = ((self.low / step - 1e-9).ceil(), (self.high / step + 1e-9).floor());
            // Beyond 2^53 neighbouring multiples are no longer told apart.
            let count = if first.abs().max(last.abs()) < 9e15 { last - first + 1.0 } else { f64::NAN };
            let fits = (0.0..=max_count as f64).contains(&count);
            fits.then(|| (0..count as usize).map(|i| multiple(first + i as f64, step)).collect())
        };
        ticks(max_count).or_else(|| ticks(max_count - 1)).unwrap_or_default()
    }

    /// Returns the place of a value: 0 at the low end, 1 at the high end, at most a thousand lengths beyond either.
    pub(crate) fn place(&self, value: f64) -> f32 {
        let length = self.high - self.low;
        let place = if length > 0.0 && length.is_finite() {
            (value - self.low) / length
        } else {
            // An empty scale: what lies above it is high.
            value.partial_cmp(&self.high).map_or(f64::NAN, |order| f64::from(i8::from(order.is_gt())))
        };
        place.clamp(-1e3, 1e3) as f32
    }

    /// Returns the colour at a place from 0 to 1.
    pub(crate) fn colour_at(place: f32) -> Colour {
        static COLOURS: LazyLock<[Colour; 256]> = LazyLock::new(|| std::array::from_fn(|i| formula(i as f64 / 255.0)));
        // Such a cast rounds down, and puts what is below zero, and not a number, at zero.
        COLOURS[usize::from((place * 255.0 + 0.5).clamp(0.0, 255.0) as u8)]
    }
}

/// Computes the colour map: straight lines between the anchors' a and b, and one straight line of lightness.
fn formula(place: f64) -> Colour {
    let along = place * (ANCHORS.len() - 1) as f64;
    let from = (along as usize).min(ANCHORS.len() - 2);
    let share = along - from as f64;
    let ab = |(chroma, hue): (f64, f64)| [chroma * hue.to_radians().cos(), chroma * hue.to_radians().sin()];
    let ([a, b], [next_a, next_b]) = (ab(ANCHORS[from]), ab(ANCHORS[from + 1]));
    let lightness = LIGHTNESS[0] + (LIGHTNESS[1] - LIGHTNESS[0]) * place;
    from_oklab([lightness, a + (next_a - a) * share, b + (next_b - b) * share])
}

/// Returns the least of 1, 2 and 5 times a power of ten of which at most `parts` go into a length.
fn step(length: f64, parts: usize) -> f64 {
    let least = length / parts as f64;
    if !(least.is_finite() && least > 0.0) {
        return f64::NAN;
    }
    let exponent = least.log10().floor() as i32;
    // Read from its decimal form, a step is the nearest number to what is written.
    let decimal = |digit: u32, exponent: i32| format!("{digit}e{exponent}").parse().unwrap_or(f64::NAN);
    let steps = [decimal(1, exponent), decimal(2, exponent), decimal(5, exponent), decimal(1, exponent + 1)];
    steps.into_iter().find(|step| *step >= least * (1.0 - 1e-9)).unwrap_or(f64::NAN)
}

/// Returns a multiple of a step without the rounding that would show as 0.30000000000000004.
fn multiple(count: f64, step: f64) -> f64 {
    let over = (1.0 / step).round();
    // Steps of 0.1, 0.02, 0.005 and so on divide a whole number exactly.
    if step < 1.0 && over < 9e15 && (1.0 / over - step).abs() <= step * 1e-15 { count / over } else { count * step }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::colour::{GREY, to_oklab};
    use proptest::prelude::*;

    #[test]
    fn lightness_falls_with_every_step_of_the_map() {
        for i in 0..64 {
            let [here, next] = [i, i + 1].map(|i| to_oklab(Scale::new(0.0, 64.0).colour(f64::from(i)))[0]);
            assert!(next < here - 0.005, "{i}: {here} {next}");
        }
    }

    #[test]
    fn the_map_stays_within_what_a_screen_shows() {
        for i in 0..=255 {
            let colour = Scale::colour_at(i as f32 / 255.0);
            let expected = LIGHTNESS[0] + (LIGHTNESS[1] - LIGHTNESS[0]) * f64::from(i) / 255.0;
            // Half a step of eight bits a channel; a channel cut off at its limit would be much farther off.
            assert!((to_oklab(colour)[0] - expected).abs() < 0.006, "{i}: {colour:?}");
        }
    }

    #[test]
    fn values_beyond_the_ends_have_the_ends_colours() {
        let scale = Scale::new(1.0, 3.0);
        assert_eq!(scale.colour(f64::INFINITY), scale.colour(3.0));
        assert_eq!(scale.colour(-7.0), scale.colour(1.0));
        assert_eq!(scale.colour(f64::NAN), GREY);
        assert_ne!(scale.colour(1.0), scale.colour(3.0));
    }

    #[test]
    fn ticks_are_round() {
        assert_eq!(Scale::new(0.0, 1.0).ticks(6), [0.0, 0.2, 0.4, 0.6, 0.8, 1.0]);
        assert_eq!(Scale::new(0.0, 0.037).ticks(5), [0.0, 0.01, 0.02, 0.03]);
        assert_eq!(Scale::new(-3.0, 12.0).ticks(5), [0.0, 5.0, 10.0]);
        assert_eq!(Scale::new(0.0, 4.1e7).ticks(6), [0.0, 1e7, 2e7, 3e7, 4e7]);
        assert!(Scale::new(1.0, 1.0).ticks(5).is_empty() && Scale::new(0.0, f64::NAN).ticks(5).is_empty());
    }

    #[test]
    fn a_scale_covers_all_but_outliers_with_round_ends() {
        let mut values: Vec<f64> = (0..1000).map(|i| f64::from(i) * 1e-5).collect();
        assert_eq!(Scale::covering(values.iter().copied()), Scale::new(0.0, 0.01));
        values.extend([3.0, f64::NAN, f64::INFINITY]);
        assert_eq!(Scale::covering(values), Scale { low: 0.0, high: 0.01, over: true });
        assert_eq!(Scale::covering([0.5, 3.0]), Scale::new(0.0, 3.0));
        assert_eq!(Scale::covering([0.0, 0.0]), Scale::new(0.0, 1.0));
        assert_eq!(Scale::covering([]), Scale::new(0.0, 1.0));
    }

    proptest! {
        #[test]
        fn ticks_lie_on_the_scale_and_are_few(low in -1e3..1e3, length in 1e-9..1e9, max_count in 2usize..12) {
            let low = low * length;
            let scale = Scale::new(low, low + length);
            let ticks = scale.ticks(max_count);
            prop_assert!(ticks.len() <= max_count);
            // A billionth of a step beyond an end counts as on it, and a step is at most ten lengths.
            prop_assert!(ticks.iter().all(|t| *t >= low - 1e-6 * length && *t <= scale.high + 1e-6 * length));
        }

        #[test]
        fn any_scale_and_value_give_a_colour(low: f64, high: f64, value: f64) {
            let scale = Scale::new(low, high);
            scale.colour(value);
            scale.ticks(7);
            Scale::covering([low, high, value]);
        }
    }
}
