//! Text in pictures, in the fixed-width fonts that embedded-graphics brings (ISO 8859-1).

use crate::colour::Colour;
use crate::picture::{Picture, Rect};
use embedded_graphics::Drawable;
use embedded_graphics::geometry::Point;
use embedded_graphics::mono_font::{MonoFont, MonoTextStyle, iso_8859_1 as fonts};
use embedded_graphics::pixelcolor::Rgb888;
use embedded_graphics::text::{Baseline, Text};

/// The size of text.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Size {
    /// 6 × 13 pixels a character, for ticks and labels of dots.
    Small,
    /// 7 × 13 pixels a character, bold, for captions.
    #[default]
    Normal,
    /// 10 × 20 pixels a character, for titles.
    Large,
}

impl Size {
    /// Returns the pixels from one character to the next.
    pub fn advance(self) -> u32 {
        self.font().character_size.width
    }

    /// Returns the pixels from the top of a line to the next.
    pub fn height(self) -> u32 {
        self.font().character_size.height
    }

    /// Returns the width in pixels of a text drawn by [`Picture::text`].
    pub fn width(self, text: &str) -> u32 {
        u32::try_from(text.chars().count()).map_or(u32::MAX, |count| count.saturating_mul(self.advance()))
    }

    /// Returns the text, or the beginning that fits into `width` pixels with "…" after it.
    ///
    /// The result is empty if there is no room for "…".
    pub fn shortened(self, text: &str, width: u32) -> String {
        let room = (width / self.advance()) as usize;
        if text.chars().nth(room).is_none() {
            return text.to_string();
        }
        if room == 0 {
            return String::new();
        }
        let kept: String = text.chars().take(room - 1).collect();
        format!("{}…", kept.trim_end())
    }

    fn font(self) -> &'static MonoFont<'static> {
        match self {
            Self::Small => &fonts::FONT_6X13,
            Self::Normal => &fonts::FONT_7X13_BOLD,
            Self::Large => &fonts::FONT_10X20,
        }
    }
}

impl Picture {
    /// Writes a line of text with its upper left corner at a place.
    ///
    /// Typographic dashes, quotes and minus signs become plain ones. Other characters that the font lacks become "?".
    pub fn text(&mut self, x: i32, y: i32, text: &str, size: Size, colour: Colour) {
        let advance = size.advance() as i32;
        let style = MonoTextStyle::new(size.font(), Rgb888::new(colour[0], colour[1], colour[2]));
        let mut buffer = [0; 4];
        for (column, character) in text.chars().enumerate() {
            // Far to the right everything is out of sight, and the sum must not overflow.
            let Some(left) = i32::try_from(column).ok().and_then(|c| c.checked_mul(advance)?.checked_add(x)) else {
                break;
            };
            if i64::from(left) >= i64::from(self.width) || i64::from(y) >= i64::from(self.height) {
                break;
            }
            if left.saturating_add(advance) < 0 || y.saturating_add(size.height() as i32) < 0 {
                continue;
            }
            if character == '…' {
                self.ellipsis(left, y, size, colour);
                continue;
            }
            let glyph: &str = printable(character).encode_utf8(&mut buffer);
            // Drawing on a picture cannot fail: its error type has no value.
            let Ok(_) = Text::with_baseline(glyph, Point::new(left, y), style, Baseline::Top).draw(self);
        }
    }

    /// Draws "…", which the fonts lack, as three dots in the width of one character.
    fn ellipsis(&mut self, x: i32, y: i32, size: Size, colour: Colour) {
        let font = size.font();
        let dot = (font.character_size.width / 7).max(1);
        let step = font.character_size.width as i32 / 3;
        for i in 0..3 {
            let rect = Rect { x: x + i * step, y: y + font.baseline as i32 - dot as i32 + 1, width: dot, height: dot };
            self.fill(rect, colour);
        }
    }
}

/// Returns the character, or its replacement in ISO 8859-1.
fn printable(character: char) -> char {
    match character {
        ' '..='~' | '\u{a1}'..='\u{ff}' => character,
        '\t' | '\n' | '\r' | '\u{a0}' | '\u{2000}'..='\u{200a}' | '\u{202f}' => ' ',
        '\u{2010}'..='\u{2015}' | '\u{2212}' => '-',
        '\u{2018}' | '\u{2019}' => '\'',
        '\u{201c}' | '\u{201d}' => '"',
        _ => '?',
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::colour::{INK, WHITE};

    fn written(text: &str) -> Picture {
        let mut picture = Picture::new(200, 24, WHITE);
        picture.text(2, 2, text, Size::Normal, INK);
        picture
    }

    #[test]
    fn text_fills_the_width_it_says() {
        let picture = written("gallop");
        let right = (0..200).rev().find(|&x| (0..24).any(|y| picture.at(x, y) == Some(INK)));
        let right = right.expect("some ink") + 1;
        let end = 2 + Size::Normal.width("gallop") as i32;
        assert!(right <= end && right > end - 7, "{right} of {end}");
    }

    #[test]
    fn long_text_is_shortened_to_the_room_there_is() {
        assert_eq!(Size::Small.shortened("horse-01", 48), "horse-01");
        assert_eq!(Size::Small.shortened("horse-01", 47), "horse-…");
        assert_eq!(Size::Small.shortened("horse", 6), "…");
        assert_eq!(Size::Small.shortened("horse", 5), "");
        assert_eq!(Size::Small.shortened("", 0), "");
        assert_eq!(Size::Small.shortened("naïve é", 36), "naïve…");
    }

    #[test]
    fn what_the_font_lacks_becomes_a_question_mark_and_the_rest_stays() {
        assert_eq!(written("馬"), written("?"));
        assert_eq!(written("1 − 2 – 3"), written("1 - 2 - 3"));
        assert_ne!(written("é"), written("?"));
        assert_ne!(written("°"), written("?"));
        assert_ne!(written("…"), written("?"));
    }

    #[test]
    fn text_beyond_the_edges_is_left_out() {
        let mut picture = Picture::new(9, 9, WHITE);
        for (x, y) in [(i32::MAX, 0), (i32::MIN, 0), (0, i32::MAX), (0, i32::MIN), (i32::MAX - 3, i32::MAX - 3)] {
            picture.text(x, y, "horse…", Size::Large, INK);
        }
        assert_eq!(picture, Picture::new(9, 9, WHITE));
    }
}
