//! Dense elimination of the columns of a front that does not fit into the cache, panel by panel, on the threads there are.
//!
//! How a front is cut depends on its size alone, so that results do not depend on the number of threads.

use dyn_stack::{MemBuffer, MemStack};
use faer::{
    Accum, MatMut, MatRef, Par,
    linalg::{
        cholesky::llt::factor::{LltRegularization, cholesky_in_place, cholesky_in_place_scratch},
        matmul::matmul,
        triangular_solve::solve_lower_triangular_in_place,
    },
    prelude::{Reborrow as _, ReborrowMut as _},
};
use rayon::prelude::*;

use super::kernel::Dense;

/// Columns of a panel, and columns and rows of the pieces that run beside each other.
const PANEL: usize = 192;

/// Pivots' values from which on panels are faster.
const LARGE: usize = 1 << 15;

impl Dense<'_> {
    /// Whether [`eliminate_panels`](Self::eliminate_panels) is the faster way.
    pub fn is_large(&self) -> bool {
        self.pivots.len() > LARGE
    }

    /// What [`eliminate`](Self::eliminate) does, for a large front.
    pub fn eliminate_panels(self) -> bool {
        let Self { pivots, rest, stride, columns, rows } = self;
        let scratch = cholesky_in_place_scratch::<f64>(PANEL, Par::Seq, Default::default());
        let mut memory = MemBuffer::new(scratch);
        for first in (0..columns).step_by(PANEL) {
            let width = PANEL.min(columns - first);
            let (panel, right) = pivots[first * stride..].split_at_mut(width * stride);
            let whole =
                MatMut::from_column_major_slice_with_stride_mut(&mut panel[first..], rows - first, width, stride);
            let (mut top, bottom) = whole.split_at_row_mut(width);
            let factored = cholesky_in_place(
                top.rb_mut(),
                LltRegularization::default(),
                Par::Seq,
                MemStack::new(&mut memory),
                Default::default(),
            );
            if factored.is_err() {
                return false;
            }
            solve(top.rb(), bottom);
            let panel = &*panel;
            let update = |(column, to): (usize, &mut [f64])| {
                let left = MatRef::from_column_major_slice_with_stride(&panel[column..], rows - column, width, stride);
                let count = to.len() / stride;
                let to =
                    MatMut::from_column_major_slice_with_stride_mut(&mut to[column..], rows - column, count, stride);
                let factors = left.subrows(0, count).transpose();
                matmul(to, Accum::Add, left, factors, -1.0, Par::Seq);
            };
            let chunks =
                right.par_chunks_mut(PANEL * stride).enumerate().map(|(k, to)| (first + width + k * PANEL, to));
            let more = rest.par_chunks_mut(PANEL * stride).enumerate().map(|(k, to)| (columns + k * PANEL, to));
            chunks.chain(more).for_each(update);
        }
        true
    }
}

/// rows ← rows L⁻ᵀ.
fn solve(top: MatRef<'_, f64>, rows: MatMut<'_, f64>) {
    if rows.nrows() <= PANEL {
        solve_lower_triangular_in_place(top, rows.transpose_mut(), Par::Seq);
        return;
    }
    let (first, second) = {
        let middle = (rows.nrows() / 2).next_multiple_of(PANEL).min(rows.nrows() - 1);
        rows.split_at_row_mut(middle)
    };
    rayon::join(|| solve(top, first), || solve(top, second));
}
