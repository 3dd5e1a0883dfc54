//! Colours of vertices, which many programs write behind coordinates.

use super::lexer::{Lexer, number};

/// The colours that stand behind coordinates, as `v x y z r g b` or with opacity.
#[derive(Default)]
pub struct Colors {
    /// The parts on each line; those that a line does not have are NaN.
    values: Vec<[f64; 4]>,
    any: bool,
    /// Colours with a part that is no number.
    unreadable: usize,
    /// Lines with other numbers than those of a weight or a colour.
    unknown: usize,
}

impl Colors {
    /// The numbers behind the coordinates of a `v` line; one alone is a weight, which counts for curves only.
    pub fn add(&mut self, lexer: &mut Lexer<'_>, bytes: &[u8]) {
        let mut numbers = [f64::NAN; 5];
        let mut count = 0;
        while let Some(token) = lexer.token() {
            if let Some(place) = numbers.get_mut(count) {
                *place = number(&bytes[token]).unwrap_or(f64::NAN);
            }
            count += 1;
        }
        let [r, g, b, a, _] = numbers;
        let is_color = matches!(count, 3 | 4);
        self.any |= is_color;
        self.unreadable += usize::from(is_color && numbers[..count].iter().any(|x| x.is_nan()));
        self.unknown += usize::from(count == 2 || count > 4);
        self.values.push(if is_color { [r, g, b, a] } else { [f64::NAN; 4] });
    }

    /// Sentences about what behind the coordinates is not understood.
    pub fn warnings(&self) -> Vec<String> {
        let all = [
            (self.unreadable, "`v` lines have a colour that is no number, which was read as 1"),
            (self.unknown, "`v` lines have numbers behind their coordinates that are neither a weight nor a colour"),
        ];
        all.into_iter().filter(|(count, _)| *count > 0).map(|(count, what)| format!("{count} {what}")).collect()
    }

    /// The colours, each part 0 to 1; white and opaque where a line has none. Parts beyond 1 are of 255.
    pub fn finish(mut self) -> Option<Vec<[f64; 4]>> {
        let full = if self.values.iter().flatten().any(|&x| x > 1.0) { 255.0 } else { 1.0 };
        let unit = |x: f64| if x.is_nan() { 1.0 } else { (x / full).clamp(0.0, 1.0) };
        self.values.iter_mut().flatten().for_each(|x| *x = unit(*x));
        self.any.then_some(self.values)
    }
}
