//! Solves with the factor, for a few right-hand sides at once.

#![expect(clippy::needless_range_loop, reason = "loops over lanes read like the formulas and become vectors")]

use nalgebra_sparse::CscMatrix;
use pulp::{Arch, NullaryFnOnce};

use super::{
    super::residual::subtract_product,
    Multifrontal,
    fronts::{Front, Fronts, Segment},
};

/// Right-hand sides that are solved for at once, where there are enough of them: the factor is then read half as often.
const MOST_TOGETHER: usize = 8;

/// Right-hand sides that are solved for at once, where there are few.
const FEW_TOGETHER: usize = 4;

/// A row of `N` right-hand sides, each in a lane of its own: the solution of one does not depend on the others.
type Row<const N: usize> = [f64; N];

/// Columns of a front that are worked on at once.
const WIDTH: usize = 4;

/// What fronts before the next one leave for rows above, the last one last.
type Left<const N: usize> = Vec<Vec<Row<N>>>;

impl Multifrontal {
    /// Solves A x = b in place for right-hand sides of n rows, stored one after another.
    pub fn solve_in_place(&self, rhs: &mut [f64]) {
        let n = self.fronts.order.len();
        if n == 0 {
            return;
        }
        for rhs in rhs.chunks_mut(n * MOST_TOGETHER) {
            if rhs.len() > n * FEW_TOGETHER {
                self.solve_together::<MOST_TOGETHER>(rhs);
            } else {
                self.solve_together::<FEW_TOGETHER>(rhs);
            }
        }
    }

    /// Like [`solve_in_place`](Self::solve_in_place), with one step of iterative refinement for the matrix that was factored, of the
    /// lower triangle `matrix`.
    ///
    /// Worth its price where A squares a badly conditioned operator, as a bilaplacian does.
    pub fn solve_refined_in_place(&self, matrix: &CscMatrix<f64>, rhs: &mut [f64]) {
        let mut residual = rhs.to_vec();
        self.solve_in_place(rhs);
        let n = matrix.ncols().max(1);
        for (r, x) in residual.chunks_mut(n).zip(rhs.chunks(n)) {
            subtract_product(matrix, x, r);
        }
        self.solve_in_place(&mut residual);
        rhs.iter_mut().zip(&residual).for_each(|(x, dx)| *x += dx);
    }

    /// Solves for at most `N` right-hand sides; zeros stand in for the others.
    fn solve_together<const N: usize>(&self, rhs: &mut [f64]) {
        let order = &self.fronts.order;
        let n = order.len();
        let row = |&i: &u32| std::array::from_fn(|c| rhs.get(c * n + i as usize).copied().unwrap_or(0.0));
        let mut rows: Vec<Row<N>> = order.iter().map(row).collect();
        let solve = Solve { fronts: &self.fronts, values: &self.values };
        solve.forward(&self.fronts.root, 0, &mut rows);
        solve.backward(&self.fronts.root, 0, &mut rows, &[]);
        for (c, column) in rhs.chunks_mut(n).enumerate() {
            rows.iter().zip(order).for_each(|(row, &i)| column[i as usize] = row[c]);
        }
    }
}

#[derive(Clone, Copy)]
struct Solve<'a> {
    fronts: &'a Fronts,
    values: &'a [f64],
}

/// Rows that are solved, from a column on.
type Solved<'a, const N: usize> = (usize, &'a [Row<N>]);

impl Solve<'_> {
    /// L y = b for a segment and all before it that adds to it; `rows` are theirs, from column `offset` on.
    fn forward<const N: usize>(self, segment: &Segment, offset: usize, rows: &mut [Row<N>]) -> Left<N> {
        let (start, _) = self.fronts.start(segment.fronts.start);
        let (before, rows) = rows.split_at_mut(start - offset);
        let mut left = self.forward_all(&segment.children, offset, before);
        Arch::new().dispatch(Forward { solve: self, segment, rows, left: &mut left });
        left
    }

    fn forward_all<const N: usize>(self, segments: &[Segment], offset: usize, rows: &mut [Row<N>]) -> Left<N> {
        match segments {
            [] => vec![],
            [only] => self.forward(only, offset, rows),
            _ => {
                let (first, second) = segments.split_at(segments.len() / 2);
                let (middle, _) = self.fronts.start(first[first.len() - 1].fronts.end);
                let (a, b) = rows.split_at_mut(middle - offset);
                let forward = |segments, offset, rows| self.forward_all(segments, offset, rows);
                let (mut left, more) = rayon::join(|| forward(first, offset, a), || forward(second, middle, b));
                left.extend(more);
                left
            }
        }
    }

    /// Lᵀ x = y; `above` are the rows of the segments above, the nearest first.
    fn backward<const N: usize>(self, segment: &Segment, offset: usize, rows: &mut [Row<N>], above: &[Solved<'_, N>]) {
        let (start, _) = self.fronts.start(segment.fronts.start);
        let (before, rows) = rows.split_at_mut(start - offset);
        Arch::new().dispatch(Backward { solve: self, segment, rows: &mut *rows, above });
        let above: Vec<Solved<'_, N>> = std::iter::once((start, &*rows)).chain(above.iter().copied()).collect();
        self.backward_all(&segment.children, offset, before, &above);
    }

    fn backward_all<const N: usize>(
        self,
        segments: &[Segment],
        offset: usize,
        rows: &mut [Row<N>],
        above: &[Solved<'_, N>],
    ) {
        match segments {
            [] => {}
            [only] => self.backward(only, offset, rows, above),
            _ => {
                let (first, second) = segments.split_at(segments.len() / 2);
                let (middle, _) = self.fronts.start(first[first.len() - 1].fronts.end);
                let (a, b) = rows.split_at_mut(middle - offset);
                let backward = |segments, offset, rows| self.backward_all(segments, offset, rows, above);
                rayon::join(|| backward(first, offset, a), || backward(second, middle, b));
            }
        }
    }
}

struct Forward<'a, const N: usize> {
    solve: Solve<'a>,
    segment: &'a Segment,
    rows: &'a mut [Row<N>],
    left: &'a mut Left<N>,
}

impl<const N: usize> NullaryFnOnce for Forward<'_, N> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { solve: Solve { fronts, values }, segment, rows, left } = self;
        let (offset, _) = fronts.start(segment.fronts.start);
        let mut spare: Left<N> = vec![];
        for front in &fronts.fronts[segment.fronts.clone()] {
            let own = &mut rows[front.start - offset..][..front.columns];
            let mut rest = spare.pop().unwrap_or_default();
            rest.clear();
            rest.resize(front.below.len(), [0.0; N]);
            let first = left.len() - front.children.len();
            for (&child, more) in front.children.iter().zip(left.drain(first..)) {
                for (&place, value) in fronts.fronts[child as usize].above.iter().zip(&more) {
                    let place = place as usize;
                    let to = match place.checked_sub(front.columns) {
                        None => &mut own[place],
                        Some(place) => &mut rest[place],
                    };
                    for k in 0..N {
                        to[k] += value[k];
                    }
                }
                spare.push(more);
            }
            let values = &values[front.values..][..front.size()];
            for column in (0..front.columns).step_by(WIDTH) {
                match front.columns - column {
                    1 => forward_columns::<N, 1>(front, values, column, own, &mut rest),
                    2 => forward_columns::<N, 2>(front, values, column, own, &mut rest),
                    3 => forward_columns::<N, 3>(front, values, column, own, &mut rest),
                    _ => forward_columns::<N, WIDTH>(front, values, column, own, &mut rest),
                }
            }
            left.push(rest);
        }
    }
}

#[inline(always)]
fn forward_columns<const N: usize, const W: usize>(
    front: &Front,
    values: &[f64],
    column: usize,
    own: &mut [Row<N>],
    rest: &mut [Row<N>],
) {
    let columns: [&[f64]; W] = columns(front, values, column);
    let (_, own) = own.split_at_mut(column);
    let (own, inside) = own.split_at_mut(W);
    for c in 0..W {
        for e in 0..c {
            let factor = columns[e][column + c];
            for k in 0..N {
                own[c][k] -= factor * own[e][k];
            }
        }
        for value in &mut own[c] {
            *value /= columns[c][column + c];
        }
    }
    let own: [Row<N>; W] = std::array::from_fn(|c| own[c]);
    subtract_from(inside, &columns, column + W, &own);
    subtract_from(rest, &columns, front.columns, &own);
}

/// rows −= L own, for rows of L from place `first` on.
#[inline(always)]
fn subtract_from<const N: usize, const W: usize>(
    rows: &mut [Row<N>],
    columns: &[&[f64]; W],
    first: usize,
    own: &[Row<N>; W],
) {
    let columns: [&[f64]; W] = std::array::from_fn(|c| &columns[c][first..first + rows.len()]);
    for (r, row) in rows.iter_mut().enumerate() {
        for c in 0..W {
            for k in 0..N {
                row[k] -= columns[c][r] * own[c][k];
            }
        }
    }
}

struct Backward<'a, const N: usize> {
    solve: Solve<'a>,
    segment: &'a Segment,
    rows: &'a mut [Row<N>],
    above: &'a [Solved<'a, N>],
}

impl<const N: usize> NullaryFnOnce for Backward<'_, N> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { solve: Solve { fronts, values }, segment, rows, above } = self;
        let (offset, _) = fronts.start(segment.fronts.start);
        let mut rest: Vec<Row<N>> = vec![];
        for front in fronts.fronts[segment.fronts.clone()].iter().rev() {
            rest.clear();
            let mut above = above;
            for &row in &front.below {
                let row = row as usize;
                if let Some(row) = rows.get(row - offset) {
                    rest.push(*row);
                    continue;
                }
                // Rows ascend, and so do segments above.
                while let [(start, solved), higher @ ..] = above {
                    match solved.get(row - start) {
                        Some(row) => {
                            rest.push(*row);
                            break;
                        }
                        None => above = higher,
                    }
                }
            }
            let own = &mut rows[front.start - offset..][..front.columns];
            let values = &values[front.values..][..front.size()];
            for column in (0..front.columns).step_by(WIDTH).rev() {
                match front.columns - column {
                    1 => backward_columns::<N, 1>(front, values, column, own, &rest),
                    2 => backward_columns::<N, 2>(front, values, column, own, &rest),
                    3 => backward_columns::<N, 3>(front, values, column, own, &rest),
                    _ => backward_columns::<N, WIDTH>(front, values, column, own, &rest),
                }
            }
        }
    }
}

#[inline(always)]
fn backward_columns<const N: usize, const W: usize>(
    front: &Front,
    values: &[f64],
    column: usize,
    own: &mut [Row<N>],
    rest: &[Row<N>],
) {
    let columns: [&[f64]; W] = columns(front, values, column);
    let (_, own) = own.split_at_mut(column);
    let (own, inside) = own.split_at_mut(W);
    let mut sums: [Row<N>; W] = std::array::from_fn(|c| own[c]);
    subtract_products(&mut sums, &columns, column + W, inside);
    subtract_products(&mut sums, &columns, front.columns, rest);
    for c in (0..W).rev() {
        for e in c + 1..W {
            let factor = columns[c][column + e];
            let below = sums[e];
            for k in 0..N {
                sums[c][k] -= factor * below[k];
            }
        }
        for value in &mut sums[c] {
            *value /= columns[c][column + c];
        }
    }
    own.copy_from_slice(&sums);
}

/// sums −= Lᵀ rows, for rows of L from place `first` on.
#[inline(always)]
fn subtract_products<const N: usize, const W: usize>(
    sums: &mut [Row<N>; W],
    columns: &[&[f64]; W],
    first: usize,
    rows: &[Row<N>],
) {
    let columns: [&[f64]; W] = std::array::from_fn(|c| &columns[c][first..first + rows.len()]);
    for (r, row) in rows.iter().enumerate() {
        for c in 0..W {
            for k in 0..N {
                sums[c][k] -= columns[c][r] * row[k];
            }
        }
    }
}

/// W columns of L from `column` on.
#[inline(always)]
fn columns<'a, const W: usize>(front: &Front, values: &'a [f64], column: usize) -> [&'a [f64]; W] {
    std::array::from_fn(|c| &values[(column + c) * front.stride()..][..front.stride()])
}
