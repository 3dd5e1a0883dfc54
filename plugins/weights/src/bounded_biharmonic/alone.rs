//! Each handle by itself: which method, and what becomes of one that fails.

use rayon::prelude::*;

use super::{
    Bound, Solved, Solver, Task,
    active_sets::{Support, SupportProgram},
    coarse::Coarse,
    level::Level,
    qp::Minimum,
};
use crate::bilaplacian::Bilaplacian;

/// From this many vertices of a group on active sets are faster, whatever the number of handles.
const MANY_VERTICES: usize = 4000;

/// Most steps of active sets: those that converge have taken 4 to 30.
const MAX_STEPS: usize = 40;

/// A bound above this, relative to the energy, is more than overstating explains.
const SUSPECT_GAP: f64 = 1e-2;

/// A diagonal entry of L this many times the median leaves active sets too few digits: bridges of 10,000 times the weight of
/// edges ended 1e-4 above the least energy. Triangles of the least height that counts stay below.
const EXTREME_WEIGHT: f64 = 1000.0;

impl Solver {
    /// Whether a group with this energy is solved by active sets.
    pub fn uses_active_sets(self, energy: &Bilaplacian) -> bool {
        let is_wanted = match self {
            Self::Automatic => energy.inverse_mass.len() >= MANY_VERTICES,
            Self::ActiveSets => true,
            Self::InteriorPoint => false,
        };
        is_wanted && !has_extreme_weights(energy)
    }
}

fn has_extreme_weights(energy: &Bilaplacian) -> bool {
    let entries = energy.laplacian.triplet_iter();
    let mut diagonal: Vec<f64> = entries.filter(|(i, j, _)| i == j).map(|(_, _, &value)| value).collect();
    diagonal.sort_unstable_by(f64::total_cmp);
    let median = diagonal.get(diagonal.len() / 2).copied().unwrap_or(0.0);
    diagonal.last().is_some_and(|&most| most > EXTREME_WEIGHT * median)
}

/// What active sets need of a group and its handles.
pub struct Supports<'a> {
    level: &'a Level,
    held: Vec<bool>,
    /// Places of the handles.
    handles: Vec<u32>,
    coarse: Coarse,
}

impl<'a> Supports<'a> {
    /// Prepares for handles at `vertices`, as the group counts.
    pub fn new(level: &'a Level, vertices: &[usize]) -> Self {
        let handles: Vec<u32> = vertices.iter().map(|&v| level.place[v]).collect();
        let mut held = vec![false; level.size()];
        handles.iter().for_each(|&h| held[h as usize] = true);
        Self { coarse: Coarse::new(level, &handles), level, held, handles }
    }
}

impl Bound {
    /// Solves for each handle alone, in parallel.
    pub(super) fn solve_alone(&self, tasks: &[Task<'_>]) -> Vec<Solved> {
        let of_task = |task: &Task<'_>| match &task.supports {
            Some(supports) => self.by_active_sets(task, supports),
            None => {
                let handles = (0..task.handles.len()).into_par_iter();
                handles.map(|k| self.by_interior_point(task, k, self.settings.max_iterations)).collect()
            }
        };
        let solved: Vec<Vec<Solved>> = tasks.par_iter().map(of_task).collect();
        solved.into_iter().flatten().collect()
    }

    fn by_interior_point(&self, task: &Task<'_>, k: usize, max_iterations: usize) -> Solved {
        let Minimum { x, energy, gap, iterations } =
            task.program.minimise(&self.unbounded(task, k), self.settings.tolerance, max_iterations);
        let relative_gap = gap / energy.max(f64::MIN_POSITIVE);
        let is_solved = relative_gap <= self.settings.tolerance;
        Solved {
            group: task.group,
            handle: task.handles[k],
            x,
            energy,
            relative_gap,
            iterations,
            is_solved,
            was_left: false,
        }
    }

    fn by_active_sets(&self, task: &Task<'_>, supports: &Supports<'_>) -> Vec<Solved> {
        let program = SupportProgram { level: supports.level, held: &supports.held };
        let max_steps = self.settings.max_iterations.min(MAX_STEPS);
        let minimise = |k: usize| {
            let start = supports.coarse.guess(supports.level, &supports.handles, k);
            program.minimise(supports.handles[k], start, self.settings.tolerance, max_steps)
        };
        let found: Vec<_> = (0..task.handles.len()).into_par_iter().map(minimise).collect();
        let weights: Vec<_> = found.iter().map(|found| supports.level.of_unknowns(&found.x)).collect();
        let bounds = task.program.certify(&weights);
        let finish = |k: usize, found: Support, x: Vec<f64>, (energy, gap): (f64, f64)| {
            let relative_gap = gap / f64::max(energy, f64::MIN_POSITIVE);
            let is_solved = found.converged && relative_gap <= SUSPECT_GAP.max(self.settings.tolerance);
            let (group, handle, iterations) = (task.group, task.handles[k], found.steps);
            let solved = Solved { group, handle, x, energy, relative_gap, iterations, is_solved, was_left: false };
            if is_solved || iterations >= self.settings.max_iterations {
                return solved;
            }
            let again = self.by_interior_point(task, k, self.settings.max_iterations - iterations);
            let iterations = iterations + again.iterations;
            let better = if again.is_solved || again.energy < solved.energy { again } else { solved };
            Solved { iterations, was_left: true, ..better }
        };
        let all: Vec<_> = found.into_iter().zip(weights).zip(bounds).enumerate().collect();
        all.into_par_iter().map(|(k, ((found, x), bound))| finish(k, found, x, bound)).collect()
    }
}
