//! Markers and key points: discs with labels that do not cover each other.

use crate::colour::{Colour, FAINT, INK, WHITE, mix};
use crate::picture::{Picture, Rect};
use crate::text::Size;
use crate::view::Placed;
use embedded_graphics::Drawable;
use embedded_graphics::geometry::Point;
use embedded_graphics::pixelcolor::Rgb888;
use embedded_graphics::primitives::{Line, Primitive, PrimitiveStyle};
use nalgebra::Point3;

/// The size of labels.
const SIZE: Size = Size::Small;

/// A marker or a key point to draw.
#[derive(Clone, Debug, PartialEq)]
pub struct Dot {
    /// The position, in the unit of the mesh.
    pub at: Point3<f64>,
    /// A number or a short name that stands beside the disc.
    pub label: Option<String>,
    /// The colour of the disc.
    pub colour: Colour,
}

/// Counts of dots, shown and left out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DotsDrawn {
    /// Visible dots, drawn as discs.
    pub visible: usize,
    /// Dots behind a surface, drawn as faint rings.
    pub hidden: usize,
    /// Dots that are not drawn, because they are not finite or lie outside the picture.
    pub outside: usize,
    /// Labels left out because every place for them was taken.
    pub without_label: usize,
}

/// A dot and its place on the canvas.
#[derive(Clone, Debug)]
pub(crate) struct PlacedDot {
    pub(crate) at: Placed,
    pub(crate) dot: Dot,
}

/// A label and its place.
struct Label<'a> {
    text: &'a str,
    rect: Rect,
    /// The line to its disc, if the label does not touch the disc.
    leader: Option<[Point; 2]>,
    hidden: bool,
}

/// Draws dots into an area of a picture.
///
/// `is_visible` returns whether no surface lies before a place.
pub(crate) fn draw(
    picture: &mut Picture,
    area: Rect,
    dots: &[PlacedDot],
    is_visible: impl Fn(&Placed) -> bool,
) -> DotsDrawn {
    let area = area.within_reach();
    let within =
        |at: &Placed| (0.0..f64::from(area.width)).contains(&at.x) && (0.0..f64::from(area.height)).contains(&at.y);
    let (inside, outside): (Vec<_>, Vec<_>) = dots.iter().partition(|placed| within(&placed.at));
    let (visible, hidden): (Vec<&PlacedDot>, Vec<&PlacedDot>) = inside.into_iter().partition(|p| is_visible(&p.at));
    let radius = (f64::from(area.width.min(area.height)) / 64.0).clamp(2.5, 5.0);
    let labels = place_labels(area, &visible, &hidden, radius);
    let wanted = visible.iter().chain(&hidden).filter(|p| text_of(p).is_some()).count();
    let drawn = DotsDrawn {
        visible: visible.len(),
        hidden: hidden.len(),
        outside: outside.len(),
        without_label: wanted - labels.len(),
    };
    let middle = |placed: &PlacedDot| (f64::from(area.x) + placed.at.x, f64::from(area.y) + placed.at.y);
    for placed in hidden {
        let (x, y) = middle(placed);
        picture.ring(x, y, 0.0, radius - 0.5, WHITE, 0.35);
        picture.ring(x, y, radius - 1.6, radius - 0.5, mix(placed.dot.colour, INK, 0.25), 0.65);
    }
    // Labels go below the discs, so that no rim is cut by the light around a letter.
    for [from, to] in labels.iter().filter_map(|label| label.leader) {
        let style = PrimitiveStyle::with_stroke(Rgb888::new(FAINT[0], FAINT[1], FAINT[2]), 1);
        // Drawing on a picture cannot fail: its error type has no value.
        let Ok(()) = Line::new(from, to).into_styled(style).draw(picture);
    }
    for label in &labels {
        let colour = if label.hidden { mix(INK, WHITE, 0.35) } else { INK };
        halo_text(picture, label.rect.x, label.rect.y, label.text, colour);
    }
    for placed in visible {
        let (x, y) = middle(placed);
        picture.disc(x, y, radius + 1.25, WHITE);
        picture.disc(x, y, radius, placed.dot.colour);
    }
    drawn
}

fn text_of<'a>(placed: &&'a PlacedDot) -> Option<&'a str> {
    placed.dot.label.as_deref().filter(|text| !text.is_empty())
}

/// Finds a free place for each label in turn, those of visible dots first.
///
/// A label stands at its disc, or else a little off with a line to it. It never covers another label or a visible disc, and
/// as few hidden ones as it can.
fn place_labels<'a>(area: Rect, visible: &[&'a PlacedDot], hidden: &[&'a PlacedDot], radius: f64) -> Vec<Label<'a>> {
    let square = |placed: &&PlacedDot| {
        let corner = |from: i32, at: f64| from + (at - radius).round() as i32;
        let side = (radius * 2.0).ceil() as u32;
        Rect { x: corner(area.x, placed.at.x), y: corner(area.y, placed.at.y), width: side, height: side }
    };
    let discs: Vec<Rect> = visible.iter().map(square).collect();
    let rings: Vec<Rect> = hidden.iter().map(square).collect();
    let mut labels: Vec<Label> = Vec::new();
    let order = visible.iter().map(|p| (p, false)).chain(hidden.iter().map(|p| (p, true)));
    for ((placed, is_hidden), disc) in order.zip(discs.iter().chain(&rings)) {
        let Some(text) = text_of(placed) else { continue };
        let free = |rect: &Rect| {
            let taken = labels.iter().map(|label| &label.rect).chain(&discs).any(|other| other.overlaps(rect));
            area.contains(rect) && !taken
        };
        let covered = |rect: &Rect| rings.iter().filter(|ring| ring.overlaps(rect)).count();
        // The first of equals is taken: `min_by_key` keeps it.
        let near = near_places(disc, text).into_iter().filter(&free).min_by_key(&covered);
        let far = || far_places(disc, text).into_iter().filter(&free).min_by_key(&covered);
        let place = near.map(|rect| (rect, None)).or_else(|| far().map(|rect| (rect, Some(leader(disc, &rect)))));
        if let Some((rect, leader)) = place {
            labels.push(Label { text, rect, leader, hidden: is_hidden });
        }
    }
    labels
}

/// Returns the pixels across and down that a label must have free.
///
/// Digits fill ten of a line's thirteen rows; the other three may overlap anything.
fn extent(text: &str) -> (u32, u32) {
    (SIZE.width(text), SIZE.height() - 3)
}

/// Returns the places that touch a disc, best first: beside it, above, below, then at the corners.
fn near_places(disc: &Rect, text: &str) -> [Rect; 8] {
    let (width, height) = extent(text);
    let (w, h, side, gap) = (width as i32, height as i32, disc.width as i32, 2);
    let (right, left, middle) = (disc.x + side + gap, disc.x - w - gap, disc.x + (side - w) / 2);
    let (above, below, level) = (disc.y - h - 1, disc.y + side + 1, disc.y + (side - h) / 2);
    let places = [
        (right, level),
        (left, level),
        (middle, above),
        (middle, below),
        (right - 2, above + 2),
        (left + 2, above + 2),
        (right - 2, below - 2),
        (left + 2, below - 2),
    ];
    places.map(|(x, y)| Rect { x, y, width, height })
}

/// Returns places around a disc at two distances, the nearer ones first.
fn far_places(disc: &Rect, text: &str) -> Vec<Rect> {
    let (width, height) = extent(text);
    let (x, y) = centre(disc);
    let around = |distance: i32| {
        let ways = [(1, -1), (-1, -1), (1, 1), (-1, 1), (0, -1), (0, 1), (1, 0), (-1, 0)];
        ways.map(|(right, down)| {
            // In a slanting direction either part of the way is shorter.
            let way = if right != 0 && down != 0 { distance * 5 / 7 } else { distance };
            let side = disc.width as i32 / 2;
            let x = x + right * (way + side + width as i32 / 2) - width as i32 / 2;
            let y = y + down * (way + side + height as i32 / 2) - height as i32 / 2;
            Rect { x, y, width, height }
        })
    };
    [9, 18].into_iter().flat_map(around).collect()
}

/// Returns the line from the middle of a disc to the nearest point of a label.
fn leader(disc: &Rect, label: &Rect) -> [Point; 2] {
    let (x, y) = centre(disc);
    let to = |from: i32, start: i32, length: u32| from.clamp(start, start + length as i32);
    [Point::new(x, y), Point::new(to(x, label.x, label.width), to(y, label.y, label.height))]
}

fn centre(rect: &Rect) -> (i32, i32) {
    (rect.x + rect.width as i32 / 2, rect.y + rect.height as i32 / 2)
}

/// Writes text with white around each letter, readable on any surface.
fn halo_text(picture: &mut Picture, x: i32, y: i32, text: &str, colour: Colour) {
    // The rect begins where the letters do, two rows below the top of the font's cell.
    let y = y - 2;
    for (right, down) in [(-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (1, -1), (-1, 1), (1, 1)] {
        picture.text(x + right, y + down, text, SIZE, WHITE);
    }
    picture.text(x, y, text, SIZE, colour);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::colour::CRIMSON;

    const AREA: Rect = Rect { x: 10, y: 20, width: 200, height: 100 };

    fn dot(x: f64, y: f64, label: &str) -> PlacedDot {
        let dot = Dot { at: Point3::origin(), label: Some(label.to_string()), colour: CRIMSON };
        PlacedDot { at: Placed { x, y, depth: 0.0 }, dot }
    }

    #[test]
    fn labels_of_close_dots_do_not_cover_one_another_or_the_discs() {
        let dots = [dot(60.0, 50.0, "1"), dot(72.0, 50.0, "2"), dot(66.0, 62.0, "13"), dot(195.0, 95.0, "107")];
        let dots: Vec<&PlacedDot> = dots.iter().collect();
        let labels = place_labels(AREA, &dots, &[], 4.0);
        assert_eq!(labels.len(), 4);
        for (i, label) in labels.iter().enumerate() {
            assert!(AREA.contains(&label.rect));
            assert!(labels[..i].iter().all(|other| !other.rect.overlaps(&label.rect)), "{}", label.text);
            for placed in &dots {
                let (x, y) = (placed.at.x as i32 + 10 - 3, placed.at.y as i32 + 20 - 3);
                assert!(!label.rect.overlaps(&Rect { x, y, width: 6, height: 6 }), "{}", label.text);
            }
        }
    }

    #[test]
    fn a_label_without_a_free_place_is_left_out_and_counted() {
        let dots: Vec<PlacedDot> = (0..30).map(|i| dot(50.0, 50.0, &i.to_string())).collect();
        let mut picture = Picture::new(240, 140, WHITE);
        let drawn = draw(&mut picture, AREA, &dots, |_| true);
        assert_eq!((drawn.visible, drawn.hidden, drawn.outside), (30, 0, 0));
        assert!(drawn.without_label > 0);
    }

    #[test]
    fn a_disc_has_its_colour_and_a_white_rim_and_a_hidden_one_is_fainter() {
        for visible in [true, false] {
            let mut picture = Picture::new(240, 140, [90, 120, 160]);
            draw(&mut picture, AREA, &[dot(100.0, 50.0, "")], |_| visible);
            assert_eq!(picture.at(110, 70) == Some(CRIMSON), visible);
            let rim = (110..120).any(|x| picture.at(x, 70).is_some_and(|pixel| pixel.iter().all(|c| *c > 190)));
            assert_eq!(rim, visible);
        }
    }
}
