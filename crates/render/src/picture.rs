//! Pictures of pixels that can be filled, pasted and drawn on.

use crate::colour::{Colour, mix};
use embedded_graphics::Pixel;
use embedded_graphics::draw_target::DrawTarget;
use embedded_graphics::geometry::{OriginDimensions, Size as Extent};
use embedded_graphics::pixelcolor::{Rgb888, RgbColor};
use std::convert::Infallible;

/// A rectangle in pixels; x goes right and y down.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rect {
    /// The left edge.
    pub x: i32,
    /// The upper edge.
    pub y: i32,
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
}

impl Rect {
    /// Returns whether the two share a pixel.
    pub fn overlaps(&self, other: &Rect) -> bool {
        let apart = |a: i32, a_length: u32, b: i32, b_length: u32| {
            i64::from(a) + i64::from(a_length) <= i64::from(b) || i64::from(b) + i64::from(b_length) <= i64::from(a)
        };
        !apart(self.x, self.width, other.x, other.width) && !apart(self.y, self.height, other.y, other.height)
    }

    /// Clamps the rectangle so that sums of its edges do not overflow; what is clamped lies out of sight.
    pub(crate) fn within_reach(&self) -> Rect {
        const REACH: i32 = 1 << 24;
        Rect {
            x: self.x.clamp(-REACH, REACH),
            y: self.y.clamp(-REACH, REACH),
            width: self.width.min(REACH as u32),
            height: self.height.min(REACH as u32),
        }
    }

    /// Returns whether all of `other` lies inside.
    pub fn contains(&self, other: &Rect) -> bool {
        let inside = |a: i32, a_length: u32, b: i32, b_length: u32| {
            a <= b && i64::from(b) + i64::from(b_length) <= i64::from(a) + i64::from(a_length)
        };
        inside(self.x, self.width, other.x, other.width) && inside(self.y, self.height, other.y, other.height)
    }
}

/// A picture of pixels; what is drawn beyond its edges is left out.
///
/// It is a [`DrawTarget`] of embedded-graphics, so anything drawn by that crate can be added.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// `width` × `height` colours, row by row from the upper left.
    pub pixels: Vec<Colour>,
}

impl Picture {
    /// Returns a picture of one colour.
    pub fn new(width: u32, height: u32, background: Colour) -> Self {
        Self { width, height, pixels: vec![background; width as usize * height as usize] }
    }

    /// Returns the colour of a pixel; `None` outside the picture.
    pub fn at(&self, x: i32, y: i32) -> Option<Colour> {
        self.index(x, y).and_then(|i| self.pixels.get(i).copied())
    }

    /// Covers a pixel with a colour, to the share `cover` (0 to 1).
    pub fn blend(&mut self, x: i32, y: i32, colour: Colour, cover: f64) {
        if let Some(pixel) = self.index(x, y).and_then(|i| self.pixels.get_mut(i)) {
            *pixel = mix(*pixel, colour, cover);
        }
    }

    /// Fills a rectangle.
    pub fn fill(&mut self, rect: Rect, colour: Colour) {
        let (columns, rows) = self.visible(rect);
        for y in rows {
            let row = y * self.width as usize;
            if let Some(pixels) = self.pixels.get_mut(row + columns.start..row + columns.end) {
                pixels.fill(colour);
            }
        }
    }

    /// Draws the edge of a rectangle, one pixel wide and inside it.
    pub fn frame(&mut self, rect: Rect, colour: Colour) {
        let Rect { x, y, width, height } = rect;
        if width == 0 || height == 0 {
            return;
        }
        self.fill(Rect { height: 1, ..rect }, colour);
        self.fill(Rect { y: y.saturating_add_unsigned(height - 1), height: 1, ..rect }, colour);
        self.fill(Rect { width: 1, ..rect }, colour);
        self.fill(Rect { x: x.saturating_add_unsigned(width - 1), width: 1, ..rect }, colour);
    }

    /// Draws a smooth-edged disc around a place, counted in pixels from the upper left corner of the picture.
    pub fn disc(&mut self, x: f64, y: f64, radius: f64, colour: Colour) {
        self.ring(x, y, 0.0, radius, colour, 1.0);
    }

    /// Draws a smooth-edged ring from the radius `inner` to `outer`, covering to the share `cover` (0 to 1).
    ///
    /// If `inner` is 0 the ring is a disc.
    pub fn ring(&mut self, x: f64, y: f64, inner: f64, outer: f64, colour: Colour, cover: f64) {
        if !(x.is_finite() && y.is_finite() && outer.is_finite() && outer > 0.0) {
            return;
        }
        let clip = |from: f64, to: f64, end: u32| from.max(0.0) as i32..to.clamp(0.0, f64::from(end)) as i32;
        for row in clip((y - outer - 1.0).floor(), (y + outer + 1.0).ceil(), self.height) {
            for column in clip((x - outer - 1.0).floor(), (x + outer + 1.0).ceil(), self.width) {
                let distance = (f64::from(column) + 0.5 - x).hypot(f64::from(row) + 0.5 - y);
                let outside = (outer + 0.5 - distance).clamp(0.0, 1.0);
                let hole = if inner > 0.0 { (inner + 0.5 - distance).clamp(0.0, 1.0) } else { 0.0 };
                self.blend(column, row, colour, (outside - hole) * cover);
            }
        }
    }

    /// Copies another picture into this one, its upper left corner at a pixel.
    pub fn paste(&mut self, other: &Picture, x: i32, y: i32) {
        let rect = Rect { x, y, width: other.width, height: other.height };
        let (columns, rows) = self.visible(rect);
        for row in rows {
            let to = row * self.width as usize;
            let from = (row as i64 - i64::from(y)) as usize * other.width as usize;
            let shift = (columns.start as i64 - i64::from(x)) as usize;
            let source = other.pixels.get(from + shift..from + shift + columns.len());
            let target = self.pixels.get_mut(to + columns.start..to + columns.end);
            if let (Some(source), Some(target)) = (source, target) {
                target.copy_from_slice(source);
            }
        }
    }

    /// Returns the columns and rows of a rectangle that lie in the picture.
    fn visible(&self, rect: Rect) -> (std::ops::Range<usize>, std::ops::Range<usize>) {
        let clip = |from: i32, length: u32, end: u32| {
            let start = i64::from(from).clamp(0, i64::from(end));
            let stop = (i64::from(from) + i64::from(length)).clamp(start, i64::from(end));
            start as usize..stop as usize
        };
        let columns = clip(rect.x, rect.width, self.width);
        let rows = if columns.is_empty() { 0..0 } else { clip(rect.y, rect.height, self.height) };
        (columns, rows)
    }

    fn index(&self, x: i32, y: i32) -> Option<usize> {
        let (x, y) = (u32::try_from(x).ok()?, u32::try_from(y).ok()?);
        (x < self.width && y < self.height).then(|| y as usize * self.width as usize + x as usize)
    }
}

impl OriginDimensions for Picture {
    fn size(&self) -> Extent {
        Extent::new(self.width, self.height)
    }
}

impl DrawTarget for Picture {
    type Color = Rgb888;
    type Error = Infallible;

    fn draw_iter<I: IntoIterator<Item = Pixel<Rgb888>>>(&mut self, pixels: I) -> Result<(), Infallible> {
        for Pixel(at, colour) in pixels {
            self.blend(at.x, at.y, [colour.r(), colour.g(), colour.b()], 1.0);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::colour::{INK, WHITE};

    #[test]
    fn a_disc_covers_its_area() {
        let mut picture = Picture::new(60, 60, WHITE);
        picture.disc(30.2, 29.7, 20.0, [0, 0, 0]);
        let area: f64 = picture.pixels.iter().map(|p| 1.0 - f64::from(p[0]) / 255.0).sum();
        let expected = std::f64::consts::PI * 400.0;
        // A linear ramp of one pixel along the rim is exact for a straight edge, and nearly so for a circle.
        assert!((area / expected - 1.0).abs() < 2e-3, "{area} of {expected}");
    }

    #[test]
    fn what_lies_outside_is_left_out() {
        let mut picture = Picture::new(4, 3, WHITE);
        let stamp = Picture::new(3, 3, INK);
        picture.paste(&stamp, -2, -2);
        picture.paste(&stamp, i32::MAX, i32::MIN);
        picture.paste(&stamp, 100, 0);
        picture.fill(Rect { x: 3, y: 2, width: u32::MAX, height: 1 }, INK);
        picture.frame(Rect { x: i32::MAX - 1, y: 0, width: 9, height: 9 }, INK);
        picture.disc(1e300, f64::NAN, 3.0, INK);
        picture.disc(-1e300, 0.0, 3.0, INK);
        assert_eq!(picture.pixels.iter().filter(|p| **p == INK).count(), 2);
        assert_eq!(picture.at(0, 0), Some(INK));
        assert_eq!(picture.at(3, 2), Some(INK));
        assert_eq!(picture.at(4, 2), None);
    }

    #[test]
    fn rectangles_that_only_touch_do_not_overlap() {
        let left = Rect { x: 0, y: 0, width: 10, height: 10 };
        assert!(!left.overlaps(&Rect { x: 10, ..left }));
        assert!(left.overlaps(&Rect { x: 9, ..left }));
        assert!(left.contains(&left) && !left.contains(&Rect { x: 1, ..left }));
    }
}
