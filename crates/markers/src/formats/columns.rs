//! The columns of a table of points, from its headings or from the values themselves.

use super::{
    rows::{Row, Separator},
    wrap::Triple,
};
use crate::text::{ParseError, shorten};

/// Tables wider than this need headings.
const MAX_UNTITLED_WIDTH: usize = 12;

/// The contents of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Column {
    /// Names.
    Name,
    /// Numbers that are names where no column has better ones.
    Number,
    /// First coordinates of positions.
    X,
    /// Second coordinates of positions.
    Y,
    /// Third coordinates of positions.
    Z,
    /// Vertices.
    Vertex,
    /// Triangles.
    Triangle,
    /// Coordinates of the first corner of a triangle.
    U,
    /// Coordinates of the second corner of a triangle.
    V,
}

/// The columns of a table; `None` are those that are skipped.
#[derive(Clone, Debug, PartialEq)]
pub struct Columns(Vec<Option<Column>>);

impl Columns {
    /// The columns that the headings in `cells` name; `None` if they are no headings.
    pub fn from_headings(cells: &[String]) -> Option<Self> {
        let columns: Vec<_> = cells.iter().map(|cell| Column::from_heading(cell)).collect();
        let names_value = columns.iter().flatten().any(|column| !matches!(column, Column::Name | Column::Number));
        (names_value && cells.iter().all(|cell| cell.parse::<f64>().is_err())).then_some(Self(columns))
    }

    /// The columns of a table without headings, from their number and the values in them.
    ///
    /// # Errors
    ///
    /// If no columns are known for the number of values in a line.
    pub fn from_values(rows: &[Row<'_>], separator: Separator) -> Result<Self, ParseError> {
        use Column::*;
        let columns: &[Column] = match commonest_width(rows) {
            1 if rows.iter().any(|row| row.cells[0].parse::<u32>().is_ok()) => &[Vertex],
            2 => &[Name, Vertex],
            3 => {
                let triples: Vec<_> = rows.iter().filter_map(|row| triple(&row.cells)).collect();
                if Triple::are_triangles(&triples) { &[Triangle, U, V] } else { &[X, Y, Z] }
            }
            4 => &[Name, X, Y, Z],
            width => {
                let decimal_commas = separator == Separator::Comma && [7, 8].contains(&width);
                let found = rows.first().map_or("", |row| row.text);
                return Err(ParseError::new(
                    format!("expected `name, x, y, z` or `name, vertex`, found `{}`", shorten(found)),
                    if decimal_commas {
                        "are decimals written with commas? write them with points"
                    } else {
                        "put a line of headings first, e.g. `name,x,y,z`"
                    },
                ));
            }
        };
        Ok(Self(columns.iter().copied().map(Some).collect()))
    }

    /// How many columns there are.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether the table has all of `columns`.
    pub fn have(&self, columns: &[Column]) -> bool {
        columns.iter().all(|column| self.0.contains(&Some(*column)))
    }

    /// The cell of `column` in `cells`, which are as many as the columns; empty if there is no such column.
    pub fn cell<'c>(&self, cells: &'c [String], column: Column) -> &'c str {
        let i = self.0.iter().position(|c| *c == Some(column));
        i.map_or("", |i| cells[i].as_str())
    }
}

impl Column {
    fn from_heading(heading: &str) -> Option<Self> {
        let letters = heading.chars().filter(|c| c.is_alphanumeric() || *c == '-');
        Some(match letters.collect::<String>().to_lowercase().as_str() {
            "name" | "label" | "identifier" | "landmark" => Self::Name,
            "id" | "point" | "rowname" | "---" => Self::Number,
            "x" | "px" | "p0" | "tx" | "posx" | "positionx" | "locationx" | "locx" => Self::X,
            "y" | "py" | "p1" | "ty" | "posy" | "positiony" | "locationy" | "locy" => Self::Y,
            "z" | "pz" | "p2" | "tz" | "posz" | "positionz" | "locationz" | "locz" => Self::Z,
            "vertex" | "vertexindex" | "index" | "vertexid" | "ptnum" | "pointnumber" => Self::Vertex,
            "triangle" | "triangleindex" | "face" | "prim" | "primnum" => Self::Triangle,
            "u" | "b1" | "bary1" | "b0" => Self::U,
            "v" | "b2" | "bary2" => Self::V,
            _ => return None,
        })
    }
}

/// The number of cells that most rows have; rows with another are reported one by one.
fn commonest_width(rows: &[Row<'_>]) -> usize {
    let widest = rows.iter().map(|row| row.cells.len()).max().unwrap_or(0);
    let frequency = |width: &usize| rows.iter().filter(|row| row.cells.len() == *width).count();
    (1..=widest.min(MAX_UNTITLED_WIDTH)).max_by_key(frequency).unwrap_or(widest)
}

fn triple(cells: &[String]) -> Option<Triple> {
    let [a, b, c] = cells else { return None };
    let numbers = [a.parse().ok()?, b.parse().ok()?, c.parse().ok()?];
    Some(Triple { numbers, begins_whole: a.parse::<u32>().is_ok() })
}
