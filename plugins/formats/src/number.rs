//! Numbers as text: short, and as exact as positions need to be.

use std::io::Write;

/// The number of decimals that coordinates are written with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Decimals(Option<u32>);

/// More decimals than this are written in scientific notation instead.
const MAX_DECIMALS: u32 = 18;

impl Decimals {
    /// As many decimals as keep each coordinate to 5e-10 of `diagonal`, and at least `least`.
    pub fn for_positions(diagonal: f64, least: u32) -> Self {
        let needed = -(1e-9 * diagonal).log10();
        if !needed.is_finite() || needed > f64::from(MAX_DECIMALS) {
            return Self(None);
        }
        Self(Some(least.max(needed.ceil().max(0.0) as u32).min(MAX_DECIMALS)))
    }

    /// Exactly `places` decimals, at most 18.
    pub fn fixed(places: u32) -> Self {
        Self(Some(places.min(MAX_DECIMALS)))
    }

    /// Appends `x`; a number too large for the decimals is written with the fewest digits that give it back.
    pub fn push(self, out: &mut Vec<u8>, x: f64) {
        match self.0 {
            Some(places) => push_fixed(out, x, places),
            None => push_shortest(out, x),
        }
    }
}

/// `x` with `places` decimals, rounded from x · 10^places while that is an integer well below 2^53.
fn push_fixed(out: &mut Vec<u8>, x: f64, places: u32) {
    let unit = 10_u64.pow(places);
    let scaled = (x.abs() * unit as f64).round();
    if scaled.is_nan() || scaled >= (1_u64 << 51) as f64 {
        return push_shortest(out, x);
    }
    let scaled = scaled as u64;
    if x < 0.0 && scaled > 0 {
        out.push(b'-');
    }
    let mut digits = [b'0'; 24];
    let mut start = digits.len();
    let mut rest = scaled;
    let mut written = 0;
    while rest > 0 || written <= places {
        if written == places && places > 0 {
            start -= 1;
            digits[start] = b'.';
        }
        start -= 1;
        digits[start] = b'0' + (rest % 10) as u8;
        rest /= 10;
        written += 1;
    }
    out.extend_from_slice(&digits[start..]);
}

/// The fewest digits that read back as `x`.
fn push_shortest(out: &mut Vec<u8>, x: f64) {
    let size = x.abs();
    let written = if size == 0.0 || (1e-5..1e16).contains(&size) { write!(out, "{x}") } else { write!(out, "{x:e}") };
    written.expect("a vector takes what is written to it");
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn text(decimals: Decimals, x: f64) -> String {
        let mut out = Vec::new();
        decimals.push(&mut out, x);
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn fixed_decimals_are_padded_and_rounded() {
        let three = Decimals::fixed(3);
        let cases = [(0.0, "0.000"), (-0.0, "0.000"), (1.0, "1.000"), (-0.0125, "-0.013"), (12.9996, "13.000")];
        for (x, expected) in cases {
            assert_eq!(text(three, x), expected);
        }
        assert_eq!(text(Decimals::fixed(0), -41.6), "-42");
        assert_eq!(text(Decimals::fixed(18), 1e-3), "0.001000000000000000");
    }

    #[test]
    fn extreme_numbers_are_written_with_the_fewest_digits() {
        assert_eq!(text(Decimals::fixed(6), 1e300), "1e300");
        assert_eq!(text(Decimals::for_positions(1e-30, 6), 1.25e-31), "1.25e-31");
        assert_eq!(text(Decimals::for_positions(0.0, 6), 0.5), "0.5");
    }

    proptest! {
        /// Half a unit in the last decimal is 5e-10 of the diagonal by definition; the rest is rounding of the product.
        #[test]
        fn positions_come_back_to_5e_10_of_the_diagonal(exponent in -20..20, x in -1.0..1.0_f64) {
            let diagonal = 10_f64.powi(exponent);
            let x = x * diagonal;
            let back: f64 = text(Decimals::for_positions(diagonal, 0), x).parse().unwrap();
            prop_assert!((back - x).abs() <= 5.01e-10 * diagonal);
        }
    }
}
