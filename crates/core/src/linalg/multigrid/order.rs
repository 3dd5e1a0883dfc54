use nalgebra_sparse::CscMatrix;

/// A row for each unknown of a symmetric matrix, so that neighbours lie close in memory: unknowns come in waves from the first one
/// [Cuthill and McKee 1969].
pub(super) fn waves(lower: &CscMatrix<f64>) -> Vec<u32> {
    let n = lower.ncols();
    let mut starts = vec![0; n + 1];
    for (i, j, _) in lower.triplet_iter().filter(|(i, j, _)| i != j) {
        starts[i + 1] += 1;
        starts[j + 1] += 1;
    }
    (0..n).for_each(|i| starts[i + 1] += starts[i]);
    let mut next = starts.clone();
    let mut neighbours = vec![0; starts[n]];
    for (i, j, _) in lower.triplet_iter().filter(|(i, j, _)| i != j) {
        for (from, to) in [(i, j), (j, i)] {
            neighbours[next[from]] = to as u32;
            next[from] += 1;
        }
    }
    let mut row_of = vec![u32::MAX; n];
    let mut queue: Vec<u32> = Vec::with_capacity(n);
    for first in 0..n {
        if row_of[first] != u32::MAX {
            continue;
        }
        let mut at = queue.len();
        row_of[first] = at as u32;
        queue.push(first as u32);
        while let Some(&v) = queue.get(at) {
            at += 1;
            for &w in &neighbours[starts[v as usize]..starts[v as usize + 1]] {
                if row_of[w as usize] == u32::MAX {
                    row_of[w as usize] = queue.len() as u32;
                    queue.push(w);
                }
            }
        }
    }
    row_of
}
