//! Bounded biharmonic weights [Jacobson et al. 2011], eq. 1 of Yang et al. 2018.
//!
//! For each handle the smoothest w with 0 ≤ w ≤ 1, 1 at the handle and 0 at the others: it minimises ½ wᵀ L M⁻¹ L w, L being
//! the cotangent Laplacian and M the lumped Voronoi mass. Rows are divided by their sums afterwards; the paper's constraint
//! that they sum to 1 in the first place couples all handles into one problem and is there as `normalize: exact`.
//!
//! - Handles are vertices: a point within a triangle counts as the corner with the greatest barycentric coordinate.
//! - A triangle lower than a thousandth of its longest edge counts as one of that height, also one without area. Vertices that
//!   hang on triangles that are points are tied by edges of weight ½.
//! - A vertex whose Voronoi area is less than a millionth of the mean counts with that, since M⁻¹ has no value at 0.
//! - Components of the surface are problems of their own and each needs a handle, unless `proximity` bridges them. Vertices
//!   that no triangle with area reaches have the weights of the nearest vertex.
//!
//! Two methods find the same weights: active sets on the support of each handle, and an interior point on the whole surface.
//! Handles on which active sets do not converge, or leave a gap above 1e-2, are left to the interior point, and so are groups with
//! extreme weights of edges, as of very strong bridges.
//!
//! The figure `relative_gap` is the most that the energy of a handle can lie above the least, relative to it, and holds by either
//! method. The interior point brings it below the tolerance. After active sets it overstates: it is mostly 1e-6 to 1e-3 where
//! the energy is less than 1e-6 above that of the interior point.
//!
//! Cost: the pattern is analysed once at binding. A handle takes 13 to 28 factorisations of the whole by the interior point, 4 to
//! 30 of its support by active sets. Below 4,000 vertices the interior point takes eight handles at once, for a third of the price
//! (see `lanes`). Handles run in parallel.

mod active_sets;
mod alone;
mod certificate;
mod coarse;
mod coupled;
mod lanes;
mod level;
mod normalise;
mod qp;

use mimesh_core::{
    Figures, Result,
    linalg::Cholesky,
    mesh::{Surface, SurfacePoint},
    plugin::check_ranges,
    register,
    stage::{BoundWeights, HandlePoints, HandleWeights, ProximityGraph, Weights, Work},
};
use nalgebra::DMatrix;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use tracing::{Span, debug_span};

use crate::{bilaplacian::Bilaplacian, domain::Domain};
use alone::{Method, Supports};
use coupled::Coupled;
use lanes::{LaneChoice, LaneProgram};
use level::Level;
use qp::BoxProgram;

register!(Weights: BoundedBiharmonic);

/// What goes before the handles and what comes after them cost, in all handles.
const PREPARING: f64 = 0.1;
const FINISHING: f64 = 0.05;

/// The smoothest weights between 0 and 1: bounded biharmonic weights (Jacobson et al. 2011; Yang et al. 2018, eq. 1).
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct BoundedBiharmonic {
    /// How the weights of a vertex are made to sum to 1.
    pub normalize: Normalize,
    /// The method by which each handle is solved for.
    pub solver: Solver,
    /// The part of a handle's energy by which it may lie above the least possible. The interior point proves it. Active sets stop
    /// when a step gains less than 3 % of it; the bound that is reported then overstates.
    #[schemars(range(min = 1e-12, max = 0.1))]
    pub tolerance: f64,
    /// Most factorisations a handle takes, by both methods together; active sets take at most 40. Where they do not suffice, a
    /// warning says how close it came.
    #[schemars(range(min = 1))]
    pub max_iterations: usize,
    /// Strength of the bridges that `proximity` makes between components, relative to the edges of the surface (to the median
    /// cotangent weight); 0 for none. Weak bridges let components move apart, strong ones glue them at single vertices.
    #[schemars(range(min = 0.0))]
    pub bridge: f64,
}

/// How the weights of a vertex are made to sum to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Normalize {
    /// Each handle is solved for alone, then rows are divided by their sums.
    #[default]
    Rows,
    /// All handles are solved for together under that constraint, as the paper prints it. Takes about 30 times as long; on a body
    /// with 12 handles weights differ by up to 0.06, and the sum of energies is 8 % below that of divided rows.
    Exact,
    /// They are not: rows sum to about 1, as other programs give these weights. Deformers want them to sum to 1.
    None,
}

/// How each handle is solved for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Solver {
    /// Active sets for 4,000 vertices and more, the interior point below, where it is as fast.
    #[default]
    Automatic,
    /// Active sets on the support of each handle: five times as fast and more on large surfaces.
    ActiveSets,
    /// An interior point method on the whole surface, which proves how near the minimum is. `normalize: exact` always takes it.
    InteriorPoint,
}

impl Default for BoundedBiharmonic {
    fn default() -> Self {
        Self {
            normalize: Normalize::Rows,
            solver: Solver::Automatic,
            tolerance: 1e-6,
            max_iterations: 100,
            bridge: 0.5,
        }
    }
}

#[typetag::serde(name = "bounded_biharmonic")]
impl Weights for BoundedBiharmonic {
    fn bind(
        &self,
        surface: &Surface,
        points: &[SurfacePoint],
        proximity: Option<&ProximityGraph>,
    ) -> Result<Box<dyn BoundWeights>> {
        check_ranges(self)?;
        let points = HandlePoints::new(surface, points)?;
        let domain = Domain::new(surface, proximity, self.bridge)?;
        let mut first = vec![None; domain.groups.len()];
        for (group, local) in points.all().iter().filter_map(|&v| domain.place[v as usize]) {
            first[group as usize].get_or_insert(local as usize);
        }
        let part = |(group, first): (usize, &Option<usize>)| {
            let group = &domain.groups[group];
            let part = |first| {
                let energy = Bilaplacian::new(&group.laplacian, &group.mass);
                let method =
                    if self.normalize == Normalize::Exact { Method::Plain } else { self.solver.method(&energy) };
                Part::new(energy, first, method)
            };
            first.map(part).transpose()
        };
        let parts = first.par_iter().enumerate().map(part).collect::<Result<_>>()?;
        Ok(Box::new(Bound { settings: self.clone(), domain, points, parts }))
    }
}

/// Weights bound to a surface.
#[derive(Debug)]
struct Bound {
    settings: BoundedBiharmonic,
    domain: Domain,
    points: HandlePoints,
    /// The factorisations, one for each group with a point.
    parts: Vec<Option<Part>>,
}

/// The energy of a group and the pattern that its factorisations share.
#[derive(Debug)]
struct Part {
    energy: Bilaplacian,
    pattern: Cholesky,
    /// The energy in the order of its factorisations, for active sets.
    level: Option<Level>,
    /// The energy for the interior point in lanes.
    lanes: Option<LaneProgram>,
}

impl Part {
    /// Analyses the pattern; `first` is a vertex that is held, since the energy of a constant is 0.
    fn new(energy: Bilaplacian, first: usize, method: Method) -> Result<Self> {
        let mut held = vec![false; energy.matrix.ncols()];
        held[first] = true;
        let mut matrix = energy.matrix.clone();
        matrix.values_mut().copy_from_slice(&energy.without(&held));
        let pattern = Cholesky::for_refactoring(matrix, "the energy of biharmonic weights")?;
        let level = (method == Method::ActiveSets).then(|| Level::new(&energy, &pattern.order()));
        let lanes = (method == Method::Lanes).then(|| LaneProgram::new(&energy)).transpose()?;
        Ok(Self { energy, pattern, level, lanes })
    }
}

/// What is solved for a choice of handles.
struct Choice<'a> {
    /// The handles of each group.
    by_group: Vec<Vec<usize>>,
    tasks: Vec<Task<'a>>,
    /// W; 0 where it has to be solved for.
    matrix: DMatrix<f64>,
}

/// The handles of a group and what is solved for them.
struct Task<'a> {
    group: usize,
    /// Numbers of the handles.
    handles: Vec<usize>,
    /// Their vertices, as the group counts.
    vertices: Vec<usize>,
    /// Whether each vertex of the group is one of them.
    held: Vec<bool>,
    /// There unless the interior point goes in lanes.
    program: Option<BoxProgram<'a>>,
    /// There for active sets.
    supports: Option<Supports<'a>>,
    /// The weights without bounds of each handle, there for the interior point in lanes.
    unbounded: Vec<Vec<f64>>,
}

/// The solution for a handle.
struct Solved {
    group: usize,
    handle: usize,
    /// The weights over the vertices of the group.
    x: Vec<f64>,
    energy: f64,
    /// The most that the energy can lie above the least possible, over it.
    relative_gap: f64,
    iterations: usize,
    /// Whether the method says that the tolerance is met.
    is_solved: bool,
    /// Whether active sets left it to the interior point.
    was_left: bool,
}

impl BoundWeights for Bound {
    fn solve(&self, handles: &[usize]) -> Result<HandleWeights> {
        self.solve_watched(handles, Work::UNWATCHED)
    }

    fn solve_watched(&self, handles: &[usize], work: Work<'_>) -> Result<HandleWeights> {
        self.solve_together(&[handles], work).pop().expect("weights for each choice")
    }

    fn solve_all(&self, choices: &[&[usize]]) -> Vec<Result<HandleWeights>> {
        // Handles of several choices fill lanes. Factors of large groups, one a choice, would only fill memory.
        let fill_lanes = self.parts.iter().flatten().all(|part| part.lanes.is_some());
        let together = if fill_lanes { choices.len().max(1) } else { 1 };
        choices.par_chunks(together).flat_map_iter(|some| self.solve_together(some, Work::UNWATCHED)).collect()
    }

    fn figures(&self) -> Figures {
        self.domain.figures()
    }
}

impl Bound {
    /// Solves for several choices of handles.
    fn solve_together(&self, choices: &[&[usize]], work: Work<'_>) -> Vec<Result<HandleWeights>> {
        let span = Span::current();
        let choice = |handles: &&[usize]| debug_span!(parent: &span, "supports").in_scope(|| self.choice(handles));
        let mut choices: Vec<Result<Choice<'_>>> = choices.par_iter().map(choice).collect();
        debug_span!("unbounded").in_scope(|| self.set_unbounded(&mut choices));
        let [preparing, solving, finishing] = work.parts([PREPARING, 1.0, FINISHING]);
        preparing.done(1.0);
        let sound = || choices.iter().flatten();
        let mut solved = match self.settings.normalize {
            Normalize::Exact => sound().map(|choice| self.solve_coupled(&choice.tasks, solving)).collect(),
            Normalize::Rows | Normalize::None => {
                let tasks: Vec<&Task<'_>> = sound().flat_map(|choice| &choice.tasks).collect();
                let mut each = self.solve_alone(&tasks, solving).into_iter();
                sound().map(|choice| each.by_ref().take(choice.tasks.len()).flatten().collect()).collect::<Vec<_>>()
            }
        }
        .into_iter();
        finishing.done(0.0);
        let weights = |choice: Result<Choice<'_>>| self.weights(choice?, &solved.next().unwrap_or_default());
        choices.into_iter().map(weights).collect()
    }

    /// Prepares for a choice of handles.
    fn choice(&self, handles: &[usize]) -> Result<Choice<'_>> {
        let vertices = self.points.choose(handles)?;
        let by_group = self.domain.by_group(&vertices)?;
        let mut matrix = DMatrix::zeros(self.domain.place.len(), handles.len());
        let tasks = self.tasks(&vertices, &by_group, &mut matrix)?;
        Ok(Choice { by_group, tasks, matrix })
    }

    /// Sets the weights without bounds of handles in lanes. A choice that has none becomes the error that says so.
    fn set_unbounded(&self, choices: &mut [Result<Choice<'_>>]) {
        for (group, part) in self.parts.iter().enumerate() {
            let Some(lanes) = part.as_ref().and_then(|part| part.lanes.as_ref()) else { continue };
            let of_choice = |choice: &Choice<'_>| choice.tasks.iter().position(|task| task.group == group);
            let with: Vec<(usize, usize)> = choices
                .iter()
                .enumerate()
                .filter_map(|(number, choice)| Some((number, of_choice(choice.as_ref().ok()?)?)))
                .collect();
            let lane_choice = |&(number, k): &(usize, usize)| {
                let task = &choices[number].as_ref().ok()?.tasks[k];
                Some(LaneChoice { held: &task.held, unknowns: &task.vertices })
            };
            let found = lanes.unbounded(&with.iter().filter_map(lane_choice).collect::<Vec<_>>());
            for ((number, k), found) in with.into_iter().zip(found) {
                match (found, &mut choices[number]) {
                    (Ok(found), Ok(choice)) => choice.tasks[k].unbounded = found,
                    (Err(error), choice) => *choice = Err(error),
                    (Ok(_), Err(_)) => {}
                }
            }
        }
    }

    /// The weights of a choice of handles and the report on them.
    fn weights(&self, choice: Choice<'_>, solved: &[Solved]) -> Result<HandleWeights> {
        let Choice { by_group, tasks, mut matrix } = choice;
        let mut figures = Figures::default();
        let mut energies = vec![0.0; matrix.ncols()];
        for found in solved {
            let group = &self.domain.groups[found.group];
            energies[found.handle] = found.energy / group.mean_mass;
            group.vertices.iter().zip(&found.x).for_each(|(&v, &w)| matrix[(v as usize, found.handle)] = w);
        }
        let gap = solved.iter().map(|found| found.relative_gap).fold(0.0, f64::max);
        figures.set("energies", energies);
        figures.set("relative_gap", gap);
        figures.set("factorisations", solved.iter().map(|found| found.iterations).sum::<usize>());
        figures.set("most_factorisations_of_a_handle", solved.iter().map(|found| found.iterations).max().unwrap_or(0));
        let left = solved.iter().filter(|found| found.was_left).count();
        figures.set("handles_left_to_the_interior_point", left);
        let unsolved = solved.iter().filter(|found| !found.is_solved).map(|found| found.relative_gap);
        if let Some(gap) = unsolved.reduce(f64::max) {
            figures.warn(format!(
                "weights were not solved to their tolerance: the energy of a handle may be {gap:.1e} above the least, tolerance \
                 {:.1e}; look for triangles almost without area, or allow more with `tolerance`",
                self.settings.tolerance
            ));
        }
        self.normalise(&tasks, solved, &mut matrix, &mut figures);
        for [v, by] in self.domain.unreached(&by_group)? {
            let row = matrix.row(by as usize).into_owned();
            matrix.set_row(v as usize, &row);
        }
        Ok(HandleWeights { matrix, figures })
    }

    /// The groups with several handles; the only handle of a group is its weight everywhere, which is set at once.
    fn tasks<'a>(
        &'a self,
        vertices: &[u32],
        by_group: &[Vec<usize>],
        matrix: &mut DMatrix<f64>,
    ) -> Result<Vec<Task<'a>>> {
        let mut several = Vec::new();
        for (group, handles) in by_group.iter().enumerate() {
            match handles[..] {
                [] => {}
                [only] => self.domain.groups[group].vertices.iter().for_each(|&v| matrix[(v as usize, only)] = 1.0),
                _ => several.push((group, handles.clone())),
            }
        }
        let task = |(group, handles): (usize, Vec<usize>)| {
            let part = self.parts[group].as_ref().expect("a group with handles has points");
            let local = |&h: &usize| self.domain.place[vertices[h] as usize].map_or(0, |(_, local)| local as usize);
            let vertices: Vec<usize> = handles.iter().map(local).collect();
            let mut held = vec![false; part.energy.matrix.ncols()];
            vertices.iter().for_each(|&v| held[v] = true);
            let is_in_lanes = part.lanes.is_some();
            let program = (!is_in_lanes).then(|| BoxProgram::new(&part.energy, &held, &part.pattern)).transpose()?;
            let supports = part.level.as_ref().map(|level| Supports::new(level, &vertices));
            Ok(Task { group, handles, vertices, held, program, supports, unbounded: vec![] })
        };
        several.into_par_iter().map(task).collect()
    }

    /// Solves for all handles of a group together, whose weights then sum to 1.
    fn solve_coupled(&self, tasks: &[Task<'_>], work: Work<'_>) -> Vec<Solved> {
        let solve = |(number, task): (usize, &Task<'_>)| {
            let work = work.part(number as f64 / tasks.len() as f64, (number + 1) as f64 / tasks.len() as f64);
            let Some(program) = &task.program else { return vec![] };
            let starts = program.all_unbounded(&task.vertices);
            let Coupled { x, energies, relative_gap, iterations } =
                program.minimise_coupled(&starts, self.settings.tolerance, self.settings.max_iterations, work);
            let is_solved = relative_gap <= self.settings.tolerance;
            let each = x.into_iter().zip(energies).zip(&task.handles);
            let solved = |((x, energy), &handle)| Solved {
                group: task.group,
                handle,
                x,
                energy,
                relative_gap,
                iterations,
                is_solved,
                was_left: false,
            };
            each.map(solved).collect::<Vec<_>>()
        };
        tasks.iter().enumerate().flat_map(solve).collect()
    }
}
