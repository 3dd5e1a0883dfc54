//! Solves for several fields at once.

use mimesh_core::{
    Error, Result,
    linalg::{LaneCholesky, Multifrontal},
    memory::bytes_of,
};
use nalgebra::{Matrix3, Point3, Vector3};
use pulp::{Arch, NullaryFnOnce};

use super::{
    Fit, Poisson, Solution, System,
    elements::{Element, NONE, PAIRS},
};

/// Reweighting stops once a step lowers the energy by less than this part of it.
const MIN_ENERGY_DECREASE: f64 = 1e-3;

/// The room of a solve in any number of lanes.
#[derive(Debug, Default)]
pub(super) struct Workspace {
    pub eight: Room<8>,
    pub four: Room<4>,
    pub one: Room<1>,
}

/// The arrays of a solve.
#[derive(Debug, Default)]
pub(super) struct Room<const N: usize> {
    /// Where each field has the two edges of each element.
    goals: Vec<[[[f64; N]; 3]; 2]>,
    /// The unknowns by rows, relative to their anchors; behind them a row of zeros for anchors.
    x: Vec<[[f64; N]; 3]>,
    /// The right-hand sides of the next solve.
    next: Vec<[[f64; N]; 3]>,
    /// The matrices of the next solve; `None` until one is needed.
    matrices: Option<Matrices<N>>,
}

#[derive(Debug)]
enum Matrices<const N: usize> {
    Lanes(LaneCholesky<N>),
    /// The values of one lower triangle, and its factor.
    Fronts(Vec<[f64; N]>, Multifrontal),
}

/// What one pass over the elements sums up, not yet over Σ w_t.
#[derive(Clone, Copy)]
struct Sums<const N: usize> {
    energies: [f64; N],
    squares: [f64; N],
}

impl Poisson {
    /// Solves for at most `N` fields; where they are fewer, the first stands in for the others.
    pub(super) fn solve_lanes<const N: usize>(
        &self,
        fields: &[&[Matrix3<f64>]],
        fit: Fit,
        room: &mut Room<N>,
    ) -> Vec<Result<Solution>> {
        self.start(fields, room);
        let mut solutions: Vec<Option<Result<Solution>>> = fields.iter().map(|_| None).collect();
        let mut energies: Vec<Vec<f64>> = vec![vec![]; fields.len()];
        self.solve_least_squares(room);
        let mut is_solved = [true; N];
        for step in 0.. {
            let is_last = step == fit.steps;
            let sums = self.pass(fit, room, is_last);
            for lane in 0..fields.len() {
                if solutions[lane].is_some() {
                    continue;
                }
                if !is_solved[lane] {
                    solutions[lane] = Some(Err(self.singular()));
                    continue;
                }
                let energy = sums.energies[lane] / self.total_weight;
                let before = energies[lane].last().copied();
                energies[lane].push(energy);
                if is_last || before.is_some_and(|before| before - energy <= MIN_ENERGY_DECREASE * before) {
                    solutions[lane] = Some(Ok(Solution {
                        positions: self.positions(&room.x, lane),
                        residual: (sums.squares[lane] / self.total_weight).sqrt(),
                        energies: std::mem::take(&mut energies[lane]),
                    }));
                }
            }
            if solutions.iter().all(Option::is_some) {
                break;
            }
            is_solved = self.solve_next(room);
        }
        solutions.into_iter().flatten().collect()
    }

    /// Sets the goals, and the right-hand sides of least squares.
    fn start<const N: usize>(&self, fields: &[&[Matrix3<f64>]], room: &mut Room<N>) {
        let rows = self.size() + 1;
        let Room { goals, x, next, .. } = room;
        goals.clear();
        goals.reserve(self.elements.len());
        for element in &self.elements {
            let mut goal = [[[0.0; N]; 3]; 2];
            for lane in 0..N {
                let f = &fields[if lane < fields.len() { lane } else { 0 }][element.triangle as usize];
                for (goal, edge) in goal.iter_mut().zip(&element.edges) {
                    let posed = f * edge;
                    (0..3).for_each(|c| goal[c][lane] = posed[c]);
                }
            }
            goals.push(goal);
        }
        x.clear();
        x.resize(rows, [[0.0; N]; 3]);
        next.clear();
        next.resize(rows, [[0.0; N]; 3]);
        for (element, goal) in self.elements.iter().zip(goals.iter()) {
            add_right_hand_side(element, goal, &[element.weight; N], x);
        }
    }

    fn size(&self) -> usize {
        match &self.system {
            System::Lanes { pattern, .. } => pattern.size(),
            System::Fronts(least_squares) => least_squares.size(),
        }
    }

    fn singular(&self) -> Error {
        match &self.system {
            System::Lanes { least_squares, .. } => least_squares.singular(),
            System::Fronts(least_squares) => least_squares.singular(),
        }
    }

    fn solve_least_squares<const N: usize>(&self, room: &mut Room<N>) {
        match &self.system {
            System::Lanes { least_squares, .. } => least_squares.solve_lanes_in_place(&mut room.x),
            System::Fronts(least_squares) => solve_first_lane(least_squares, &mut room.x),
        }
        room.x[self.size()] = [[0.0; N]; 3];
    }

    /// Factors the matrices of the last pass and solves for its right-hand sides; says which lanes could be.
    fn solve_next<const N: usize>(&self, room: &mut Room<N>) -> [bool; N] {
        std::mem::swap(&mut room.x, &mut room.next);
        let is_definite = match room.matrices.as_mut().expect("the last pass has set them") {
            Matrices::Lanes(matrices) => {
                let is_definite = matrices.factor();
                matrices.solve_in_place(&mut room.x);
                is_definite
            }
            Matrices::Fronts(values, factor) => {
                let is_definite = factor.factor(values.as_flattened());
                if is_definite {
                    solve_first_lane(factor, &mut room.x);
                }
                [is_definite; N]
            }
        };
        room.x[self.size()] = [[0.0; N]; 3];
        is_definite
    }

    /// Measures the fit at x, and sets the matrices and right-hand sides of the next step unless this `is_last`.
    fn pass<const N: usize>(&self, fit: Fit, room: &mut Room<N>, is_last: bool) -> Sums<N> {
        let Room { goals, x, next, matrices } = room;
        if is_last {
            let elements = &self.elements;
            return Arch::new().dispatch(Pass::<N, false> { elements, goals, x, fit, values: &mut [], next: &mut [] });
        }
        let matrices = matrices.get_or_insert_with(|| match &self.system {
            System::Lanes { pattern, .. } => Matrices::Lanes(LaneCholesky::new(pattern.clone())),
            System::Fronts(least_squares) => Matrices::Fronts(vec![], least_squares.for_refactoring()),
        });
        let values = match matrices {
            Matrices::Lanes(matrices) => matrices.clear(),
            Matrices::Fronts(values, factor) => {
                values.clear();
                values.resize(factor.entry_count(), [0.0; N]);
                values
            }
        };
        next.fill([[0.0; N]; 3]);
        Arch::new().dispatch(Pass::<N, true> { elements: &self.elements, goals, x, fit, values, next })
    }

    /// The bytes of the room of a solve in `lanes` lanes that reweights.
    pub(super) fn bytes_of_room(&self, lanes: usize) -> u64 {
        let vectors = bytes_of::<[f64; 3]>(lanes * (2 * self.elements.len() + 2 * self.size()));
        let matrices = match &self.system {
            System::Lanes { pattern, .. } => bytes_of::<f64>(lanes * pattern.entry_count()),
            System::Fronts(factor) => bytes_of::<f64>(lanes * factor.entry_count()) + lanes as u64 * factor.bytes(),
        };
        vectors + matrices
    }

    /// The vertices in a lane.
    fn positions<const N: usize>(&self, x: &[[[f64; N]; 3]], lane: usize) -> Vec<Point3<f64>> {
        let place = |(v, row): (usize, &Option<u32>)| match row {
            Some(row) => {
                let [x, y, z] = x[*row as usize].map(|coordinate| coordinate[lane]);
                self.rest[self.anchor[v] as usize] + Vector3::new(x, y, z)
            }
            None => self.rest[v],
        };
        self.rows.iter().enumerate().map(place).collect()
    }
}

/// One pass over the elements: the fit of x to `goals`, and, to `ASSEMBLE`, what it makes of the next step.
struct Pass<'a, const N: usize, const ASSEMBLE: bool> {
    elements: &'a [Element],
    goals: &'a [[[[f64; N]; 3]; 2]],
    x: &'a [[[f64; N]; 3]],
    fit: Fit,
    values: &'a mut [[f64; N]],
    next: &'a mut [[[f64; N]; 3]],
}

// Inlined into the function that the processor's instructions are chosen for.
impl<const N: usize, const ASSEMBLE: bool> NullaryFnOnce for Pass<'_, N, ASSEMBLE> {
    type Output = Sums<N>;

    #[inline(always)]
    fn call(self) -> Sums<N> {
        let Self { elements, goals, x, fit, values, next } = self;
        let mut sums = Sums { energies: [0.0; N], squares: [0.0; N] };
        for (element, goal) in elements.iter().zip(goals) {
            let mut weights = [element.weight; N];
            if element.has_area {
                let square = square(element, goal, element.rows.map(|row| &x[row as usize]));
                for k in 0..N {
                    let root = (square[k] + fit.epsilon * fit.epsilon).sqrt();
                    let rho = if fit.steps == 0 { square[k] } else { 2.0 * fit.epsilon * (root - fit.epsilon) };
                    sums.energies[k] += element.weight * rho;
                    sums.squares[k] += element.weight * square[k];
                    weights[k] *= fit.epsilon / root;
                }
            }
            if ASSEMBLE {
                add_stiffness(element, &weights, values);
                add_right_hand_side(element, goal, &weights, next);
            }
        }
        sums
    }
}

/// Adds the products of an element's gradients to the matrix.
#[inline(always)]
fn add_stiffness<const N: usize>(element: &Element, weights: &[f64; N], values: &mut [[f64; N]]) {
    for (((a, b), entry), value) in PAIRS.into_iter().zip(element.entries).zip(element.stiffness()) {
        if entry == NONE {
            continue;
        }
        // Two corners at one vertex: the pair stands for both entries off the diagonal.
        let value = if a != b && element.rows[a] == element.rows[b] { 2.0 * value } else { value };
        let to = &mut values[entry as usize];
        for k in 0..N {
            to[k] += weights[k] * value;
        }
    }
}

/// ‖(F̂ − F) P‖² of an element with corners at `x`.
#[inline(always)]
fn square<const N: usize>(element: &Element, goal: &[[[f64; N]; 3]; 2], x: [&[[f64; N]; 3]; 3]) -> [f64; N] {
    let [a, b, c] = element.norm;
    let mut sum = [0.0; N];
    for axis in 0..3 {
        for k in 0..N {
            let first = goal[0][axis][k] - (x[1][axis][k] - x[0][axis][k]);
            let second = goal[1][axis][k] - (x[2][axis][k] - x[0][axis][k]);
            let (along, across) = (a * first + b * second, c * second);
            sum[k] += along * along + across * across;
        }
    }
    sum
}

/// Adds what an element draws its corners with.
#[inline(always)]
fn add_right_hand_side<const N: usize>(
    element: &Element,
    goal: &[[[f64; N]; 3]; 2],
    weights: &[f64; N],
    to: &mut [[[f64; N]; 3]],
) {
    let [one, mixed, two] = element.products;
    let (mut first, mut second) = ([[0.0; N]; 3], [[0.0; N]; 3]);
    for axis in 0..3 {
        for k in 0..N {
            first[axis][k] = (one * goal[0][axis][k] + mixed * goal[1][axis][k]) * weights[k];
            second[axis][k] = (mixed * goal[0][axis][k] + two * goal[1][axis][k]) * weights[k];
        }
    }
    let [i, j, l] = element.rows.map(|row| row as usize);
    for axis in 0..3 {
        for k in 0..N {
            to[i][axis][k] -= first[axis][k] + second[axis][k];
            to[j][axis][k] += first[axis][k];
            to[l][axis][k] += second[axis][k];
        }
    }
}

/// Solves for the first lane, and sets the others to it: where there are fronts, there is but one.
fn solve_first_lane<const N: usize>(factor: &Multifrontal, x: &mut [[[f64; N]; 3]]) {
    let n = factor.size();
    let mut columns: Vec<f64> = (0..3).flat_map(|axis| x[..n].iter().map(move |row| row[axis][0])).collect();
    factor.solve_in_place(&mut columns);
    for (axis, column) in columns.chunks(n.max(1)).enumerate() {
        x.iter_mut().zip(column).for_each(|(row, &value)| row[axis] = [value; N]);
    }
}
