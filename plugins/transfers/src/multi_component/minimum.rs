//! The steps that lower the energy of a pose.

use nalgebra::{Matrix3, Point3, Vector3};

use super::{
    gaps::Gap,
    gradient_term::EdgeGoals,
    prior::Prior,
    sideways::Sideways,
    system::{Continued, System},
};

/// Conjugate gradients end once the residual, measured by the energy, has fallen to this part squared.
const FORCING: f64 = 0.1;

/// An energy higher by less than this part is as high but for rounding.
const ROUNDING: f64 = 1e-9;

/// The energy of one pose.
pub struct Problem<'a> {
    pub system: &'a System,
    pub gaps: &'a [Gap],
    pub field: &'a [Matrix3<f64>],
    /// Where the field has the edges of triangles.
    pub edge_goals: Vec<EdgeGoals>,
    pub continued: Continued<'a>,
    /// The vectors of gaps of which more than the length is known.
    pub known: Vec<Option<Vector3<f64>>>,
    /// The prior and its positions b.
    pub prior: Option<(&'a Prior, &'a [Point3<f64>])>,
    /// The part of the right-hand side that does not change.
    pub rhs: Vec<f64>,
}

/// Directions that are held within a step.
pub struct Directions {
    /// The vectors of all gaps.
    pub vectors: Vec<Vector3<f64>>,
    /// Laplacian coordinates of orphan components.
    pub details: Vec<Vector3<f64>>,
    /// Where E5 draws vertices; empty without a prior.
    pub goals: Vec<Point3<f64>>,
}

impl Problem<'_> {
    /// b, the right-hand side for directions held.
    pub fn right_hand_side(&self, held: &Directions) -> Vec<f64> {
        self.system.right_hand_side(&self.rhs, self.gaps, &held.vectors, &held.details, &held.goals)
    }

    /// Whether directions change from step to step.
    pub fn turns(&self) -> bool {
        self.system.has_details()
            || self.known.iter().any(Option::is_none)
            || self.prior.is_some_and(|(prior, _)| prior.has_weight())
    }

    /// Lowers the energy by at most `max_steps` steps with directions held, each followed by `hold`; gives the energy and what
    /// `hold` gave last.
    pub fn settle<T>(
        &self,
        x: &mut Vec<f64>,
        max_steps: usize,
        tolerance: f64,
        hold: impl Fn(&mut Vec<f64>) -> T,
    ) -> (f64, T) {
        let vectors = self.gaps.iter().map(|gap| gap.rest).collect();
        let mut held = Directions { vectors, details: vec![], goals: vec![] };
        let mut last = hold(x);
        for _ in 0..max_steps {
            held = self.directions(x, &held);
            let mut next = solved(self.system, &self.right_hand_side(&held));
            last = hold(&mut next);
            let movement = self.system.longest(&combined(&next, -1.0, x)) / self.system.diagonal();
            *x = next;
            if movement <= tolerance {
                break;
            }
        }
        (self.energy(x), last)
    }

    /// The directions at `x`; gaps that have none keep that of `before`.
    fn directions(&self, x: &[f64], before: &Directions) -> Directions {
        let positions = self.system.positions(x);
        let gaps = self.gaps.iter().zip(&self.known).zip(&before.vectors);
        let vector = |((gap, known), before): ((&Gap, &Option<Vector3<f64>>), &Vector3<f64>)| {
            known.unwrap_or_else(|| gap.with_length(&positions, *before))
        };
        Directions {
            vectors: gaps.map(vector).collect(),
            details: self.system.details(&positions),
            goals: self.prior.map_or_else(Vec::new, |(prior, b)| prior.goals(b, &positions)),
        }
    }

    /// For each gap how much stiffer than the energy sideways of its direction at `x` the matrix is; 0 for known gaps.
    fn sideways_of_gaps(&self, x: &[f64]) -> Vec<Sideways> {
        let positions = self.system.positions(x);
        let of_gap = |(gap, known): (&Gap, &Option<Vector3<f64>>)| match known {
            Some(_) => Sideways::NONE,
            None => {
                let now = positions[gap.ends[0] as usize] - positions[gap.ends[1] as usize];
                Sideways::new(now, gap.rest.norm(), gap.weight)
            }
        };
        self.gaps.iter().zip(&self.known).map(of_gap).collect()
    }

    /// E1 to E5 at `x`.
    pub fn energy(&self, x: &[f64]) -> f64 {
        let positions = self.system.positions(x);
        let of_gap = |(gap, known): (&Gap, &Option<Vector3<f64>>)| {
            let now = positions[gap.ends[0] as usize] - positions[gap.ends[1] as usize];
            gap.weight
                * known.map_or_else(|| (now.norm() - gap.rest.norm()).powi(2), |goal| (now - goal).norm_squared())
        };
        self.system.gradient_term.energy(&positions, &self.edge_goals)
            + self.system.energy(x, &positions, self.field, self.continued)
            + self.gaps.iter().zip(&self.known).map(of_gap).sum::<f64>()
            // Before foot contacts shift the target as a whole, which E5 is not to mind.
            + self.prior.map_or(0.0, |(prior, b)| prior.energy(b, &positions))
    }
}

/// Where the steps ended.
pub struct Minimum {
    pub x: Vec<f64>,
    pub energy: f64,
    pub steps: usize,
    /// Whether the steps came to rest.
    pub converged: bool,
    /// How far the vertex that moves most still has to go by what is known, in diagonals.
    pub movement: f64,
}

/// A point on the way, with A x.
#[derive(Clone)]
struct Place {
    x: Vec<f64>,
    ax: Vec<f64>,
    energy: f64,
}

/// The steps that lower the energy of a pose. They stop wherever A is to be solved with, so that poses can be solved for together.
///
/// A step with directions held minimises a quadratic that lies above the energy and touches it, so the energy falls; but A
/// resists turns that the energy is free in, and a chain of orphans turns slowly. So conjugate gradients go on from that step
/// to the minimum of the Gauss-Newton model, in which gaps and details are stiff along their direction alone, with A, which is
/// factored, as the preconditioner. They end early where the energy itself rises, and never take a point higher than the first
/// step's. The steps have come to rest once neither the step with directions held nor the way to the minimum of the model is
/// longer than `tolerance` diagonals.
pub struct Descent<'a> {
    pub problem: Problem<'a>,
    max_steps: usize,
    tolerance: f64,
    /// The directions of the last step.
    held: Directions,
    steps: usize,
    movement: f64,
    /// The point reached; `None` before the first solve.
    at: Option<Place>,
    /// What the next solve is for.
    next: Next,
}

/// What a solve is for.
enum Next {
    /// The point to start from, for this right-hand side.
    Start(Vec<f64>),
    /// A step with directions held: the right-hand side there, and what is left of it at the point reached.
    Step { right: Vec<f64>, residual: Vec<f64> },
    /// The next direction of conjugate gradients, beside the lowest point so far.
    Direction(Box<(Model, Place)>),
    /// Nothing: the steps have ended, and may have come to rest.
    End { converged: bool },
}

impl<'a> Descent<'a> {
    /// Starts with the directions `first`, for at most `max_steps` solves.
    pub fn new(problem: Problem<'a>, first: Directions, max_steps: usize, tolerance: f64) -> Self {
        let next = Next::Start(problem.right_hand_side(&first));
        Self { problem, max_steps, tolerance, held: first, steps: 0, movement: f64::INFINITY, at: None, next }
    }

    /// The right-hand side whose solution [`advance`](Self::advance) wants; `None` once the steps have ended.
    pub fn asks(&self) -> Option<&[f64]> {
        match &self.next {
            Next::Start(right) => Some(right),
            Next::Step { residual, .. } => Some(residual),
            Next::Direction(under_way) => Some(&under_way.0.residual),
            Next::End { .. } => None,
        }
    }

    /// Goes on with the solution of what it [asks](Self::asks), until it asks for another.
    pub fn advance(&mut self, solution: Vec<f64>) {
        self.steps += 1;
        match std::mem::replace(&mut self.next, Next::End { converged: false }) {
            Next::Start(ax) => {
                self.at = Some(Place { energy: self.problem.energy(&solution), x: solution, ax });
                self.step(!self.problem.turns());
            }
            Next::Step { right, residual } => {
                let at = self.at.as_ref().expect("steps come after the start");
                let x = combined(&at.x, 1.0, &solution);
                let best = Place { energy: self.problem.energy(&x), x, ax: right };
                let model = Model::new(&self.problem, at, residual, solution);
                self.go_along(Box::new((model, best)));
            }
            Next::Direction(mut under_way) => {
                if under_way.0.turn(&solution) {
                    self.end_step(*under_way, true);
                } else {
                    self.go_along(under_way);
                }
            }
            Next::End { .. } => unreachable!("nothing was asked for"),
        }
    }

    /// Where the steps have ended.
    ///
    /// # Panics
    ///
    /// Before the first solve.
    pub fn minimum(&self) -> Minimum {
        let at = self.at.as_ref().expect("the steps have started");
        let converged = matches!(self.next, Next::End { converged: true });
        Minimum { x: at.x.clone(), energy: at.energy, steps: self.steps, converged, movement: self.movement }
    }

    /// Asks for a step with directions held, unless the steps have ended.
    fn step(&mut self, converged: bool) {
        if converged || self.steps >= self.max_steps {
            self.next = Next::End { converged };
            return;
        }
        let at = self.at.as_ref().expect("steps come after the start");
        self.held = self.problem.directions(&at.x, &self.held);
        let right = self.problem.right_hand_side(&self.held);
        let residual = combined(&right, -1.0, &at.ax);
        self.next = Next::Step { right, residual };
    }

    /// Goes along the direction of the model, and asks for the next one unless the step has ended.
    fn go_along(&mut self, mut under_way: Box<(Model, Place)>) {
        let (model, best) = &mut *under_way;
        if !model.advance(&self.problem) {
            return self.end_step(*under_way, true);
        }
        let candidate = model.place(&self.problem, self.at.as_ref().expect("steps come after the start"));
        if candidate.energy > best.energy * (1.0 + ROUNDING) && model.iterations > 1 {
            return self.end_step(*under_way, false);
        }
        if candidate.energy <= best.energy {
            *best = candidate;
        }
        if self.steps == self.max_steps {
            return self.end_step(*under_way, false);
        }
        self.next = Next::Direction(under_way);
    }

    /// Takes the lowest point of a step, and goes on to the next step; `ended` says whether the minimum of the model was reached.
    fn end_step(&mut self, (model, best): (Model, Place), ended: bool) {
        let system = self.problem.system;
        self.movement = system.longest(&model.first_step).max(system.longest(&model.way)) / system.diagonal();
        let at = self.at.as_mut().expect("steps come after the start");
        let is_lower = best.energy <= at.energy * (1.0 + ROUNDING);
        if is_lower {
            *at = best;
        }
        // Only rounding raises the energy of a step.
        self.step(!is_lower || ended && self.movement <= self.tolerance);
    }
}

/// Conjugate gradients on (A − B) w = r, preconditioned by A.
struct Model {
    /// B: by how much A is stiffer than the energy, sideways of gaps and of details.
    gaps: Vec<Sideways>,
    details: Vec<Sideways>,
    /// w and A w.
    way: Vec<f64>,
    a_way: Vec<f64>,
    residual: Vec<f64>,
    direction: Vec<f64>,
    a_direction: Vec<f64>,
    /// r · A⁻¹ r, now and at first.
    square: f64,
    first_square: f64,
    first_step: Vec<f64>,
    iterations: usize,
}

impl Model {
    fn new(problem: &Problem<'_>, at: &Place, residual: Vec<f64>, step: Vec<f64>) -> Self {
        let square = dot(&residual, &step);
        Self {
            gaps: problem.sideways_of_gaps(&at.x),
            details: problem.system.sideways_of_details(&problem.system.positions(&at.x)),
            way: vec![0.0; step.len()],
            a_way: vec![0.0; step.len()],
            direction: step.clone(),
            a_direction: residual.clone(),
            residual,
            square,
            first_square: square,
            first_step: step,
            iterations: 0,
        }
    }

    /// Goes on along the direction; `false` where nothing is left to gain.
    fn advance(&mut self, problem: &Problem<'_>) -> bool {
        let mut product = self.a_direction.clone();
        self.subtract_sideways(problem, &mut product);
        let curvature = dot(&self.direction, &product);
        let along_a = dot(&self.direction, &self.a_direction);
        // Where the model is flat it says nothing.
        if !(self.square > 0.0 && curvature > 1e-12 * along_a) {
            return false;
        }
        let share = self.square / curvature;
        add(&mut self.way, share, &self.direction);
        add(&mut self.a_way, share, &self.a_direction);
        add(&mut self.residual, -share, &product);
        self.iterations += 1;
        true
    }

    /// The next direction, given A⁻¹ r; whether the residual is small enough already.
    fn turn(&mut self, step: &[f64]) -> bool {
        let square = dot(&self.residual, step);
        let share = square / self.square;
        self.square = square;
        self.direction = combined(step, share, &self.direction);
        self.a_direction = combined(&self.residual, share, &self.a_direction);
        square <= FORCING * FORCING * self.first_square
    }

    /// The end of the way from `at`.
    fn place(&self, problem: &Problem<'_>, at: &Place) -> Place {
        let x = combined(&at.x, 1.0, &self.way);
        Place { energy: problem.energy(&x), ax: combined(&at.ax, 1.0, &self.a_way), x }
    }

    /// Subtracts B times the direction.
    fn subtract_sideways(&self, problem: &Problem<'_>, product: &mut [f64]) {
        let n = product.len() / 3;
        let at = |v: u32| Vector3::from_fn(|c, _| self.direction[c * n + v as usize]);
        for (gap, sideways) in problem.gaps.iter().zip(&self.gaps) {
            let force = sideways.of(at(gap.ends[0]) - at(gap.ends[1]));
            for c in 0..3 {
                product[c * n + gap.ends[0] as usize] -= force[c];
                product[c * n + gap.ends[1] as usize] += force[c];
            }
        }
        problem.system.subtract_sideways_of_details(&self.details, &self.direction, product);
    }
}

/// A⁻¹ b.
fn solved(system: &System, b: &[f64]) -> Vec<f64> {
    let mut x = b.to_vec();
    system.solve_in_place(&mut x);
    x
}

/// a + share b.
fn combined(a: &[f64], share: f64, b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(x, y)| x + share * y).collect()
}

fn add(a: &mut [f64], share: f64, b: &[f64]) {
    a.iter_mut().zip(b).for_each(|(x, y)| *x += share * y);
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}
