//! Iterates of the interior point side by side, and the steps they take.
//!
//! The method is that of [`BoxProgram::minimise`](super::super::qp::BoxProgram::minimise), with multipliers of a direction made
//! anew from its step wherever they are needed.

use mimesh_core::linalg::LaneCholesky;
use pulp::{Arch, NullaryFnOnce};

use super::LaneProgram;
use crate::bounded_biharmonic::{
    level::Rows,
    qp::{MAX_STEP_TO_BOUND, STEP_INCREASE},
};

/// `N` iterates of the method, one in each lane, by rows of the factor.
///
/// At held unknowns the multipliers, the inverse distances and the gradient are 0, so that no step moves them.
pub(super) struct Iterates<const N: usize> {
    /// 1 at free unknowns, 0 at held ones.
    pub free: Vec<[f64; N]>,
    /// How many unknowns are free, at least 1.
    pub free_count: [f64; N],
    pub x: Vec<[f64; N]>,
    /// The multipliers of x ≥ 0 and of x ≤ 1.
    pub multipliers: [Vec<[f64; N]>; 2],
    /// x with entries put at bounds; see [`Measured`].
    pub put: Vec<[f64; N]>,
    gradient: Vec<[f64; N]>,
    put_gradient: Vec<[f64; N]>,
    /// M⁻¹ L x.
    scaled: Vec<[f64; N]>,
    /// 1 / x and 1 / (1 − x).
    inverse: [Vec<[f64; N]>; 2],
    /// The products x z that a direction aims at.
    goal: [Vec<[f64; N]>; 2],
    corrected: [Vec<[f64; N]>; 2],
    /// x of a direction.
    direction: Vec<[[f64; N]; 1]>,
    corrector: Vec<[[f64; N]; 1]>,
    cholesky: LaneCholesky<N>,
}

/// Energies ½ xᵀ Q x and gaps, of x and of x with those entries put at a bound whose own Newton step would pass it.
#[derive(Clone, Copy)]
pub(super) struct Measured<const N: usize> {
    pub energies: [f64; N],
    pub gaps: [f64; N],
    pub put_energies: [f64; N],
    pub put_gaps: [f64; N],
}

impl<const N: usize> Iterates<N> {
    /// Lanes that hold all unknowns at 0.
    pub fn new(program: &LaneProgram) -> Self {
        let n = program.pattern.size();
        let zeros = || vec![[0.0; N]; n];
        let pair = || [zeros(), zeros()];
        Self {
            free: zeros(),
            free_count: [1.0; N],
            x: zeros(),
            multipliers: pair(),
            put: zeros(),
            gradient: zeros(),
            put_gradient: zeros(),
            scaled: zeros(),
            inverse: pair(),
            goal: pair(),
            corrected: pair(),
            direction: vec![[[0.0; N]; 1]; n],
            corrector: vec![[[0.0; N]; 1]; n],
            cholesky: LaneCholesky::new(program.pattern.clone()),
        }
    }

    /// Holds all unknowns of a lane, of which `free_count` will be free.
    pub fn set_held(&mut self, lane: usize, free_count: usize) {
        self.free_count[lane] = free_count.max(1) as f64;
        let [lower, upper] = &mut self.multipliers;
        for rows in [&mut self.free, lower, upper] {
            rows.iter_mut().for_each(|row| row[lane] = 0.0);
        }
    }

    /// Sets the multipliers of a lane so that all products with the distances to bounds are the mean of `energy`.
    pub fn set_multipliers(&mut self, lane: usize, energy: f64) {
        let mean = energy / self.free_count[lane];
        for i in (0..self.x.len()).filter(|&i| self.free[i][lane] != 0.0) {
            self.multipliers[0][i][lane] = mean / self.x[i][lane];
            self.multipliers[1][i][lane] = mean / (1.0 - self.x[i][lane]);
        }
    }

    /// Measures x.
    pub fn measure(&mut self, program: &LaneProgram) -> Measured<N> {
        Arch::new().dispatch(Measure(program, self))
    }

    /// Takes a step, and says in which lanes the matrix could be factored; what is in the others is of no use.
    pub fn advance(&mut self, program: &LaneProgram) -> [bool; N] {
        Arch::new().dispatch(Advance(program, self))
    }
}

struct Measure<'a, const N: usize>(&'a LaneProgram, &'a mut Iterates<N>);

// Inlined, with all that it calls, into the function that the processor's instructions are chosen for.
impl<const N: usize> NullaryFnOnce for Measure<'_, N> {
    type Output = Measured<N>;

    #[inline(always)]
    fn call(self) -> Measured<N> {
        let Self(program, Iterates { free, x, put, gradient, put_gradient, scaled, .. }) = self;
        let energies = energy_and_gradient(program, free, x, scaled, gradient);
        for (((put, x), g), inverse) in put.iter_mut().zip(&*x).zip(&*gradient).zip(&program.inverse_diagonal) {
            for k in 0..N {
                let next = x[k] - g[k] * inverse;
                let upper = if next >= 1.0 { 1.0 } else { x[k] };
                put[k] = if next <= 0.0 { 0.0 } else { upper };
            }
        }
        let put_energies = energy_and_gradient(program, free, put, scaled, put_gradient);
        Measured { energies, gaps: gaps(x, gradient), put_energies, put_gaps: gaps(put, put_gradient) }
    }
}

/// ½ xᵀ Q x, and Q x where unknowns are free.
#[inline(always)]
pub(super) fn energy_and_gradient<const N: usize>(
    program: &LaneProgram,
    free: &[[f64; N]],
    x: &[[f64; N]],
    scaled: &mut [[f64; N]],
    gradient: &mut [[f64; N]],
) -> [f64; N] {
    let mut energies = [0.0; N];
    for (i, (scaled, inverse)) in scaled.iter_mut().zip(&program.inverse_mass).enumerate() {
        let product = times(&program.laplacian, i, x);
        for k in 0..N {
            scaled[k] = product[k] * inverse;
            energies[k] += 0.5 * product[k] * scaled[k];
        }
    }
    for (i, (gradient, free)) in gradient.iter_mut().zip(free).enumerate() {
        let product = times(&program.laplacian, i, scaled);
        for k in 0..N {
            gradient[k] = product[k] * free[k];
        }
    }
    energies
}

/// Row `i` of a matrix times x.
#[inline(always)]
fn times<const N: usize>(matrix: &Rows, i: usize, x: &[[f64; N]]) -> [f64; N] {
    let mut sums = [0.0; N];
    for (j, value) in matrix.row(i) {
        let x = &x[j];
        for k in 0..N {
            sums[k] += value * x[k];
        }
    }
    sums
}

/// What the linear model of the energy loses to the best points of the box.
#[inline(always)]
fn gaps<const N: usize>(x: &[[f64; N]], gradient: &[[f64; N]]) -> [f64; N] {
    let mut sums = [0.0; N];
    for (x, g) in x.iter().zip(gradient) {
        for k in 0..N {
            sums[k] += larger(g[k] * x[k], g[k] * (x[k] - 1.0));
        }
    }
    sums
}

struct Advance<'a, const N: usize>(&'a LaneProgram, &'a mut Iterates<N>);

impl<const N: usize> NullaryFnOnce for Advance<'_, N> {
    type Output = [bool; N];

    #[inline(always)]
    fn call(self) -> [bool; N] {
        let Self(program, at) = self;
        assemble(program, at);
        let is_definite = at.cholesky.factor();
        let centre = aim(at);
        at.cholesky.solve_in_place(&mut at.direction);
        let step = steps(at, &at.goal, &at.direction);
        correct(at, &centre, &step);
        at.cholesky.solve_in_place(&mut at.corrector);
        let corrected = steps(at, &at.corrected, &at.corrector);
        go(at, &step, &corrected);
        is_definite
    }
}

/// Sets the matrices Q + diag(z / x + z′ / (1 − x)), held unknowns being those of the identity.
#[inline(always)]
fn assemble<const N: usize>(program: &LaneProgram, at: &mut Iterates<N>) {
    let Iterates { free, x, multipliers, inverse, cholesky, .. } = at;
    let values = cholesky.clear();
    program.assemble_free(free, values);
    for (i, &place) in program.diagonal_places.iter().enumerate() {
        let (to, free, x) = (&mut values[place as usize], &free[i], &x[i]);
        for k in 0..N {
            let (below, above) = (1.0 / x[k], 1.0 / (1.0 - x[k]));
            inverse[0][i][k] = if free[k] == 0.0 { 0.0 } else { below };
            inverse[1][i][k] = if free[k] == 0.0 { 0.0 } else { above };
            let barrier = multipliers[0][i][k] * inverse[0][i][k] + multipliers[1][i][k] * inverse[1][i][k];
            to[k] += barrier;
        }
    }
}

/// Sets the goal by the predictor, and the right-hand side of the direction towards it; returns the product at the centre.
#[inline(always)]
fn aim<const N: usize>(at: &mut Iterates<N>) -> [f64; N] {
    for (to, g) in at.direction.iter_mut().zip(&at.gradient) {
        for k in 0..N {
            to[0][k] = -g[k];
        }
    }
    at.cholesky.solve_in_place(&mut at.direction);
    let Iterates { x, multipliers, inverse, gradient, goal, direction, .. } = at;
    let [lower, upper] = multipliers;
    let mut most = [0.0; N];
    // The sum of products after a step s along the direction is a polynomial in s.
    let mut sums = [[0.0; N]; 3];
    for i in 0..x.len() {
        for k in 0..N {
            let (x, l, u, dx) = (x[i][k], lower[i][k], upper[i][k], direction[i][0][k]);
            let (to_lower, to_upper) = (dx * inverse[0][i][k], dx * inverse[1][i][k]);
            let (dl, du) = (-l * to_lower - l, u * to_upper - u);
            // Multipliers shrink by −dl / l and −du / u.
            most[k] = larger(larger(-to_lower, to_upper), larger(larger(to_lower + 1.0, 1.0 - to_upper), most[k]));
            sums[0][k] += x * l + (1.0 - x) * u;
            sums[1][k] += x * dl + dx * l + (1.0 - x) * du - dx * u;
            sums[2][k] += dx * dl - dx * du;
            goal[0][i][k] = -dx * dl;
            goal[1][i][k] = dx * du;
        }
    }
    let mut centre = [0.0; N];
    for k in 0..N {
        let step = smaller(1.0 / most[k], 1.0);
        let mean = sums[0][k] / (2.0 * at.free_count[k]);
        let after = (sums[0][k] + step * (sums[1][k] + step * sums[2][k])) / (2.0 * at.free_count[k]);
        let part = after / mean;
        centre[k] = mean * part * part * part;
    }
    for i in 0..x.len() {
        for k in 0..N {
            goal[0][i][k] += centre[k];
            goal[1][i][k] += centre[k];
            direction[i][0][k] = goal[0][i][k] * inverse[0][i][k] - goal[1][i][k] * inverse[1][i][k] - gradient[i][k];
        }
    }
    centre
}

/// How far along a direction to go.
#[inline(always)]
fn steps<const N: usize>(at: &Iterates<N>, goal: &[Vec<[f64; N]>; 2], direction: &[[[f64; N]; 1]]) -> [f64; N] {
    let mut most = [0.0; N];
    for (i, dx) in direction.iter().enumerate() {
        for k in 0..N {
            let (l, u, dx) = (at.multipliers[0][i][k], at.multipliers[1][i][k], dx[0][k]);
            let (below, above) = (at.inverse[0][i][k], at.inverse[1][i][k]);
            let (dl, du) = multipliers([l, u], [goal[0][i][k], goal[1][i][k]], [below, above], dx);
            most[k] = larger(larger(-dl / l, -du / u), larger(larger(-dx * below, dx * above), most[k]));
        }
    }
    let mut steps = [0.0; N];
    for k in 0..N {
        steps[k] = smaller(MAX_STEP_TO_BOUND / most[k], 1.0);
    }
    steps
}

/// Sets the right-hand side of the corrector: products that would stray from the centre after a longer step are aimed at its
/// neighbourhood.
#[inline(always)]
fn correct<const N: usize>(at: &mut Iterates<N>, centre: &[f64; N], step: &[f64; N]) {
    let Iterates { x, multipliers: [lower, upper], inverse, gradient, goal, corrected, direction, corrector, .. } = at;
    for i in 0..x.len() {
        for k in 0..N {
            let further = smaller(step[k] + STEP_INCREASE, 1.0);
            let (x, l, u, dx) = (x[i][k], lower[i][k], upper[i][k], direction[i][0][k]);
            let (below, above) = (inverse[0][i][k], inverse[1][i][k]);
            let (dl, du) = multipliers([l, u], [goal[0][i][k], goal[1][i][k]], [below, above], dx);
            corrected[0][i][k] = goal[0][i][k] + nearer((x + further * dx) * (l + further * dl), centre[k]);
            corrected[1][i][k] = goal[1][i][k] + nearer((1.0 - x - further * dx) * (u + further * du), centre[k]);
            corrector[i][0][k] = corrected[0][i][k] * below - corrected[1][i][k] * above - gradient[i][k];
        }
    }
}

/// Goes along the corrected direction where that is worth it, else along the other.
#[inline(always)]
fn go<const N: usize>(at: &mut Iterates<N>, step: &[f64; N], corrected_step: &[f64; N]) {
    let Iterates { x, multipliers: [lower, upper], inverse, goal, corrected, direction, corrector, .. } = at;
    for i in 0..x.len() {
        for k in 0..N {
            let is_longer = corrected_step[k] >= step[k] + 0.1 * STEP_INCREASE;
            let choose = |corrected: f64, plain: f64| if is_longer { corrected } else { plain };
            let dx = choose(corrector[i][0][k], direction[i][0][k]);
            let goal = [choose(corrected[0][i][k], goal[0][i][k]), choose(corrected[1][i][k], goal[1][i][k])];
            let (dl, du) = multipliers([lower[i][k], upper[i][k]], goal, [inverse[0][i][k], inverse[1][i][k]], dx);
            let step = choose(corrected_step[k], step[k]);
            x[i][k] += step * dx;
            lower[i][k] += step * dl;
            upper[i][k] += step * du;
        }
    }
}

/// The multipliers of the direction towards `goal` whose x is `dx`.
#[inline(always)]
fn multipliers([l, u]: [f64; 2], goal: [f64; 2], [below, above]: [f64; 2], dx: f64) -> (f64, f64) {
    ((goal[0] - l * dx) * below - l, (goal[1] + u * dx) * above - u)
}

/// By how much a product is to be moved towards the neighbourhood of the centre.
#[inline(always)]
fn nearer(product: f64, centre: f64) -> f64 {
    let inside = smaller(larger(product, 0.1 * centre), 10.0 * centre);
    larger(inside - product, -10.0 * centre)
}

/// The larger; `b` if one is not a number.
#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// The smaller; `b` if one is not a number.
#[inline(always)]
fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}
