//! The pattern of a symmetric matrix and of its factor.

use faer::sparse::linalg::{SupernodalThreshold, cholesky::SymbolicCholeskyRaw};
use nalgebra_sparse::CscMatrix;

use super::super::symbolic::analyse;
use crate::{Error, Result};

/// The most columns that update another one together: each entry of the column is then loaded and stored once for all of them.
pub(super) const MAX_GROUP: usize = 4;

/// The pattern of a symmetric matrix A and of its Cholesky factor L, ordered by approximate minimum degree.
#[derive(Debug)]
pub struct LanePattern {
    /// For each row of A its row in L.
    places: Vec<u32>,
    /// Where each column of L starts; its first entry is the diagonal.
    pub(super) starts: Vec<usize>,
    /// The row of each entry.
    pub(super) rows: Vec<u32>,
    /// Where the updates of each column start.
    pub(super) update_starts: Vec<usize>,
    pub(super) updates: Vec<Update>,
    pub(super) what: &'static str,
}

/// Neighbouring columns of L that end in the same rows, of which the first is the column that they update.
#[derive(Clone, Copy, Debug)]
pub(super) struct Update {
    /// Where the columns end.
    pub ends: [u32; MAX_GROUP],
    /// The number of rows that they share.
    pub rows: u32,
    /// The number of columns.
    pub columns: u32,
}

impl LanePattern {
    /// Analyses the pattern of a matrix whose lower triangle is `lower`; its values are not looked at. `what` names the system in
    /// errors.
    ///
    /// # Errors
    ///
    /// [`Error::Other`] if the factor has more than 2³² entries.
    pub fn new(lower: &CscMatrix<f64>, what: &'static str) -> Result<Self> {
        let n = lower.ncols();
        let symbolic = analyse(lower, SupernodalThreshold::FORCE_SIMPLICIAL, what)?;
        let SymbolicCholeskyRaw::Simplicial(simplicial) = symbolic.raw() else {
            unreachable!("a simplicial factorisation was asked for")
        };
        if u32::try_from(simplicial.row_idx().len()).is_err() {
            return Err(Error::Other(format!("{what}: the factor has more than 2^32 entries").into()));
        }
        let places = match symbolic.perm() {
            Some(order) => order.arrays().1.iter().map(|&i| i as u32).collect(),
            None => (0..n as u32).collect(),
        };
        let starts = simplicial.col_ptr().to_vec();
        let rows: Vec<u32> = simplicial.row_idx().iter().map(|&i| i as u32).collect();
        let (update_starts, updates) = updates(&starts, &rows);
        Ok(Self { places, starts, rows, update_starts, updates, what })
    }

    /// n.
    pub fn size(&self) -> usize {
        self.places.len()
    }

    /// The number of entries of L.
    pub fn entry_count(&self) -> usize {
        self.rows.len()
    }

    /// The row of L that stands for row `i` of A.
    pub fn row(&self, i: u32) -> u32 {
        self.places[i as usize]
    }

    /// The number of the entry of L in whose place A has (i, j) and (j, i); `None` outside the pattern.
    pub fn entry(&self, i: u32, j: u32) -> Option<u32> {
        let (i, j) = (self.row(i), self.row(j));
        let column = i.min(j) as usize;
        let start = self.starts[column];
        let found = self.rows[start..self.starts[column + 1]].binary_search(&i.max(j)).ok()?;
        Some((start + found) as u32)
    }
}

/// For each column j of L the columns before it that have row j, and where these start.
fn updates(starts: &[usize], rows: &[u32]) -> (Vec<usize>, Vec<Update>) {
    let n = starts.len() - 1;
    // For each row the columns that have it, with the number of rows from there on.
    let mut firsts = vec![0; n + 1];
    (0..n).flat_map(|k| &rows[starts[k] + 1..starts[k + 1]]).for_each(|&i| firsts[i as usize + 1] += 1);
    (0..n).for_each(|i| firsts[i + 1] += firsts[i]);
    let mut next = firsts.clone();
    let mut of_rows = vec![(0, 0); firsts[n]];
    for k in 0..n {
        let below = &rows[starts[k] + 1..starts[k + 1]];
        for (p, &i) in below.iter().enumerate() {
            let next = &mut next[i as usize];
            of_rows[*next] = (k as u32, (below.len() - p) as u32);
            *next += 1;
        }
    }
    // Column k + 1 has all rows of column k where it is its parent in the elimination tree.
    let is_parent = |k: u32| rows.get(starts[k as usize] + 1) == Some(&(k + 1));
    let (mut update_starts, mut updates) = (vec![0], Vec::new());
    for j in 0..n {
        let mut list = &of_rows[firsts[j]..firsts[j + 1]];
        while let [(first, length), ..] = *list {
            let follows = |c: usize| {
                let before = first + c as u32 - 1;
                list.get(c) == Some(&(before + 1, length)) && is_parent(before)
            };
            let columns = (1..MAX_GROUP).find(|&c| !follows(c)).unwrap_or(MAX_GROUP);
            let end = |c: usize| starts.get(first as usize + c + 1).map_or(0, |&end| end as u32);
            updates.push(Update { ends: std::array::from_fn(end), rows: length, columns: columns as u32 });
            list = &list[columns..];
        }
        update_starts.push(updates.len());
    }
    (update_starts, updates)
}
