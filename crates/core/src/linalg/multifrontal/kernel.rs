//! Dense elimination of the columns of a front, in blocks that stay in registers.
//!
//! Products and sums are rounded one by one, so that results are the same with wide vectors and with narrow ones.

#![expect(clippy::needless_range_loop, reason = "loops over lanes read like the formulas and become vectors")]

/// Rows of a block.
pub(super) const LANES: usize = 4;

/// Columns that are worked on at once.
const WIDTH: usize = 4;

type Block = [f64; LANES];

/// A front whose first columns are in `pivots` and whose others, of which only the lower triangle counts, in `rest`.
pub(super) struct Dense<'a> {
    pub pivots: &'a mut [f64],
    pub rest: &'a mut [f64],
    /// Values from one column to the next, a multiple of [`LANES`].
    pub stride: usize,
    /// Number of pivots.
    pub columns: usize,
    /// Number of all columns.
    pub rows: usize,
}

impl Dense<'_> {
    /// Turns the pivots' columns into those of L and subtracts their products from the rest; `false` if a pivot is not positive.
    #[inline(always)]
    pub fn eliminate(self) -> bool {
        let Self { pivots, rest, stride, columns, rows } = self;
        for column in (0..columns).step_by(WIDTH) {
            let are_positive = match columns - column {
                1 => eliminate_columns::<1>(pivots, stride, column),
                2 => eliminate_columns::<2>(pivots, stride, column),
                3 => eliminate_columns::<3>(pivots, stride, column),
                _ => eliminate_columns::<WIDTH>(pivots, stride, column),
            };
            if !are_positive {
                return false;
            }
        }
        for column in (columns..rows).step_by(WIDTH) {
            let to = &mut rest[(column - columns) * stride..];
            match rows - column {
                1 => update_columns::<1>(pivots, to, stride, column),
                2 => update_columns::<2>(pivots, to, stride, column),
                3 => update_columns::<3>(pivots, to, stride, column),
                _ => update_columns::<WIDTH>(pivots, to, stride, column),
            }
        }
        true
    }
}

/// Turns W columns from `column` on, a multiple of [`LANES`], into those of L.
#[inline(always)]
fn eliminate_columns<const W: usize>(pivots: &mut [f64], stride: usize, column: usize) -> bool {
    let (left, own) = pivots.split_at_mut(column * stride);
    let mut tile = load::<1, W>(own, stride, column);
    subtract(&mut tile, left, stride, column, column);
    let Some(triangle) = Triangle::factor(&tile) else { return false };
    triangle.solve(&mut tile);
    for c in 0..W {
        tile[c][0][c] = triangle.values[c][c];
    }
    store(&tile, own, stride, column);
    let mut row = column + LANES;
    while row + 2 * LANES <= stride {
        eliminate_tile::<2, W>(left, own, stride, [row, column], &triangle);
        row += 2 * LANES;
    }
    if row < stride {
        eliminate_tile::<1, W>(left, own, stride, [row, column], &triangle);
    }
    true
}

#[inline(always)]
fn eliminate_tile<const R: usize, const W: usize>(
    left: &[f64],
    own: &mut [f64],
    stride: usize,
    [row, column]: [usize; 2],
    triangle: &Triangle<W>,
) {
    let mut tile = load::<R, W>(own, stride, row);
    subtract(&mut tile, left, stride, row, column);
    triangle.solve(&mut tile);
    store(&tile, own, stride, row);
}

/// Subtracts from W columns, from `column` on, the products of all columns of `left`.
#[inline(always)]
fn update_columns<const W: usize>(left: &[f64], own: &mut [f64], stride: usize, column: usize) {
    let mut row = column / LANES * LANES;
    while row + 2 * LANES <= stride {
        update_tile::<2, W>(left, own, stride, [row, column]);
        row += 2 * LANES;
    }
    if row < stride {
        update_tile::<1, W>(left, own, stride, [row, column]);
    }
}

#[inline(always)]
fn update_tile<const R: usize, const W: usize>(
    left: &[f64],
    own: &mut [f64],
    stride: usize,
    [row, column]: [usize; 2],
) {
    let mut tile = load::<R, W>(own, stride, row);
    subtract(&mut tile, left, stride, row, column);
    store(&tile, own, stride, row);
}

/// tile −= rows from `row` on times rows from `column` on, transposed, over the columns of `left`.
#[inline(always)]
fn subtract<const R: usize, const W: usize>(
    tile: &mut [[Block; R]; W],
    left: &[f64],
    stride: usize,
    row: usize,
    column: usize,
) {
    for values in left.chunks_exact(stride) {
        let factors = &values[column..column + W];
        let rows = blocks::<R>(&values[row..row + R * LANES]);
        for c in 0..W {
            for r in 0..R {
                for k in 0..LANES {
                    tile[c][r][k] -= rows[r][k] * factors[c];
                }
            }
        }
    }
}

#[inline(always)]
fn load<const R: usize, const W: usize>(from: &[f64], stride: usize, row: usize) -> [[Block; R]; W] {
    std::array::from_fn(|c| blocks(&from[c * stride + row..][..R * LANES]))
}

#[inline(always)]
fn store<const R: usize, const W: usize>(tile: &[[Block; R]; W], to: &mut [f64], stride: usize, row: usize) {
    for (c, column) in tile.iter().enumerate() {
        to[c * stride + row..][..R * LANES].copy_from_slice(column.as_flattened());
    }
}

#[inline(always)]
fn blocks<const R: usize>(values: &[f64]) -> [Block; R] {
    std::array::from_fn(|r| std::array::from_fn(|k| values[r * LANES + k]))
}

/// L of a block on the diagonal, by rows.
struct Triangle<const W: usize> {
    values: [[f64; W]; W],
    inverse_diagonal: [f64; W],
}

impl<const W: usize> Triangle<W> {
    /// `None` if a pivot is not positive.
    #[inline(always)]
    fn factor(tile: &[[Block; 1]; W]) -> Option<Self> {
        let (mut values, mut inverse_diagonal) = ([[0.0; W]; W], [0.0; W]);
        for c in 0..W {
            for r in c..W {
                let mut value = tile[c][0][r];
                for e in 0..c {
                    value -= values[r][e] * values[c][e];
                }
                if r > c {
                    values[r][c] = value * inverse_diagonal[c];
                } else if value > 0.0 {
                    values[c][c] = value.sqrt();
                    inverse_diagonal[c] = 1.0 / values[c][c];
                } else {
                    return None;
                }
            }
        }
        Some(Self { values, inverse_diagonal })
    }

    /// tile ← tile L⁻ᵀ.
    #[inline(always)]
    fn solve<const R: usize>(&self, tile: &mut [[Block; R]; W]) {
        for c in 0..W {
            for e in 0..c {
                for r in 0..R {
                    for k in 0..LANES {
                        tile[c][r][k] -= tile[e][r][k] * self.values[c][e];
                    }
                }
            }
            for block in &mut tile[c] {
                for value in block {
                    *value *= self.inverse_diagonal[c];
                }
            }
        }
    }
}
