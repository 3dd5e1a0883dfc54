//! Which unknowns are joined, and how a coarse solution is taken to fine ones.

use super::{
    cycle::{COARSEST, Prolongation},
    rows::Rows,
};

/// Unknowns i and j are joined if a_ij² is more than this part of a_ii a_jj.
const STRONG: f32 = 1.6e-3;

/// ω of P = (I − ω D⁻¹ A) P₀: 4/3 over the largest eigenvalue of D⁻¹ A, about 2 for a Laplacian of triangles.
const SMOOTHING: f32 = 0.66;

/// So many times at most.
const MAX_LEVELS: usize = 12;

/// The matrices of all levels, the finest first, and what takes solutions from each to the one before.
pub(super) fn prolongations(finest: Rows) -> (Vec<Rows>, Vec<Prolongation>) {
    let (mut matrices, mut prolongations) = (vec![finest], vec![]);
    loop {
        let matrix = &matrices[matrices.len() - 1];
        if matrix.count() <= COARSEST || matrices.len() == MAX_LEVELS {
            break;
        }
        let (aggregates, count) = aggregates(matrix);
        // Where nearly nothing is joined, as between components, a coarser level gains nothing.
        if 10 * count > 9 * matrix.count() {
            break;
        }
        let prolongation = Prolongation::new(smoothed(matrix, aggregates, count), count);
        matrices.push(prolongation.coarse(matrix));
        prolongations.push(prolongation);
    }
    (matrices, prolongations)
}

/// P from the aggregate of each unknown.
fn smoothed(matrix: &Rows, aggregates: Vec<u32>, count: usize) -> Rows {
    let n = matrix.count();
    let inverse = matrix.inverse_diagonal();
    let mut smoothing = matrix.clone();
    for (i, inverse) in inverse.iter().enumerate() {
        for k in matrix.starts[i] as usize..matrix.starts[i + 1] as usize {
            let identity = if matrix.columns[k] as usize == i { 1.0 } else { 0.0 };
            smoothing.values[k] = identity - SMOOTHING * inverse * matrix.values[k];
        }
    }
    smoothing.times(&Rows { starts: (0..=n as u32).collect(), columns: aggregates, values: vec![1.0; n] }, count)
}

/// The aggregate of each unknown, and their number: an unknown with all that it is strongly tied to, where none of them has one yet;
/// others join that to which they are tied most.
fn aggregates(matrix: &Rows) -> (Vec<u32>, usize) {
    const NONE: u32 = u32::MAX;
    let n = matrix.count();
    let inverse = &matrix.inverse_diagonal();
    let strong = |i: usize| {
        let is_strong =
            move |&(j, value): &(usize, f32)| j != i && value < 0.0 && value * value * inverse[i] * inverse[j] > STRONG;
        matrix.row(i).filter(is_strong)
    };
    let mut aggregates = vec![NONE; n];
    let mut count = 0;
    for i in 0..n {
        if aggregates[i] == NONE && strong(i).next().is_some() && strong(i).all(|(j, _)| aggregates[j] == NONE) {
            aggregates[i] = count;
            strong(i).for_each(|(j, _)| aggregates[j] = count);
            count += 1;
        }
    }
    let first = aggregates.clone();
    for (i, aggregate) in aggregates.iter_mut().enumerate().filter(|(_, aggregate)| **aggregate == NONE) {
        let tied = strong(i).filter(|&(j, _)| first[j] != NONE);
        let most = tied.min_by(|a, b| a.1.total_cmp(&b.1));
        *aggregate = most.map_or(NONE, |(j, _)| first[j]);
    }
    for i in 0..n {
        if aggregates[i] == NONE {
            aggregates[i] = count;
            for (j, _) in strong(i) {
                if aggregates[j] == NONE {
                    aggregates[j] = count;
                }
            }
            count += 1;
        }
    }
    (aggregates, count as usize)
}
