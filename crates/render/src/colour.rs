//! The colours of pictures, mixing, and OKLab, in which equal steps look equal.

/// A colour in sRGB: red, green and blue, 0 to 255.
pub type Colour = [u8; 3];

/// The colour of the page.
pub const WHITE: Colour = [255, 255, 255];
/// The colour of text and outlines.
pub const INK: Colour = [33, 37, 43];
/// The colour of captions of less weight, ticks and frames.
pub const FAINT: Colour = [112, 120, 131];
/// The colour of lines between cells.
pub const RULE: Colour = [222, 226, 231];
/// The colour of vertices without a value.
pub const GREY: Colour = [176, 180, 186];
/// The colour of a source's surface.
pub const STEEL: Colour = [152, 179, 214];
/// The colour of a target's surface.
pub const SAND: Colour = [226, 188, 140];
/// The colour of markers and key points.
pub const CRIMSON: Colour = [200, 30, 60];

/// Returns a colour for the part with this index, unlike those of the indices near it.
///
/// The hue turns by the golden angle, so that the sequence never ends. Lightness alternates between three steps, so that
/// parts differ in grey print and to the colour-blind too.
pub fn of_part(index: usize) -> Colour {
    let hue = index as f64 * 137.507_764_050_037_85_f64.to_radians() + 4.2;
    let lightness = [0.74, 0.62, 0.84][index % 3];
    from_oklab([lightness, 0.115 * hue.cos(), 0.115 * hue.sin()])
}

/// Returns `under`, covered by `over` to the share `cover` (0 to 1).
pub fn mix(under: Colour, over: Colour, cover: f64) -> Colour {
    let cover = if cover.is_finite() { cover.clamp(0.0, 1.0) } else { 0.0 };
    std::array::from_fn(|c| (f64::from(under[c]) + (f64::from(over[c]) - f64::from(under[c])) * cover).round() as u8)
}

/// Returns a colour in OKLab: lightness 0 to 1, green to red, blue to yellow.
///
/// B. Ottosson, "A perceptual color space for image processing", 2020.
pub fn to_oklab(colour: Colour) -> [f64; 3] {
    let [r, g, b] = colour.map(|c| to_linear(f64::from(c) / 255.0));
    let l = (0.412_221_470_8 * r + 0.536_332_536_3 * g + 0.051_445_992_9 * b).cbrt();
    let m = (0.211_903_498_2 * r + 0.680_699_545_1 * g + 0.107_396_956_6 * b).cbrt();
    let s = (0.088_302_461_9 * r + 0.281_718_837_6 * g + 0.629_978_700_5 * b).cbrt();
    [
        0.210_454_255_3 * l + 0.793_617_785_0 * m - 0.004_072_046_8 * s,
        1.977_998_495_1 * l - 2.428_592_205_0 * m + 0.450_593_709_9 * s,
        0.025_904_037_1 * l + 0.782_771_766_2 * m - 0.808_675_766_0 * s,
    ]
}

/// Returns the sRGB colour of OKLab coordinates; each channel is clamped to the range of a screen.
pub fn from_oklab([l, a, b]: [f64; 3]) -> Colour {
    let long = (l + 0.396_337_777_4 * a + 0.215_803_757_3 * b).powi(3);
    let medium = (l - 0.105_561_345_8 * a - 0.063_854_172_8 * b).powi(3);
    let short = (l - 0.089_484_177_5 * a - 1.291_485_548_0 * b).powi(3);
    [
        4.076_741_662_1 * long - 3.307_711_591_3 * medium + 0.230_969_929_2 * short,
        -1.268_438_004_6 * long + 2.609_757_401_1 * medium - 0.341_319_396_5 * short,
        -0.004_196_086_3 * long - 0.703_418_614_7 * medium + 1.707_614_701_0 * short,
    ]
    .map(|c| (to_srgb(c.clamp(0.0, 1.0)) * 255.0).round() as u8)
}

fn to_linear(c: f64) -> f64 {
    if c <= 0.040_45 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}

fn to_srgb(c: f64) -> f64 {
    if c <= 0.003_130_8 { c * 12.92 } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_colour_survives_oklab_and_back() {
        for r in (0..=255).step_by(15) {
            for g in (0..=255).step_by(15) {
                for b in (0..=255).step_by(15) {
                    assert_eq!(from_oklab(to_oklab([r, g, b])), [r, g, b]);
                }
            }
        }
    }

    #[test]
    fn white_has_lightness_one_and_no_chroma() {
        let [l, a, b] = to_oklab(WHITE);
        // The published matrices are rounded to ten digits.
        assert!((l - 1.0).abs() < 1e-6 && a.abs() < 1e-6 && b.abs() < 1e-6);
    }

    #[test]
    fn parts_that_follow_each_other_differ_in_lightness() {
        for part in 0..60 {
            let step = to_oklab(of_part(part))[0] - to_oklab(of_part(part + 1))[0];
            assert!(step.abs() > 0.05, "parts {part} and {}: {step}", part + 1);
        }
    }

    #[test]
    fn mixing_nothing_keeps_and_mixing_all_covers() {
        assert_eq!(mix(WHITE, INK, 0.0), WHITE);
        assert_eq!(mix(WHITE, INK, 1.0), INK);
        assert_eq!(mix(WHITE, INK, f64::NAN), WHITE);
    }
}
