//! The energy of a group in the order of elimination, in which active sets work.

use nalgebra_sparse::CscMatrix;

use crate::bilaplacian::Bilaplacian;

/// No number, in lists of numbers.
pub const NONE: u32 = u32::MAX;

/// All entries of a symmetric matrix by rows, the columns of a row ascending.
#[derive(Clone, Debug)]
pub struct Rows {
    starts: Vec<usize>,
    columns: Vec<u32>,
    values: Vec<f64>,
}

impl Rows {
    /// The matrix whose lower triangle is `lower`, with unknown i at `place[i]`.
    pub fn new(lower: &CscMatrix<f64>, place: &[u32]) -> Self {
        let entries = || lower.triplet_iter().map(|(i, j, &value)| (place[i], place[j], value));
        let both = |(i, j, value): (u32, u32, f64)| [Some((i, j, value)), (i != j).then_some((j, i, value))];
        let by_row = Self::bucketed(place.len(), || entries().flat_map(both).flatten());
        // A second pass in the order of rows, which are columns as well, leaves each row sorted.
        Self::bucketed(place.len(), || {
            (0..place.len()).flat_map(|j| by_row.row(j).map(move |(i, value)| (i as u32, j as u32, value)))
        })
    }

    /// Rows of `entries` (row, column, value), each in the order its entries come in.
    pub fn bucketed<I: Iterator<Item = (u32, u32, f64)>>(rows: usize, entries: impl Fn() -> I) -> Self {
        let mut starts = vec![0; rows + 1];
        entries().for_each(|(i, ..)| starts[i as usize + 1] += 1);
        (0..rows).for_each(|i| starts[i + 1] += starts[i]);
        let mut next = starts.clone();
        let (mut columns, mut values) = (vec![0; starts[rows]], vec![0.0; starts[rows]]);
        for (i, j, value) in entries() {
            let at = &mut next[i as usize];
            (columns[*at], values[*at]) = (j, value);
            *at += 1;
        }
        Self { starts, columns, values }
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.starts.len() - 1
    }

    /// Columns of the entries of row `i`.
    pub fn columns(&self, i: usize) -> &[u32] {
        &self.columns[self.starts[i]..self.starts[i + 1]]
    }

    /// Column and value of each entry of row `i`.
    pub fn row(&self, i: usize) -> impl Iterator<Item = (usize, f64)> {
        let range = self.starts[i]..self.starts[i + 1];
        self.columns[range.clone()].iter().zip(&self.values[range]).map(|(&j, &value)| (j as usize, value))
    }

    /// Row `i` times x.
    pub fn dot(&self, i: usize, x: &[f64]) -> f64 {
        self.row(i).map(|(j, value)| value * x[j]).sum()
    }
}

/// Q, L and M⁻¹ with unknowns in an order that leaves factors of Q, and of parts of it, little fill.
#[derive(Debug)]
pub struct Level {
    /// Q.
    pub energy: Rows,
    /// The diagonal of Q.
    pub diagonal: Vec<f64>,
    /// L.
    pub laplacian: Rows,
    /// The diagonal of M⁻¹.
    pub inverse_mass: Vec<f64>,
    /// The place of each unknown.
    pub place: Vec<u32>,
}

impl Level {
    /// `energy` with its unknowns in `order`.
    pub fn new(energy: &Bilaplacian, order: &[usize]) -> Self {
        let mut place = vec![0; order.len()];
        order.iter().enumerate().for_each(|(k, &i)| place[i] = k as u32);
        let rows = Rows::new(&energy.matrix, &place);
        let own = |i: usize| rows.row(i).find(|&(j, _)| j == i).map_or(0.0, |(_, value)| value);
        Self {
            diagonal: (0..rows.count()).map(own).collect(),
            energy: rows,
            laplacian: Rows::new(&energy.laplacian, &place),
            inverse_mass: order.iter().map(|&i| energy.inverse_mass[i]).collect(),
            place,
        }
    }

    /// How many unknowns there are.
    pub fn size(&self) -> usize {
        self.place.len()
    }

    /// Values of unknowns from values at places.
    pub fn of_unknowns(&self, at_places: &[f64]) -> Vec<f64> {
        self.place.iter().map(|&k| at_places[k as usize]).collect()
    }

    /// The lower triangle of Q over `free`, ascending places, which it puts into a postorder of their elimination tree: fill
    /// stays what it is, and columns of one pattern come to stand beside each other.
    ///
    /// `number` is [`NONE`] everywhere, and then the number of each of them in that order.
    pub fn restricted(&self, free: &mut Vec<u32>, number: &mut [u32]) -> CscMatrix<f64> {
        free.iter().zip(0..).for_each(|(&i, k)| number[i as usize] = k);
        let order = postorder(&self.elimination_tree(free, number));
        *free = order.iter().map(|&k| free[k as usize]).collect();
        free.iter().zip(0..).for_each(|(&i, k)| number[i as usize] = k);
        let mut starts = Vec::with_capacity(free.len() + 1);
        let (mut rows, mut values) = (Vec::with_capacity(12 * free.len()), Vec::with_capacity(12 * free.len()));
        let mut column = Vec::new();
        starts.push(0);
        for (&i, k) in free.iter().zip(0..) {
            column.clear();
            let entries = self.energy.row(i as usize).map(|(j, value)| (number[j], value));
            column.extend(entries.filter(|&(row, _)| row != NONE && row >= k));
            column.sort_unstable_by_key(|&(row, _)| row);
            rows.extend(column.iter().map(|&(row, _)| row as usize));
            values.extend(column.iter().map(|&(_, value)| value));
            starts.push(rows.len());
        }
        CscMatrix::try_from_csc_data(free.len(), free.len(), starts, rows, values).expect("sorted columns")
    }

    /// The parent of each of `free` in the elimination tree of Q over them [Liu 1990], [`NONE`] for a root.
    fn elimination_tree(&self, free: &[u32], number: &[u32]) -> Vec<u32> {
        let (mut parent, mut ancestor) = (vec![NONE; free.len()], vec![NONE; free.len()]);
        for (&i, k) in free.iter().zip(0..) {
            for &j in self.energy.columns(i as usize).iter().take_while(|&&j| j < i) {
                let mut at = number[j as usize];
                while at != NONE && ancestor[at as usize] != k {
                    let next = ancestor[at as usize];
                    // Paths are made short on the way.
                    ancestor[at as usize] = k;
                    if next == NONE {
                        parent[at as usize] = k;
                        break;
                    }
                    at = next;
                }
            }
        }
        parent
    }
}

/// The nodes of a forest, each after its children.
fn postorder(parent: &[u32]) -> Vec<u32> {
    let count = parent.len();
    let (mut first_child, mut sibling) = (vec![NONE; count], vec![NONE; count]);
    for k in (0..count).rev().filter(|&k| parent[k] != NONE) {
        let parent = parent[k] as usize;
        sibling[k] = first_child[parent];
        first_child[parent] = k as u32;
    }
    let (mut order, mut stack) = (Vec::with_capacity(count), Vec::new());
    for root in (0..count).filter(|&k| parent[k] == NONE) {
        stack.push(root as u32);
        while let Some(&top) = stack.last() {
            let child = std::mem::replace(&mut first_child[top as usize], NONE);
            if child == NONE {
                order.push(top);
                stack.pop();
            } else {
                first_child[top as usize] = sibling[child as usize];
                stack.push(child);
            }
        }
    }
    order
}
