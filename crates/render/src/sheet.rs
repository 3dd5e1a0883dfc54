//! Pictures in rows and columns with captions.

use crate::colour::{INK, RULE, WHITE};
use crate::picture::{Picture, Rect};
use crate::text::Size;

/// Pixels around and between cells.
const GAP: u32 = 8;

/// A picture with a line of text below it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Cell {
    /// The picture.
    pub picture: Picture,
    /// The text below, cut with "…" where it is wider than the column; it may be empty.
    pub caption: String,
}

/// Draws a contact sheet: rows of cells below a title, each column as wide as its widest picture.
///
/// Rows may differ in length; an empty title or row takes no room. Pictures stand in the middle of their cells.
pub fn sheet(title: &str, rows: &[Vec<Cell>]) -> Picture {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width_of = |column: usize| rows.iter().filter_map(|row| row.get(column)).map(|cell| cell.picture.width).max();
    let widths: Vec<u32> = (0..columns).map(|column| width_of(column).unwrap_or(0)).collect();
    let rows: Vec<&[Cell]> = rows.iter().map(Vec::as_slice).filter(|row| !row.is_empty()).collect();
    let heights: Vec<(u32, u32)> = rows.iter().map(|row| heights(row)).collect();
    let width = widths.iter().map(|width| width + GAP).sum::<u32>() + GAP;
    let heading = if title.is_empty() { 0 } else { Size::Large.height() + GAP };
    let height = heights.iter().map(|(picture, caption)| picture + caption + GAP).sum::<u32>() + GAP + heading;
    let mut page = Picture::new(width, height, WHITE);
    let inner = width.saturating_sub(2 * GAP);
    let title = Size::Large.shortened(title, inner);
    page.text(GAP as i32, GAP as i32, &title, Size::Large, INK);
    let mut top = GAP + heading;
    for (index, (row, (picture, caption))) in rows.iter().zip(&heights).enumerate() {
        if index > 0 {
            let y = (top - GAP / 2) as i32;
            page.fill(Rect { x: GAP as i32, y, width: inner, height: 1 }, RULE);
        }
        let mut left = GAP;
        for (cell, width) in row.iter().zip(&widths) {
            let middle = (width - cell.picture.width) / 2;
            page.paste(&cell.picture, (left + middle) as i32, (top + (picture - cell.picture.height) / 2) as i32);
            let text = Size::Normal.shortened(&cell.caption, *width);
            let middle = (width - Size::Normal.width(&text).min(*width)) / 2;
            page.text((left + middle) as i32, (top + picture + 2) as i32, &text, Size::Normal, INK);
            left += width + GAP;
        }
        top += picture + caption + GAP;
    }
    page
}

/// Returns the heights of a row's pictures and of its captions, in pixels.
fn heights(row: &[Cell]) -> (u32, u32) {
    let picture = row.iter().map(|cell| cell.picture.height).max().unwrap_or(0);
    let has_caption = row.iter().any(|cell| !cell.caption.is_empty());
    (picture, if has_caption { Size::Normal.height() + 4 } else { 0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cell(width: u32, height: u32, caption: &str) -> Cell {
        Cell { picture: Picture::new(width, height, [9, 90, 200]), caption: caption.to_string() }
    }

    #[test]
    fn every_picture_stands_in_its_cell_whole() {
        let rows = [vec![cell(40, 30, "one"), cell(20, 30, "two")], vec![], vec![cell(30, 10, "")]];
        let page = sheet("Poses", &rows);
        let blue = page.pixels.iter().filter(|pixel| **pixel == [9, 90, 200]).count();
        assert_eq!(blue, 40 * 30 + 20 * 30 + 30 * 10);
        assert_eq!(page.width, 8 + 40 + 8 + 20 + 8);
        assert_eq!(page.height, (8 + 20 + 8) + (30 + 17 + 8) + (10 + 8));
        // The narrower picture stands in the middle of the first column.
        assert_eq!(page.at(8 + 5, page.height as i32 - 9), Some([9, 90, 200]));
        assert_eq!(page.at(8 + 4, page.height as i32 - 9), Some(WHITE));
    }

    #[test]
    fn captions_do_not_leave_their_columns() {
        let page = sheet("", &[vec![cell(40, 10, "a caption far too long"), cell(40, 10, "")]]);
        let text_rows = 8 + 10..page.height as i32;
        assert!(text_rows.clone().any(|y| (8..48).any(|x| page.at(x, y) != Some(WHITE))));
        assert!(text_rows.into_iter().all(|y| (48..page.width as i32).all(|x| page.at(x, y) == Some(WHITE))));
    }

    #[test]
    fn a_sheet_of_nothing_is_an_empty_page() {
        assert_eq!(sheet("", &[]), Picture::new(8, 8, WHITE));
        assert_eq!(sheet("", &[vec![], vec![]]).width, 8);
        sheet("a title", &[vec![cell(0, 0, "nothing")]]);
    }
}
