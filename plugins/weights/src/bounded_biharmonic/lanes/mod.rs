//! The interior point for several handles at once, each in a lane of one factorisation.
//!
//! No lane depends on another: the weights of a handle are the same to the last bit whatever handles are solved for beside it, also
//! those of other choices of handles. A lane that is done takes the next handle.
//!
//! On a body of 2,161 vertices eight lanes take about a third of the time of eight programs by themselves. On 13,348 vertices the
//! factors of eight lanes do not fit into caches, and nothing is won.

mod iterates;
mod unbounded;

use std::sync::Arc;

use mimesh_core::{
    Result,
    linalg::LanePattern,
    memory::{bytes_of, need},
};
use rayon::prelude::*;

use super::{
    level::Rows,
    qp::{MARGIN, MAX_STALLED_STEPS, Minimum},
};
use crate::bilaplacian::Bilaplacian;
use iterates::{Iterates, Measured};
pub use unbounded::LaneChoice;

/// Lanes that are filled as long as there are handles for more than [`FEW`].
const MANY: usize = 8;

/// Lanes for the rest.
const FEW: usize = 4;

/// The energy of a group in the order of its factor.
#[derive(Debug)]
pub struct LaneProgram {
    pattern: Arc<LanePattern>,
    /// The lower triangle of Q.
    entries: Vec<Entry>,
    /// Where the factor has its diagonal.
    diagonal_places: Vec<u32>,
    /// 1 over the diagonal of Q.
    inverse_diagonal: Vec<f64>,
    laplacian: Rows,
    inverse_mass: Vec<f64>,
    /// The row of the factor of each unknown.
    rows: Vec<u32>,
}

/// An entry of Q.
#[derive(Clone, Copy, Debug)]
struct Entry {
    /// Its place in the factor.
    place: u32,
    row: u32,
    column: u32,
    value: f64,
}

/// A handle to solve for.
#[derive(Clone, Copy, Debug)]
pub struct LaneHandle<'a> {
    /// Whether each unknown is one of the handles of its choice.
    pub held: &'a [bool],
    /// The unknown where it is 1.
    pub unknown: usize,
    /// Where to start: the weights without bounds.
    pub start: &'a [f64],
}

/// A handle on its way in a lane.
struct Run {
    /// Its number.
    handle: usize,
    best: Minimum,
    /// Steps since.
    stalled: usize,
    /// Whether nothing was measured yet.
    is_new: bool,
}

/// Vectors of all unknowns that a lane has while it is solved for.
const VECTORS: usize = 20;

impl LaneProgram {
    /// Analyses the pattern of `energy`.
    ///
    /// # Errors
    ///
    /// The errors of [`LanePattern::new`], and [`Error::Memory`](mimesh_core::Error::Memory).
    pub fn new(energy: &Bilaplacian) -> Result<Self> {
        let pattern = LanePattern::new(&energy.matrix, "the energy of biharmonic weights")?;
        let n = pattern.size();
        let of_thread = bytes_of::<[f64; MANY]>(pattern.entry_count() + VECTORS * n);
        need("bounded biharmonic weights", rayon::current_num_threads() as u64 * of_thread)?;
        let rows: Vec<u32> = (0..n as u32).map(|i| pattern.row(i)).collect();
        let (mut diagonal_places, mut inverse_diagonal) = (vec![0; n], vec![0.0; n]);
        let mut inverse_mass = vec![0.0; n];
        let mut entries = Vec::with_capacity(energy.matrix.nnz());
        for (i, j, &value) in energy.matrix.triplet_iter() {
            let place = pattern.entry(i as u32, j as u32).expect("the pattern is that of Q");
            entries.push(Entry { place, row: rows[i], column: rows[j], value });
            if i == j {
                diagonal_places[rows[i] as usize] = place;
                inverse_diagonal[rows[i] as usize] = 1.0 / value;
                inverse_mass[rows[i] as usize] = energy.inverse_mass[i];
            }
        }
        let (pattern, laplacian) = (Arc::new(pattern), Rows::new(&energy.laplacian, &rows));
        Ok(Self { pattern, entries, diagonal_places, inverse_diagonal, laplacian, inverse_mass, rows })
    }

    /// Sets `values`, which are 0, to Q, held unknowns (0 in `free`, else 1) being those of the identity.
    #[inline(always)]
    fn assemble_free<const N: usize>(&self, free: &[[f64; N]], values: &mut [[f64; N]]) {
        for entry in &self.entries {
            let (a, b) = (&free[entry.row as usize], &free[entry.column as usize]);
            let to = &mut values[entry.place as usize];
            for k in 0..N {
                to[k] = entry.value * a[k] * b[k];
            }
        }
        for (free, &place) in free.iter().zip(&self.diagonal_places) {
            let to = &mut values[place as usize];
            for k in 0..N {
                to[k] += 1.0 - free[k];
            }
        }
    }

    /// Minimises for each of `handles`, as [`BoxProgram::minimise`](super::qp::BoxProgram::minimise) does.
    pub fn minimise(&self, handles: &[LaneHandle<'_>], tolerance: f64, max_iterations: usize) -> Vec<Minimum> {
        let share = handles.len().div_ceil(rayon::current_num_threads().max(1)).next_multiple_of(FEW);
        let solve = |share: &[LaneHandle<'_>]| {
            let rest = share.len() % MANY;
            let (many, few) = share.split_at(if rest > FEW { share.len() } else { share.len() - rest });
            let mut found = self.minimise_in::<MANY>(many, tolerance, max_iterations);
            found.extend(self.minimise_in::<FEW>(few, tolerance, max_iterations));
            found
        };
        handles.par_chunks(share.max(1)).flat_map_iter(solve).collect()
    }

    fn minimise_in<const N: usize>(
        &self,
        handles: &[LaneHandle<'_>],
        tolerance: f64,
        max_iterations: usize,
    ) -> Vec<Minimum> {
        let mut found: Vec<Option<Minimum>> = handles.iter().map(|_| None).collect();
        let mut waiting = handles.iter().enumerate();
        let mut at = Iterates::<N>::new(self);
        let mut lanes: [Option<Run>; N] = std::array::from_fn(|_| None);
        loop {
            self.fill(&mut lanes, &mut at, &mut waiting);
            let is_over = |run: &mut Run| run.is_over(tolerance, max_iterations);
            for lane in &mut lanes {
                if let Some(run) = lane.take_if(is_over) {
                    found[run.handle] = Some(run.best);
                }
            }
            if lanes.iter().any(Option::is_none) && waiting.len() > 0 {
                // A handle that is solved as it starts leaves its lane to the next.
                continue;
            }
            if lanes.iter().all(Option::is_none) {
                break;
            }
            let is_definite = at.advance(self);
            let measured = at.measure(self);
            for (lane, run) in lanes.iter_mut().enumerate() {
                let Some(run) = run else { continue };
                if is_definite[lane] {
                    run.stalled += 1;
                    self.keep_better(run, &at, &measured, lane);
                } else {
                    // What cannot be factored any more is as near to the bounds as rounding allows.
                    run.stalled = MAX_STALLED_STEPS;
                }
            }
        }
        found.into_iter().flatten().collect()
    }

    /// Starts handles that wait in lanes that are free.
    fn fill<'a, 'b: 'a, const N: usize>(
        &self,
        lanes: &mut [Option<Run>; N],
        at: &mut Iterates<N>,
        waiting: &mut impl Iterator<Item = (usize, &'a LaneHandle<'b>)>,
    ) {
        let mut is_new = [false; N];
        for (lane, run) in lanes.iter_mut().enumerate().filter(|(_, run)| run.is_none()) {
            if let Some((number, handle)) = waiting.next() {
                self.set_start(at, lane, handle);
                *run = Some(Run::new(number, self.rows.len()));
                is_new[lane] = true;
            }
        }
        if is_new == [false; N] {
            return;
        }
        let measured = at.measure(self);
        for (lane, run) in lanes.iter_mut().enumerate().filter(|(lane, _)| is_new[*lane]) {
            at.set_multipliers(lane, measured.energies[lane]);
            run.iter_mut().for_each(|run| self.keep_better(run, at, &measured, lane));
        }
    }

    /// Sets x of a lane to where a handle starts.
    fn set_start<const N: usize>(&self, at: &mut Iterates<N>, lane: usize, handle: &LaneHandle<'_>) {
        let LaneHandle { held, unknown, start } = *handle;
        at.set_held(lane, held.iter().filter(|held| !**held).count());
        for (i, (&row, (&held, start))) in self.rows.iter().zip(held.iter().zip(start)).enumerate() {
            if held {
                at.x[row as usize][lane] = f64::from(u8::from(i == unknown));
            } else {
                at.x[row as usize][lane] = start.clamp(MARGIN, 1.0 - MARGIN);
                at.free[row as usize][lane] = 1.0;
            }
        }
    }

    /// Keeps what was measured in a lane if its gap is less.
    fn keep_better<const N: usize>(&self, run: &mut Run, at: &Iterates<N>, measured: &Measured<N>, lane: usize) {
        let Measured { energies, gaps, put_energies, put_gaps } = measured;
        let is_put = put_gaps[lane] * energies[lane] <= 2.0 * gaps[lane] * put_energies[lane];
        let (from, energies, gaps) = if is_put { (&at.put, put_energies, put_gaps) } else { (&at.x, energies, gaps) };
        let (energy, gap, best) = (energies[lane], gaps[lane], &mut run.best);
        if run.is_new || gap * best.energy < best.gap * energy {
            (best.energy, best.gap) = (energy, gap);
            best.iterations += run.stalled;
            best.x.iter_mut().zip(&self.rows).for_each(|(x, &row)| *x = from[row as usize][lane]);
            (run.stalled, run.is_new) = (0, false);
        }
    }
}

impl Run {
    fn new(handle: usize, unknowns: usize) -> Self {
        let best = Minimum { x: vec![0.0; unknowns], energy: 0.0, gap: 0.0, iterations: 0 };
        Self { handle, best, stalled: 0, is_new: true }
    }

    /// Whether the best is good enough, or there is no more to come.
    fn is_over(&self, tolerance: f64, max_iterations: usize) -> bool {
        let Self { best, stalled, .. } = self;
        !(best.gap > tolerance * best.energy
            && best.iterations + stalled < max_iterations
            && *stalled < MAX_STALLED_STEPS)
    }
}

#[cfg(test)]
mod tests;
