//! Each handle by itself: which method, and what becomes of one that fails.

use mimesh_core::stage::{Tally, Work};
use rayon::prelude::*;
use tracing::{Span, debug_span};

use super::{
    Bound, BoundedBiharmonic, Part, Solved, Solver, Task,
    active_sets::{Support, SupportProgram},
    coarse::Coarse,
    lanes::LaneHandle,
    level::Level,
    qp::{BoxProgram, Minimum},
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

/// How the handles of a group are solved for alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Active sets on supports.
    ActiveSets,
    /// The interior point for several handles at once.
    Lanes,
    /// The interior point for each handle.
    Plain,
}

impl Solver {
    /// The method for a group with this energy.
    pub fn method(self, energy: &Bilaplacian) -> Method {
        let is_large = energy.inverse_mass.len() >= MANY_VERTICES;
        let wants_active_sets = match self {
            Self::Automatic => is_large,
            Self::ActiveSets => true,
            Self::InteriorPoint => false,
        };
        match (wants_active_sets && !has_extreme_weights(energy), is_large) {
            (true, _) => Method::ActiveSets,
            (false, true) => Method::Plain,
            (false, false) => Method::Lanes,
        }
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

impl Task<'_> {
    /// The weights without bounds of all its handles.
    pub(super) fn all_unbounded(&self) -> Vec<Vec<f64>> {
        self.program.as_ref().map_or_else(|| self.unbounded.clone(), |program| program.all_unbounded(&self.vertices))
    }
}

impl Bound {
    /// Solves for each handle of each task alone, in parallel.
    pub(super) fn solve_alone(&self, tasks: &[&Task<'_>], work: Work<'_>) -> Vec<Vec<Solved>> {
        let tally = work.tally(tasks.iter().map(|task| task.handles.len()).sum());
        let span = Span::current();
        let mut in_lanes = debug_span!("lanes").in_scope(|| self.in_lanes(tasks));
        tally.add(tasks.iter().filter(|task| task.program.is_none()).map(|task| task.handles.len()).sum());
        let of_task = |task: &&Task<'_>| match (&task.program, &task.supports) {
            (Some(program), Some(supports)) => self.by_active_sets(task, program, supports, &tally, &span),
            (Some(program), None) => {
                let handles = (0..task.handles.len()).into_par_iter();
                let by_interior_point = |k: usize| {
                    let span = debug_span!(parent: &span, "handle");
                    let solved =
                        span.in_scope(|| self.by_interior_point(task, program, k, self.settings.max_iterations));
                    tally.add(1);
                    solved
                };
                handles.map(by_interior_point).collect()
            }
            (None, _) => vec![],
        };
        let mut solved: Vec<Vec<Solved>> = tasks.par_iter().map(of_task).collect();
        for (task, solved) in tasks.iter().zip(&mut solved).filter(|(task, _)| task.program.is_none()) {
            let minima = in_lanes[task.group].by_ref().take(task.handles.len());
            solved.extend(minima.enumerate().map(|(k, minimum)| self.solved(task, k, minimum)));
        }
        solved
    }

    /// For each group the minima of all handles that are solved for in lanes, in the order of tasks.
    fn in_lanes(&self, tasks: &[&Task<'_>]) -> Vec<std::vec::IntoIter<Minimum>> {
        let BoundedBiharmonic { tolerance, max_iterations, .. } = self.settings;
        let mut handles = vec![Vec::new(); self.parts.len()];
        for task in tasks.iter().filter(|task| task.program.is_none()) {
            let each = task.vertices.iter().zip(&task.unbounded);
            handles[task.group].extend(each.map(|(&unknown, start)| LaneHandle { held: &task.held, unknown, start }));
        }
        let of_group = |(part, handles): (&Option<Part>, &Vec<LaneHandle<'_>>)| {
            let lanes = part.as_ref().and_then(|part| part.lanes.as_ref());
            lanes.map_or_else(Vec::new, |lanes| lanes.minimise(handles, tolerance, max_iterations)).into_iter()
        };
        self.parts.par_iter().zip(&handles).map(of_group).collect()
    }

    fn by_interior_point(&self, task: &Task<'_>, program: &BoxProgram<'_>, k: usize, max_iterations: usize) -> Solved {
        let start = program.unbounded(task.vertices[k]);
        self.solved(task, k, program.minimise(&start, self.settings.tolerance, max_iterations))
    }

    fn solved(&self, task: &Task<'_>, k: usize, minimum: Minimum) -> Solved {
        let Minimum { x, energy, gap, iterations } = minimum;
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

    fn by_active_sets(
        &self,
        task: &Task<'_>,
        whole: &BoxProgram<'_>,
        supports: &Supports<'_>,
        tally: &Tally<'_>,
        span: &Span,
    ) -> Vec<Solved> {
        let program = SupportProgram { level: supports.level, held: &supports.held };
        let max_steps = self.settings.max_iterations.min(MAX_STEPS);
        let minimise = |k: usize| {
            let _handle = debug_span!(parent: span, "handle").entered();
            let start = debug_span!("guess").in_scope(|| supports.coarse.guess(supports.level, &supports.handles, k));
            let found = program.minimise(supports.handles[k], start, self.settings.tolerance, max_steps);
            tally.add(1);
            found
        };
        let found: Vec<_> = (0..task.handles.len()).into_par_iter().map(minimise).collect();
        let weights: Vec<_> = found.iter().map(|found| supports.level.of_unknowns(&found.x)).collect();
        let bounds = debug_span!(parent: span, "certificate").in_scope(|| whole.certify(&weights));
        let finish = |k: usize, found: Support, x: Vec<f64>, (energy, gap): (f64, f64)| {
            let relative_gap = gap / f64::max(energy, f64::MIN_POSITIVE);
            let is_solved = found.converged && relative_gap <= SUSPECT_GAP.max(self.settings.tolerance);
            let (group, handle, iterations) = (task.group, task.handles[k], found.steps);
            let solved = Solved { group, handle, x, energy, relative_gap, iterations, is_solved, was_left: false };
            if is_solved || iterations >= self.settings.max_iterations {
                return solved;
            }
            let again = self.by_interior_point(task, whole, k, self.settings.max_iterations - iterations);
            let iterations = iterations + again.iterations;
            let better = if again.is_solved || again.energy < solved.energy { again } else { solved };
            Solved { iterations, was_left: true, ..better }
        };
        let all: Vec<_> = found.into_iter().zip(weights).zip(bounds).enumerate().collect();
        all.into_par_iter().map(|(k, ((found, x), bound))| finish(k, found, x, bound)).collect()
    }
}
