use nalgebra_sparse::CscMatrix;
use rayon::prelude::*;

/// Columns that one task sums.
const CHUNK: usize = 2048;

/// Takes sums of small dense blocks weight · Σₖ aₖ aₖᵀ into a sparse symmetric matrix.
pub trait OuterSum {
    /// Adds weight · Σₖ aₖ aₖᵀ, where row k of the gradient-like `rows` holds aₖ for the unknowns `indices`.
    ///
    /// `rows[a]` has the entries of unknown `indices[a]` in each of the K ≤ 3 rows; an unknown may be listed twice.
    fn add_outer<const K: usize>(&mut self, indices: &[u32], rows: &[[f64; K]], weight: f64);
}

/// Small dense blocks, kept as factors until all are there; faster than [`Assembly`](super::Assembly) where they are many.
///
/// Each column then sums its entries in the order of the blocks, whatever the number of threads. The sums differ from those of
/// `Assembly` by rounding, whose order of summation is another.
#[derive(Clone, Debug)]
pub struct Blocks {
    size: usize,
    /// The unknowns of all blocks, with their rows.
    members: Vec<(u32, [f64; 3])>,
    /// Where each block ends among them, and its weight.
    blocks: Vec<(u32, f64)>,
}

impl OuterSum for Blocks {
    fn add_outer<const K: usize>(&mut self, indices: &[u32], rows: &[[f64; K]], weight: f64) {
        const { assert!(K <= 3) };
        let padded = |row: &[f64; K]| std::array::from_fn(|k| if k < K { row[k] } else { 0.0 });
        self.members.extend(indices.iter().zip(rows).map(|(&i, row)| (i, padded(row))));
        self.blocks.push((self.members.len() as u32, weight));
    }
}

impl Blocks {
    /// An n × n matrix of zeros whose diagonal is stored.
    pub fn new(n: usize) -> Self {
        Self { size: n, members: vec![], blocks: vec![] }
    }

    /// The lower triangle.
    pub fn finish(self) -> CscMatrix<f64> {
        let n = self.size;
        // For each unknown the members that it is, in the order of the blocks.
        let mut starts = vec![0u32; n + 1];
        self.members.iter().for_each(|&(i, _)| starts[i as usize + 1] += 1);
        (0..n).for_each(|i| starts[i + 1] += starts[i]);
        let mut next = starts.clone();
        let mut places = vec![(0u32, 0u32); self.members.len()];
        let mut begin = 0;
        for (block, &(end, _)) in self.blocks.iter().enumerate() {
            for member in begin..end {
                let next = &mut next[self.members[member as usize].0 as usize];
                places[*next as usize] = (block as u32, member);
                *next += 1;
            }
            begin = end;
        }
        let columns: Vec<usize> = (0..n).step_by(CHUNK).collect();
        let chunk = |room: &mut Room, &first: &usize| {
            let mut sums = Chunk::default();
            for j in first..(first + CHUNK).min(n) {
                let own = &places[starts[j] as usize..starts[j + 1] as usize];
                self.sum_column(j, own, room, &mut sums);
            }
            sums
        };
        // A thread keeps its room: one for each chunk would take memory with the square of n.
        let room = || Room { place: vec![u32::MAX; n], column: vec![] };
        let chunks: Vec<Chunk> = columns.par_iter().map_init(room, chunk).collect();
        let mut offsets = Vec::with_capacity(n + 1);
        offsets.push(0);
        let count = chunks.iter().map(|chunk| chunk.rows.len()).sum();
        let (mut rows, mut values) = (Vec::with_capacity(count), Vec::with_capacity(count));
        for chunk in chunks {
            let start = rows.len();
            offsets.extend(chunk.ends.iter().map(|end| start + end));
            rows.extend(chunk.rows);
            values.extend(chunk.values);
        }
        CscMatrix::try_from_csc_data(n, n, offsets, rows, values)
            .expect("columns are sorted and each row is there once")
    }

    /// Column `j`, given the members that are its unknown.
    fn sum_column(&self, j: usize, own: &[(u32, u32)], room: &mut Room, sums: &mut Chunk) {
        let (Room { place, column }, Chunk { rows, values, ends }) = (room, sums);
        column.clear();
        column.push((j, 0.0));
        place[j] = 0;
        for &(block, member) in own {
            let begin = if block == 0 { 0 } else { self.blocks[block as usize - 1].0 };
            let (end, weight) = self.blocks[block as usize];
            let (_, b) = &self.members[member as usize];
            for (i, a) in &self.members[begin as usize..end as usize] {
                let i = *i as usize;
                if i < j {
                    continue;
                }
                let product = weight * (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]);
                let place = &mut place[i];
                if *place == u32::MAX {
                    *place = column.len() as u32;
                    column.push((i, product));
                } else {
                    column[*place as usize].1 += product;
                }
            }
        }
        column.iter().for_each(|&(i, _)| place[i] = u32::MAX);
        column.sort_unstable_by_key(|&(i, _)| i);
        rows.extend(column.iter().map(|&(i, _)| i));
        values.extend(column.iter().map(|&(_, value)| value));
        ends.push(rows.len());
    }
}

/// Some columns of the sum.
#[derive(Default)]
struct Chunk {
    rows: Vec<usize>,
    values: Vec<f64>,
    ends: Vec<usize>,
}

/// What the sum of a column needs.
struct Room {
    /// For each row its place in the column; the largest number where it has none.
    place: Vec<u32>,
    column: Vec<(usize, f64)>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{linalg::Assembly, testkit::random::Random};

    #[test]
    fn blocks_sum_to_what_an_assembly_sums() {
        let n = 3 * CHUNK;
        let mut random = Random::new(5);
        let (mut blocks, mut assembly) = (Blocks::new(n), Assembly::new(n));
        let mut add = |indices: &[u32], rows: &[[f64; 3]], weight| {
            blocks.add_outer(indices, rows, weight);
            assembly.add_outer(indices, rows, weight);
        };
        for i in 0..n as u32 - 9 {
            let rows: [[f64; 3]; 4] = std::array::from_fn(|_| random.vector().into());
            // Some unknowns are listed twice, some columns have only their diagonal.
            add(&[i, (7 * i + 3) % (n as u32 - 9), i + 4, i], &rows, 0.5 + f64::from(i % 3));
        }
        let (a, b) = (blocks.finish(), assembly.finish());
        assert_eq!(a.pattern(), b.pattern());
        for (a, b) in a.values().iter().zip(b.values()) {
            // A few roundings of sums of numbers up to 2.5.
            assert!((a - b).abs() < 1e-13, "{a} and {b}");
        }
    }

    #[test]
    fn threads_do_not_change_the_sum() {
        let n = 2 * CHUNK + 5;
        let sum = || {
            let mut blocks = Blocks::new(n);
            (0..n as u32 - 3).for_each(|i| blocks.add_outer(&[i + 3, i], &[[0.1 + f64::from(i)], [-0.3]], 1.0 / 3.0));
            blocks.finish()
        };
        let on = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(sum);
        assert_eq!(on(1), on(3));
    }
}
