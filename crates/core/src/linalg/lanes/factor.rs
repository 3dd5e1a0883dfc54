//! The factorisation and its solves.

use std::sync::Arc;

use pulp::{Arch, NullaryFnOnce};

use super::{super::symbolic::singular, LanePattern, pattern::Update};
use crate::{Error, Result};

/// Cholesky factorisations A = L Lᵀ of `N` matrices of one pattern, one in each lane.
#[derive(Clone, Debug)]
pub struct LaneCholesky<const N: usize> {
    pattern: Arc<LanePattern>,
    /// A before, L after the factorisation; on its diagonal the inverse.
    values: Vec<[f64; N]>,
    /// The column under way, by rows.
    column: Vec<[f64; N]>,
}

impl<const N: usize> LaneCholesky<N> {
    /// Matrices of zeros.
    pub fn new(pattern: Arc<LanePattern>) -> Self {
        let (entries, n) = (pattern.entry_count(), pattern.size());
        Self { pattern, values: vec![[0.0; N]; entries], column: vec![[0.0; N]; n] }
    }

    /// The pattern.
    pub fn pattern(&self) -> &LanePattern {
        &self.pattern
    }

    /// Sets all entries to 0 and gives them, to be set to those of the next matrices ([`LanePattern::entry`]).
    pub fn clear(&mut self) -> &mut [[f64; N]] {
        self.values.fill([0.0; N]);
        &mut self.values
    }

    /// Factors the matrices in place of their entries, and says which are positive definite. What is in the other lanes is of no use.
    pub fn factor(&mut self) -> [bool; N] {
        let Self { pattern, values, column } = self;
        Arch::new().dispatch(Factorisation { pattern, values, column })
    }

    /// Solves A x = b in place for `C` right-hand sides of each matrix; rows are those of L ([`LanePattern::row`]).
    ///
    /// # Panics
    ///
    /// If `x` has fewer rows than the matrices.
    pub fn solve_in_place<const C: usize>(&self, x: &mut [[[f64; N]; C]]) {
        let (pattern, value) = (&*self.pattern, |p: usize| self.values[p]);
        Arch::new().dispatch(Solve { pattern, value, x });
    }

    /// The error that names the system.
    pub fn singular(&self) -> Error {
        singular(self.pattern.what)
    }
}

impl LaneCholesky<1> {
    /// Factors one matrix.
    ///
    /// # Errors
    ///
    /// [`Error::Singular`] if it is not positive definite.
    pub fn factor_one(&mut self) -> Result<()> {
        if self.factor() == [true] { Ok(()) } else { Err(self.singular()) }
    }

    /// Like [`solve_in_place`](Self::solve_in_place), for `N` × `C` right-hand sides of the one matrix.
    ///
    /// # Panics
    ///
    /// If `x` has fewer rows than the matrix.
    pub fn solve_lanes_in_place<const N: usize, const C: usize>(&self, x: &mut [[[f64; N]; C]]) {
        let (pattern, value) = (&*self.pattern, |p: usize| [self.values[p][0]; N]);
        Arch::new().dispatch(Solve { pattern, value, x });
    }
}

/// The factorisation, column by column from the left.
struct Factorisation<'a, const N: usize> {
    pattern: &'a LanePattern,
    values: &'a mut [[f64; N]],
    /// Room for a column.
    column: &'a mut [[f64; N]],
}

// Inlined into the function that the processor's instructions are chosen for.
impl<const N: usize> NullaryFnOnce for Factorisation<'_, N> {
    type Output = [bool; N];

    #[inline(always)]
    fn call(self) -> [bool; N] {
        let Self { pattern, values, column } = self;
        // A semi-definite matrix may leave a pivot of rounding instead of none.
        let smallest = 16.0 * f64::EPSILON * (pattern.size() as f64).sqrt();
        let mut is_definite = [true; N];
        for j in 0..pattern.size() {
            let (start, end) = (pattern.starts[j], pattern.starts[j + 1]);
            let (done, rest) = values.split_at_mut(start);
            let (own, rows) = (&mut rest[..end - start], &pattern.rows[start..end]);
            rows.iter().zip(&*own).for_each(|(&i, value)| column[i as usize] = *value);
            for update in &pattern.updates[pattern.update_starts[j]..pattern.update_starts[j + 1]] {
                subtract(column, done, &pattern.rows, update);
            }
            let (before, pivot) = (own[0], column[j]);
            let mut inverse = [0.0; N];
            for k in 0..N {
                is_definite[k] &= pivot[k] > smallest * before[k];
                inverse[k] = 1.0 / pivot[k].sqrt();
            }
            for (&i, value) in rows.iter().zip(&mut *own) {
                let from = &column[i as usize];
                for k in 0..N {
                    value[k] = from[k] * inverse[k];
                }
            }
            own[0] = inverse;
        }
        is_definite
    }
}

/// Subtracts from a column what the columns of `update` contribute, in their order.
#[inline(always)]
fn subtract<const N: usize>(column: &mut [[f64; N]], done: &[[f64; N]], rows: &[u32], update: &Update) {
    let length = update.rows as usize;
    let tail = |c: usize| {
        let end = update.ends[c] as usize;
        &done[end - length..end]
    };
    let first_end = update.ends[0] as usize;
    let rows = &rows[first_end - length..first_end];
    match update.columns {
        1 => {
            let a = tail(0);
            for (&i, a_i) in rows.iter().zip(a) {
                subtract_product(&mut column[i as usize], &a[0], a_i);
            }
        }
        2 => {
            let (a, b) = (tail(0), tail(1));
            for ((&i, a_i), b_i) in rows.iter().zip(a).zip(b) {
                let to = &mut column[i as usize];
                subtract_product(to, &a[0], a_i);
                subtract_product(to, &b[0], b_i);
            }
        }
        3 => {
            let (a, b, c) = (tail(0), tail(1), tail(2));
            for (((&i, a_i), b_i), c_i) in rows.iter().zip(a).zip(b).zip(c) {
                let to = &mut column[i as usize];
                subtract_product(to, &a[0], a_i);
                subtract_product(to, &b[0], b_i);
                subtract_product(to, &c[0], c_i);
            }
        }
        _ => {
            let (a, b, c, d) = (tail(0), tail(1), tail(2), tail(3));
            for ((((&i, a_i), b_i), c_i), d_i) in rows.iter().zip(a).zip(b).zip(c).zip(d) {
                let to = &mut column[i as usize];
                subtract_product(to, &a[0], a_i);
                subtract_product(to, &b[0], b_i);
                subtract_product(to, &c[0], c_i);
                subtract_product(to, &d[0], d_i);
            }
        }
    }
}

/// The triangular solves; `value` gives the entries of L.
struct Solve<'a, V, const N: usize, const C: usize> {
    pattern: &'a LanePattern,
    value: V,
    x: &'a mut [[[f64; N]; C]],
}

impl<V: Fn(usize) -> [f64; N], const N: usize, const C: usize> NullaryFnOnce for Solve<'_, V, N, C> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { pattern, value, x } = self;
        for j in 0..pattern.size() {
            let (start, end) = (pattern.starts[j], pattern.starts[j + 1]);
            let mut own = x[j];
            scale(&mut own, &value(start));
            x[j] = own;
            for (p, &i) in (start + 1..end).zip(&pattern.rows[start + 1..end]) {
                let (to, factor) = (&mut x[i as usize], value(p));
                for c in 0..C {
                    subtract_product(&mut to[c], &factor, &own[c]);
                }
            }
        }
        for j in (0..pattern.size()).rev() {
            let (start, end) = (pattern.starts[j], pattern.starts[j + 1]);
            let mut own = x[j];
            for (p, &i) in (start + 1..end).zip(&pattern.rows[start + 1..end]) {
                let (from, factor) = (&x[i as usize], value(p));
                for c in 0..C {
                    subtract_product(&mut own[c], &factor, &from[c]);
                }
            }
            scale(&mut own, &value(start));
            x[j] = own;
        }
    }
}

/// x times `factor` in each lane.
#[inline(always)]
fn scale<const N: usize, const C: usize>(x: &mut [[f64; N]; C], factor: &[f64; N]) {
    for row in x {
        for k in 0..N {
            row[k] *= factor[k];
        }
    }
}

/// y − a x in each lane.
#[inline(always)]
fn subtract_product<const N: usize>(y: &mut [f64; N], a: &[f64; N], x: &[f64; N]) {
    for k in 0..N {
        y[k] -= a[k] * x[k];
    }
}
