//! First guesses of supports, on coarser levels by smoothed aggregation [Vaněk et al. 1996] of L and M.
//!
//! Handles are the first seeds of the aggregates, so that each stays one of its own. A guess is solved for on the coarsest
//! level and passed on to finer ones, on each of which a few steps mend it.

use mimesh_core::linalg::Cholesky;
use nalgebra_sparse::{CooMatrix, CscMatrix, CsrMatrix};

use super::{
    active_sets::SupportProgram,
    level::{Level, NONE, Rows},
};
use crate::bilaplacian::Bilaplacian;

/// Levels up to this size are not made coarser.
const COARSEST: usize = 600;

/// With this many handles or more supports are so small that seeds stand next but one, a quarter of the vertices, otherwise
/// next but two, a ninth.
const MANY_HANDLES: usize = 60;

/// The part of the Jacobi step that smooths an aggregate.
const SMOOTHING: f64 = 2.0 / 3.0;

/// To which part guesses are solved.
const TOLERANCE: f64 = 1e-4;

/// Most steps of a guess on a level.
const MAX_STEPS: usize = 15;

/// Least mass of an aggregate, relative to the mean.
const MIN_MASS: f64 = 1e-6;

/// The levels below the finest, from fine to coarse.
#[derive(Debug)]
pub struct Coarse {
    levels: Vec<Coarser>,
}

/// A level and the way from it to the next finer one.
#[derive(Debug)]
struct Coarser {
    level: Level,
    held: Vec<bool>,
    /// Places of the handles.
    handles: Vec<u32>,
    /// Values at places of the finer level by those of this one.
    prolongation: Rows,
}

impl Coarse {
    /// Levels for `handles`, places of `finest`.
    pub fn new(finest: &Level, handles: &[u32]) -> Self {
        let mut levels: Vec<Coarser> = Vec::new();
        loop {
            let (fine, handles) = levels.last().map_or((finest, handles), |last| (&last.level, &last.handles[..]));
            if fine.size() <= COARSEST {
                break;
            }
            match Coarser::new(fine, handles) {
                // Where seeds are no fewer or all held there is nothing to solve for.
                Some(next) if next.level.size() < fine.size() && next.level.size() > handles.len() => levels.push(next),
                _ => break,
            }
        }
        Self { levels }
    }

    /// A start for handle `k` on the finest level, on which `handles` are the places of all.
    pub fn guess(&self, finest: &Level, handles: &[u32], k: usize) -> Vec<f64> {
        let above = |depth: usize| match depth {
            0 => (finest, handles),
            _ => (&self.levels[depth - 1].level, &self.levels[depth - 1].handles[..]),
        };
        // Without a guess all is free, which gives the weights without bounds but for the ring about the handle.
        let (level, places) = above(self.levels.len());
        let mut guess = with_ring(level, places[k], vec![0.5; level.size()]);
        for (depth, coarser) in self.levels.iter().enumerate().rev() {
            let program = SupportProgram { level: &coarser.level, held: &coarser.held };
            let x = program.minimise(coarser.handles[k], guess, TOLERANCE, MAX_STEPS).x;
            let (level, places) = above(depth);
            let prolonged = (0..level.size()).map(|i| coarser.prolongation.dot(i, &x)).collect();
            guess = with_ring(level, places[k], prolonged);
        }
        guess
    }
}

/// `x` with 1 about the handle: weights peak there, and those that are held at 1 are few.
fn with_ring(level: &Level, handle: u32, mut x: Vec<f64>) -> Vec<f64> {
    level.laplacian.columns(handle as usize).iter().for_each(|&i| x[i as usize] = 1.0);
    x
}

impl Coarser {
    /// `None` if its energy cannot be factored.
    fn new(fine: &Level, handles: &[u32]) -> Option<Self> {
        let (of_place, count) = aggregates(fine, handles);
        let prolongation = smoothed(fine, &of_place, count);
        let coarse_laplacian = &prolongation.transpose() * &(&csr(fine) * &prolongation);
        let mut lower = CooMatrix::new(count, count);
        for (i, j, &value) in coarse_laplacian.triplet_iter().filter(|(i, j, _)| i >= j) {
            lower.push(i, j, value);
        }
        let mut mass = vec![0.0; count];
        of_place.iter().zip(&fine.inverse_mass).for_each(|(&a, inverse)| mass[a as usize] += 1.0 / inverse);
        let mean = mass.iter().sum::<f64>() / count as f64;
        mass.iter_mut().for_each(|m| *m = (*m / mean).max(MIN_MASS));
        let energy = Bilaplacian::new(&CscMatrix::from(&lower), &mass);
        let mut is_handle = vec![false; count];
        is_handle[..handles.len()].fill(true);
        let mut matrix = energy.matrix.clone();
        matrix.values_mut().copy_from_slice(&energy.without(&is_handle));
        let order = Cholesky::for_refactoring(matrix, "the energy of aggregates").ok()?.order();
        let level = Level::new(&energy, &order);
        let entries = || prolongation.triplet_iter().map(|(i, a, &value)| (i as u32, level.place[a], value));
        let prolongation = Rows::bucketed(fine.size(), entries);
        let mut held = vec![false; count];
        let handles = level.place[..handles.len()].to_vec();
        handles.iter().for_each(|&h| held[h as usize] = true);
        Some(Self { level, held, handles, prolongation })
    }
}

/// The aggregate of each place and their number. Seeds are the handles, then what is not near a seed, in the order of unknowns,
/// which follows the surface; the rest joins the seed that is the fewest edges away.
fn aggregates(fine: &Level, handles: &[u32]) -> (Vec<u32>, usize) {
    let near = |i: u32| fine.laplacian.columns(i as usize);
    let is_far = handles.len() < MANY_HANDLES;
    let mut is_taken = vec![false; fine.size()];
    let mut seeds: Vec<u32> = Vec::new();
    for &i in handles.iter().chain(&fine.place) {
        if seeds.len() >= handles.len() && is_taken[i as usize] {
            continue;
        }
        seeds.push(i);
        is_taken[i as usize] = true;
        for &j in near(i) {
            is_taken[j as usize] = true;
            if is_far {
                near(j).iter().for_each(|&k| is_taken[k as usize] = true);
            }
        }
    }
    let mut of_place = vec![NONE; fine.size()];
    seeds.iter().zip(0..).for_each(|(&i, a)| of_place[i as usize] = a);
    let count = seeds.len();
    let mut queue = seeds;
    let mut next = 0;
    while let Some(&i) = queue.get(next) {
        next += 1;
        for &j in near(i) {
            if of_place[j as usize] == NONE {
                of_place[j as usize] = of_place[i as usize];
                queue.push(j);
            }
        }
    }
    (of_place, count)
}

/// (I − ω D⁻¹ L) P₀, where P₀ has a column of ones for each aggregate and D is the diagonal of L.
fn smoothed(fine: &Level, of_place: &[u32], count: usize) -> CsrMatrix<f64> {
    let mut entries = CooMatrix::new(fine.size(), count);
    for (i, &own) in of_place.iter().enumerate() {
        entries.push(i, own as usize, 1.0);
        let diagonal = fine.laplacian.row(i).find(|&(j, _)| j == i).map_or(0.0, |(_, value)| value);
        if diagonal > 0.0 {
            for (j, value) in fine.laplacian.row(i) {
                entries.push(i, of_place[j] as usize, -SMOOTHING * value / diagonal);
            }
        }
    }
    CsrMatrix::from(&entries)
}

/// L of a level.
fn csr(level: &Level) -> CsrMatrix<f64> {
    let mut entries = CooMatrix::new(level.size(), level.size());
    for i in 0..level.size() {
        level.laplacian.row(i).for_each(|(j, value)| entries.push(i, j, value));
    }
    CsrMatrix::from(&entries)
}
