//! Sparse Cholesky factorisation by fronts (Duff and Reid 1983), for matrices that are factored often.

mod fronts;
mod kernel;
mod large;
mod merge;
mod room;
mod solve;

use std::{fmt, ops::Range, sync::Arc};

use faer::sparse::linalg::{SupernodalThreshold, cholesky::SymbolicCholeskyRaw};
use nalgebra_sparse::CscMatrix;
use pulp::{Arch, NullaryFnOnce};

use self::{
    fronts::{Front, Fronts, Segment},
    kernel::Dense,
    room::Room,
};
use super::symbolic::{analyse, singular};
use crate::{Error, Result, memory::need};

/// A sparse Cholesky factorisation A = L Lᵀ whose values change often, or which is solved with for several right-hand sides at once,
/// ordered by approximate minimum degree.
///
/// Every column is eliminated in a small dense matrix, its front, with others of nearly the same rows; what a front leaves is added
/// to the front above. Fronts of separate trees run beside each other. Which trees these are, and the order in which fronts add
/// up, depend on the pattern alone, so that results are the same on any number of threads.
///
/// On the matrix of a fit of 22,000 vertices a factorisation takes 0.45 of the time of [`Cholesky`](super::Cholesky).
#[derive(Clone)]
pub struct Multifrontal {
    fronts: Arc<Fronts>,
    /// The columns of L, front by front.
    values: Vec<f64>,
    /// Where each column of the matrix starts among its values, with its diagonal.
    column_starts: Arc<[usize]>,
    /// Room for what fronts leave, to be used again by the next factorisation.
    room: Arc<Room>,
    /// The name of the system in errors.
    what: &'static str,
}

/// What the fronts before the next one leave for those above, the last one last.
type Left = Vec<Vec<f64>>;

impl Multifrontal {
    /// Prepares for matrices with the pattern of `lower`, a lower triangle; `what` names the system in errors.
    ///
    /// # Errors
    ///
    /// [`Error::Other`] if the pattern cannot be analysed.
    pub fn new(lower: &CscMatrix<f64>, what: &'static str) -> Result<Self> {
        let symbolic = analyse(lower, SupernodalThreshold::FORCE_SUPERNODAL, what)?;
        let (SymbolicCholeskyRaw::Supernodal(supernodes), Some(order)) = (symbolic.raw(), symbolic.perm()) else {
            return Err(Error::Other(format!("{what}: no supernodes").into()));
        };
        let fronts = Fronts::new(lower, supernodes, order.arrays().0);
        need(what, fronts.bytes())?;
        let values = vec![0.0; fronts.size];
        let column_starts = lower.col_offsets().into();
        Ok(Self { fronts: Arc::new(fronts), values, column_starts, room: Arc::default(), what })
    }

    /// The factorisation of `lower`, a lower triangle; `what` names the system in errors.
    ///
    /// # Errors
    ///
    /// [`Error::Singular`] if it is not positive definite, and the errors of [`new`](Self::new).
    pub fn factored(lower: &CscMatrix<f64>, what: &'static str) -> Result<Self> {
        let mut result = Self::new(lower, what)?;
        if !result.factor(lower.values()) {
            return Err(singular(what));
        }
        result.room = Arc::default();
        Ok(result)
    }

    /// The bytes of another factorisation of this pattern, while it is computed.
    pub fn bytes(&self) -> u64 {
        self.fronts.bytes()
    }

    /// Another factorisation of matrices with this pattern, to be given its values.
    pub fn for_refactoring(&self) -> Self {
        let values = vec![0.0; self.values.len()];
        let (fronts, column_starts) = (self.fronts.clone(), self.column_starts.clone());
        Self { fronts, values, column_starts, room: Arc::default(), what: self.what }
    }

    /// n.
    pub fn size(&self) -> usize {
        self.fronts.order.len()
    }

    /// Number of entries of a matrix.
    pub fn entry_count(&self) -> usize {
        self.column_starts[self.size()]
    }

    /// The error of a matrix that is not positive definite; it names the system.
    pub fn singular(&self) -> Error {
        singular(self.what)
    }

    /// Factors the matrix with these values (lower triangle, CSC order); `false` if it is not positive definite.
    #[must_use]
    pub fn factor(&mut self, matrix: &[f64]) -> bool {
        let numeric = Numeric { fronts: &self.fronts, matrix, room: &self.room };
        if numeric.segment(&self.fronts.root, 0, &mut self.values).is_none() {
            return false;
        }
        // A semi-definite matrix may leave a pivot of rounding instead of none.
        let smallest = 16.0 * f64::EPSILON * (self.fronts.order.len() as f64).sqrt();
        self.fronts.fronts.iter().all(|front| {
            let values = &self.values[front.values..][..front.size()];
            (0..front.columns).all(|c| {
                let row = self.fronts.order[front.start + c];
                // The diagonal comes first in each column of a sorted lower triangle.
                values[c * front.stride() + c].powi(2) > smallest * matrix[self.column_starts[row as usize]]
            })
        })
    }
}

impl fmt::Debug for Multifrontal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Multifrontal(n = {}, {} entries)", self.size(), self.values.len())
    }
}

/// A factorisation while it runs. `None` stands for a matrix that is not positive definite.
#[derive(Clone, Copy)]
struct Numeric<'a> {
    fronts: &'a Fronts,
    matrix: &'a [f64],
    room: &'a Room,
}

impl Numeric<'_> {
    /// Factors a segment and all before it that adds to it; `values` are theirs, from place `offset` on.
    fn segment(self, segment: &Segment, offset: usize, values: &mut [f64]) -> Option<Left> {
        let (_, start) = self.fronts.start(segment.fronts.start);
        let (before, values) = values.split_at_mut(start - offset);
        let left = self.segments(&segment.children, offset, before)?;
        Arch::new().dispatch(Run { numeric: self, range: segment.fronts.clone(), values, left })
    }

    fn segments(self, segments: &[Segment], offset: usize, values: &mut [f64]) -> Option<Left> {
        match segments {
            [] => Some(vec![]),
            [only] => self.segment(only, offset, values),
            _ => {
                let (first, second) = segments.split_at(segments.len() / 2);
                let (_, middle) = self.fronts.start(first[first.len() - 1].fronts.end);
                let (a, b) = values.split_at_mut(middle - offset);
                let (a, b) = rayon::join(|| self.segments(first, offset, a), || self.segments(second, middle, b));
                let mut left = a?;
                left.extend(b?);
                Some(left)
            }
        }
    }
}

/// A run of fronts, one after another, with the widest vectors that the processor has.
struct Run<'a> {
    numeric: Numeric<'a>,
    range: Range<usize>,
    /// Values of these fronts.
    values: &'a mut [f64],
    left: Left,
}

impl NullaryFnOnce for Run<'_> {
    type Output = Option<Left>;

    #[inline(always)]
    fn call(self) -> Option<Left> {
        let Self { numeric: Numeric { fronts, matrix, room }, range, values, mut left } = self;
        let (_, offset) = fronts.start(range.start);
        for f in range {
            let front = &fronts.fronts[f];
            let pivots = &mut values[front.values - offset..][..front.size()];
            pivots.fill(0.0);
            for &[place, entry] in &fronts.entries[front.entries.clone()] {
                pivots[place as usize] = matrix[entry as usize];
            }
            let mut rest = room.take(front.stride() * front.below.len());
            let first = left.len() - front.children.len();
            for (&child, values) in front.children.iter().zip(left.drain(first..)) {
                add(&fronts.fronts[child as usize], &values, front, pivots, &mut rest);
                room.give(values);
            }
            let (stride, columns, rows) = (front.stride(), front.columns, front.rows());
            let dense = Dense { pivots, rest: &mut rest, stride, columns, rows };
            let is_positive = if dense.is_large() { dense.eliminate_panels() } else { dense.eliminate() };
            if !is_positive {
                return None;
            }
            left.push(rest);
        }
        Some(left)
    }
}

/// Adds what `child` leaves to the front above.
#[inline(always)]
fn add(child: &Front, left: &[f64], front: &Front, pivots: &mut [f64], rest: &mut [f64]) {
    let stride = front.stride();
    for (j, (&column, from)) in child.above.iter().zip(left.chunks_exact(child.stride())).enumerate() {
        let column = column as usize;
        let to = match column.checked_sub(front.columns) {
            None => &mut pivots[column * stride..][..stride],
            Some(column) => &mut rest[column * stride..][..stride],
        };
        let from = &from[child.columns + j..child.rows()];
        for (&row, value) in child.above[j..].iter().zip(from) {
            to[row as usize] += value;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        linalg::{Assembly, Cholesky},
        operators::{cotangent_laplacian, voronoi_mass},
        testkit::{meshes, random::Random},
    };

    /// A matrix with the pattern of a bilaplacian of a sphere, one or more times beside itself, as a lower triangle.
    fn bilaplacian(level: usize, copies: usize) -> CscMatrix<f64> {
        let surface = meshes::icosphere(level);
        let laplacian = cotangent_laplacian(&surface.positions, &surface.triangles);
        let mass = voronoi_mass(&surface.positions, &surface.triangles);
        let n = mass.len();
        let mut assembly = Assembly::new(n * copies);
        for copy in 0..copies {
            for (i, row) in laplacian.col_iter().enumerate() {
                let indices: Vec<u32> = row.row_indices().iter().map(|&j| (copy * n + j) as u32).collect();
                let rows: Vec<[f64; 1]> = row.values().iter().map(|&value| [value]).collect();
                assembly.add_outer(&indices, &rows, 1.0 / mass[i]);
                assembly.add(copy * n + i, copy * n + i, mass[i]);
            }
        }
        assembly.finish()
    }

    fn far(a: &[f64], b: &[f64]) -> f64 {
        a.iter().zip(b).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn solutions_are_those_of_another_factorisation() {
        for (level, copies) in [(0, 1), (1, 1), (3, 1), (4, 1), (0, 40), (3, 3)] {
            let lower = bilaplacian(level, copies);
            let n = lower.ncols();
            let mut random = Random::new(level as u64);
            // More right-hand sides than are solved at once.
            let mut x: Vec<f64> = (0..2 * n).flat_map(|_| <[f64; 3]>::from(random.vector())).collect();
            let mut y = x.clone();
            let mut fronts = Multifrontal::new(&lower, "the test").unwrap();
            for scale in [1.0, 2.0] {
                let values: Vec<f64> = lower.values().iter().map(|value| scale * value).collect();
                assert!(fronts.factor(&values));
                fronts.solve_in_place(&mut x);
                let other = CscMatrix::try_from_pattern_and_values(lower.pattern().clone(), values).unwrap();
                Cholesky::new(other, "the test").unwrap().solve_in_place(&mut y, 6);
                let size = y.iter().fold(0.0_f64, |most, y| most.max(y.abs()));
                // Rounding at a condition of up to 1e7.
                assert!(far(&x, &y) < 1e-8 * size, "{level}, {copies}: {} of {size}", far(&x, &y));
            }
        }
    }

    /// Two dense blocks that share some unknowns.
    fn dense() -> CscMatrix<f64> {
        let mut assembly = Assembly::new(900);
        for i in 0..900_usize {
            for j in (0..i).filter(|&j| i >= 800 || i / 400 == j / 400) {
                assembly.add(i, j, 0.5 / (1 + i - j) as f64);
            }
            assembly.add(i, i, 9.0);
        }
        assembly.finish()
    }

    #[test]
    fn large_fronts_have_the_same_solution() {
        let lower = dense();
        let mut fronts = Multifrontal::new(&lower, "the test").unwrap();
        let sizes: Vec<_> = fronts.fronts.fronts.iter().map(|front| (front.columns, front.below.len())).collect();
        assert!(sizes.iter().any(|&(columns, below)| columns > 250 && below > 50), "{sizes:?}");
        assert!(fronts.factor(lower.values()));
        let mut x: Vec<f64> = (0..lower.ncols()).map(|i| (i as f64).sin()).collect();
        let mut y = x.clone();
        fronts.solve_in_place(&mut x);
        Cholesky::new(lower.clone(), "the test").unwrap().solve_in_place(&mut y, 1);
        // Rounding at a condition of about 2.
        assert!(far(&x, &y) < 1e-14, "{}", far(&x, &y));
        let mut values = lower.values().to_vec();
        values[lower.col_offsets()[700]] = -1.0;
        assert!(!fronts.factor(&values));
    }

    #[test]
    fn no_right_hand_side_changes_the_solution_of_another() {
        let lower = bilaplacian(3, 2);
        let fronts = Multifrontal::factored(&lower, "the test").unwrap();
        let n = lower.ncols();
        let column = |k: usize| (0..n).map(move |i| ((i * (k + 2)) as f64).sin());
        // Fewer, as many, and more than are solved for at once.
        for count in [1, 3, 4, 5, 8, 9, 15] {
            let mut together: Vec<f64> = (0..count).flat_map(column).collect();
            fronts.solve_in_place(&mut together);
            for (k, found) in together.chunks(n).enumerate() {
                let mut alone: Vec<f64> = column(k).collect();
                fronts.solve_in_place(&mut alone);
                assert!(alone == found, "column {k} of {count}");
            }
        }
    }

    #[test]
    fn a_factorisation_that_finds_room_of_another_is_the_same() {
        let lower = bilaplacian(4, 1);
        let mut fronts = Multifrontal::new(&lower, "the test").unwrap();
        assert!(fronts.factor(lower.values()));
        let first = fronts.values.clone();
        assert!(fronts.factor(&lower.values().iter().map(|value| 3.0 * value).collect::<Vec<_>>()));
        assert!(first != fronts.values);
        assert!(fronts.factor(lower.values()));
        assert!(first == fronts.values);
    }

    #[test]
    fn threads_do_not_change_a_bit() {
        let lower = bilaplacian(4, 2);
        let fronts = Multifrontal::new(&lower, "the test").unwrap().fronts;
        assert!(!fronts.root.children.is_empty(), "something runs beside something else");
        // Parts of a large front do so, too.
        [lower, dense()].iter().for_each(threads_do_not_change);
    }

    fn threads_do_not_change(lower: &CscMatrix<f64>) {
        let solve = || {
            let mut fronts = Multifrontal::new(lower, "the test").unwrap();
            assert!(fronts.factor(lower.values()));
            let mut x: Vec<f64> = (0..3 * lower.ncols()).map(|i| (i as f64).sin()).collect();
            fronts.solve_in_place(&mut x);
            (fronts.values, x)
        };
        let on = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(solve);
        let one = on(1);
        (0..5).for_each(|_| assert!(on(4) == one));
    }

    #[test]
    fn a_matrix_that_is_not_positive_definite_is_told() {
        let lower = bilaplacian(3, 1);
        let mut fronts = Multifrontal::new(&lower, "the test").unwrap();
        let mut values = lower.values().to_vec();
        values[lower.col_offsets()[100]] = -1.0;
        assert!(!fronts.factor(&values));
        values[lower.col_offsets()[100]] = f64::NAN;
        assert!(!fronts.factor(&values));
        // It goes on with the next one.
        assert!(fronts.factor(lower.values()));
    }

    #[test]
    fn a_long_chain_needs_no_deep_recursion() {
        let n = 200_000;
        let mut assembly = Assembly::new(n);
        (0..n as u32 - 1).for_each(|i| assembly.add_outer(&[i, i + 1], &[[1.0], [-1.0]], 1.0));
        (0..n).for_each(|i| assembly.add(i, i, 1.0));
        let lower = assembly.finish();
        let mut fronts = Multifrontal::new(&lower, "the test").unwrap();
        assert!(fronts.factor(lower.values()));
        let mut x = vec![1.0; n];
        fronts.solve_in_place(&mut x);
        // Springs do not pull where all are at the same place.
        assert!(x.iter().all(|x| (x - 1.0).abs() < 1e-12));
    }
}
