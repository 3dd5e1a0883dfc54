//! The structure of a multifrontal factorisation: which columns are eliminated together, and how fronts add up.

use std::ops::Range;

use faer::sparse::linalg::cholesky::supernodal::SymbolicSupernodalCholesky;
use nalgebra_sparse::CscMatrix;

use super::{
    kernel::LANES,
    merge::{Forest, Node},
};
use crate::memory::bytes_of;

/// Trees of fronts with more than this part of all work may run on threads of their own.
const SPLIT: f64 = 1.0 / 24.0;

/// Columns that are eliminated together, with the rows they act on.
#[derive(Debug)]
pub(super) struct Front {
    /// The first of its columns.
    pub start: usize,
    pub columns: usize,
    /// Rows below its columns, in ascending order.
    pub below: Vec<u32>,
    /// For each of them its place in the front above.
    pub above: Vec<u32>,
    /// The fronts that add to it.
    pub children: Vec<u32>,
    /// Where its columns start among all values.
    pub values: usize,
    /// The entries of the matrix that belong to it, among all.
    pub entries: Range<usize>,
}

impl Front {
    pub fn rows(&self) -> usize {
        self.columns + self.below.len()
    }

    /// Values from one column to the next: rows are padded to whole blocks.
    pub fn stride(&self) -> usize {
        self.rows().next_multiple_of(LANES)
    }

    /// Number of values of its columns.
    pub fn size(&self) -> usize {
        self.stride() * self.columns
    }
}

/// A run of fronts, right behind those of the segments that add to it.
#[derive(Debug)]
pub(super) struct Segment {
    pub fronts: Range<usize>,
    pub children: Vec<Segment>,
}

/// All fronts; those that add to one come before it.
#[derive(Debug)]
pub(super) struct Fronts {
    pub fronts: Vec<Front>,
    pub root: Segment,
    /// For each column of the factor the row of the matrix that it eliminates.
    pub order: Vec<u32>,
    /// For each entry of the matrix its place in its front and its place among the values of the matrix, by fronts.
    pub entries: Vec<[u32; 2]>,
    /// Number of values of all fronts.
    pub size: usize,
}

impl Fronts {
    /// The fronts of the matrix whose lower triangle is `lower`; `order` has the row of each column of `symbolic`.
    pub fn new(lower: &CscMatrix<f64>, symbolic: &SymbolicSupernodalCholesky<usize>, order: &[usize]) -> Self {
        let mut forest = Forest::new(symbolic);
        let work: Vec<f64> = forest.nodes.iter().map(|node| node.work).collect();
        let is_heavy = |s: usize| work[s] > SPLIT * forest.work;
        // Heavy ones come first, so that a run of fronts lies together.
        forest.nodes.iter_mut().for_each(|node| node.children.sort_by_key(|&c| !is_heavy(c)));
        forest.roots.sort_by_key(|&c| !is_heavy(c));
        let sequence = sequence(&forest);

        let n = lower.ncols();
        let mut rows = Vec::with_capacity(n);
        let (mut inverse, mut front_of) = (vec![0; n], vec![0; n]);
        let (mut new_column, mut place) = (vec![0; n], vec![0; forest.nodes.len()]);
        for (f, &s) in sequence.iter().enumerate() {
            place[s] = f;
            for &c in &forest.nodes[s].columns {
                new_column[c as usize] = rows.len() as u32;
                inverse[order[c as usize]] = rows.len();
                front_of[rows.len()] = f;
                rows.push(order[c as usize] as u32);
            }
        }
        let (mut start, mut values) = (0, 0);
        let front = |&s: &usize| {
            let Node { columns, below, children, .. } = &forest.nodes[s];
            let mut below: Vec<u32> = below.iter().map(|&r| new_column[r as usize]).collect();
            below.sort_unstable();
            let children = children.iter().map(|&c| place[c] as u32).collect();
            let columns = columns.len();
            let front = Front { start, columns, below, above: vec![], children, values, entries: 0..0 };
            start += columns;
            values += front.size();
            front
        };
        let mut fronts: Vec<Front> = sequence.iter().map(front).collect();
        for f in 0..fronts.len() {
            if let Some(&first) = fronts[f].below.first() {
                fronts[f].above = places_in(&fronts[front_of[first as usize]], &fronts[f].below);
            }
        }
        let entries = entries(lower, &mut fronts, &inverse, &front_of);
        let root = Segments { forest: &forest, place: &place, is_heavy, count: fronts.len() }.below(None);
        Self { fronts, root, order: rows, entries, size: values }
    }

    /// The bytes of the values, and of what fronts leave while they are computed one after the other.
    pub fn bytes(&self) -> u64 {
        let (mut left, mut now, mut most) = (Vec::new(), 0, 0);
        for front in &self.fronts {
            let rest = front.stride() * front.below.len();
            most = most.max(now + rest);
            now += rest;
            for _ in &front.children {
                now -= left.pop().unwrap_or(0);
            }
            left.push(rest);
        }
        bytes_of::<f64>(self.size + most)
    }

    /// The first column and the first value of front `f`, or the numbers of all behind the last.
    pub fn start(&self, f: usize) -> (usize, usize) {
        self.fronts.get(f).map_or((self.order.len(), self.size), |front| (front.start, front.values))
    }
}

/// The nodes that are there, children before parents.
fn sequence(forest: &Forest) -> Vec<usize> {
    let mut sequence = Vec::with_capacity(forest.nodes.len());
    // Chains may be too long for recursion.
    let mut stack: Vec<(usize, usize)> = forest.roots.iter().rev().map(|&root| (root, 0)).collect();
    while let Some((s, next)) = stack.pop() {
        match forest.nodes[s].children.get(next) {
            Some(&child) => stack.extend([(s, next + 1), (child, 0)]),
            None => sequence.push(s),
        }
    }
    sequence
}

/// The places of `rows`, in ascending order, in `front`, which has all of them.
fn places_in(front: &Front, rows: &[u32]) -> Vec<u32> {
    let mut at = 0;
    let place = |&row: &u32| {
        let row = row as usize;
        if row < front.start + front.columns {
            return (row - front.start) as u32;
        }
        at += front.below[at..].iter().take_while(|&&other| (other as usize) < row).count();
        (front.columns + at) as u32
    };
    rows.iter().map(place).collect()
}

/// Tells each front its entries of the matrix and returns their places.
fn entries(lower: &CscMatrix<f64>, fronts: &mut [Front], inverse: &[usize], front_of: &[usize]) -> Vec<[u32; 2]> {
    let mut starts = vec![0; fronts.len() + 1];
    let pair = |i: usize, j: usize| {
        let (i, j) = (inverse[i], inverse[j]);
        (i.max(j), i.min(j))
    };
    lower.triplet_iter().for_each(|(i, j, _)| starts[front_of[pair(i, j).1] + 1] += 1);
    (0..fronts.len()).for_each(|f| starts[f + 1] += starts[f]);
    fronts.iter_mut().zip(starts.windows(2)).for_each(|(front, ends)| front.entries = ends[0]..ends[1]);
    let mut entries = vec![[0, 0]; lower.nnz()];
    for (entry, (i, j, _)) in lower.triplet_iter().enumerate() {
        let (row, column) = pair(i, j);
        let front = &fronts[front_of[column]];
        let inside = row - front.start;
        let row = if inside < front.columns {
            inside
        } else {
            front.columns + front.below.partition_point(|&other| (other as usize) < row)
        };
        let next = &mut starts[front_of[column]];
        entries[*next] = [((column - front.start) * front.stride() + row) as u32, entry as u32];
        *next += 1;
    }
    entries
}

/// Makes segments.
struct Segments<'a, F> {
    forest: &'a Forest,
    /// The front of each node.
    place: &'a [usize],
    is_heavy: F,
    /// Number of fronts.
    count: usize,
}

impl<F: Fn(usize) -> bool> Segments<'_, F> {
    /// The segment that ends with node `last`, or with the last front of all.
    fn below(&self, last: Option<usize>) -> Segment {
        let end = last.map_or(self.count, |s| self.place[s] + 1);
        let children = |s: usize| &self.forest.nodes[s].children;
        let mut top = last.map_or(&self.forest.roots, |s| children(s));
        let mut lowest = last;
        loop {
            // Heavy ones come first.
            let heavy = &top[..top.iter().take_while(|&&s| (self.is_heavy)(s)).count()];
            match *heavy {
                [] => {
                    let mut first = top.first().copied().or(lowest);
                    while let Some(&child) = first.and_then(|s| children(s).first()) {
                        first = Some(child);
                    }
                    return Segment { fronts: first.map_or(end, |s| self.place[s])..end, children: vec![] };
                }
                [only] => (top, lowest) = (children(only), Some(only)),
                [.., last] => {
                    let children = heavy.iter().map(|&s| self.below(Some(s))).collect();
                    return Segment { fronts: self.place[last] + 1..end, children };
                }
            }
        }
    }
}
