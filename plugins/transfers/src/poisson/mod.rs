//! Positions whose deformation gradients come closest to given fields.

mod elements;
mod lanes;
#[cfg(test)]
mod tests;

use std::sync::{Arc, Mutex};

use mimesh_core::{
    Result,
    linalg::{Assembly, LaneCholesky, LanePattern, Multifrontal},
    mesh::Surface,
};
use nalgebra::{Matrix3, Point3};
use nalgebra_sparse::CscMatrix;

use self::{
    elements::{Element, PAIRS},
    lanes::Workspace,
};

/// Systems of at most this many unknowns are factored in eight lanes: a factor then takes about 10 MB, and caches still help.
const MAX_UNKNOWNS_OF_EIGHT: usize = 10_000;

/// Systems of at most this many unknowns are factored in four lanes. At 350,000 dense blocks ([`Multifrontal`]) are as fast, and take
/// a third of the memory.
const MAX_UNKNOWNS_OF_FOUR: usize = 250_000;

/// What the system is called in errors.
const NAME: &str = "the system of the target's deformation gradients";

/// Minimises Σ_t w_t ρ(‖(F̂_t − F_t) P_t‖) over the posed vertices of a surface, for any number of fields F̂.
///
/// In the 3 × 2 edge form (Botsch et al. 2006): P_t projects onto the plane of triangle t, and the fourth vertex of Sumner
/// and Popović 2004 drops out. ρ(r) = r² is their least squares, for which the matrix (with w_t the area, the cotangent
/// Laplacian) is factored once. ρ(r) = 2ε (√(r² + ε²) − ε), nearly |r|, is minimised by reweighting: each step minimises a
/// quadratic that lies above the energy and touches it, so the energy never rises; the energy is convex, so there is one
/// minimum.
///
/// Several fields are solved for at once, one in each lane of a factorisation ([`LaneCholesky`]). The result of one does not depend on
/// the others, nor on how many they are.
#[derive(Debug)]
pub struct Poisson {
    system: System,
    elements: Vec<Element>,
    /// Σ w_t.
    total_weight: f64,
    rest: Vec<Point3<f64>>,
    /// For each vertex its row in the system; `None` for anchors and for vertices without a triangle.
    rows: Vec<Option<u32>>,
    /// For each vertex the anchor of its component; itself without a triangle.
    anchor: Vec<u32>,
    /// Room of solves that have ended, to be used again.
    workspaces: Mutex<Vec<Workspace>>,
}

/// The factored least squares, and how others are factored.
#[derive(Debug)]
enum System {
    /// Several matrices at once.
    Lanes { least_squares: LaneCholesky<1>, pattern: Arc<LanePattern> },
    /// One matrix at a time, for large meshes.
    Fronts(Box<Multifrontal>),
}

/// A solution and what it took.
#[derive(Debug)]
pub struct Solution {
    /// The posed vertices, #V.
    pub positions: Vec<Point3<f64>>,
    /// √(Σ w_t ‖(F̂_t − F_t) P_t‖² / Σ w_t): how far the gradients are from the field, without unit.
    pub residual: f64,
    /// The energy that was minimised, over Σ w_t, after each solve.
    pub energies: Vec<f64>,
}

/// How a field is fitted.
#[derive(Clone, Copy, Debug)]
pub struct Fit {
    /// The most reweightings after least squares.
    pub steps: usize,
    /// ε.
    pub epsilon: f64,
}

impl Fit {
    /// Least squares.
    pub const LEAST_SQUARES: Self = Self { steps: 0, epsilon: 1.0 };
}

impl Poisson {
    /// Factors the system of `target`; `weight` gives w_t from a triangle's area.
    ///
    /// # Errors
    ///
    /// [`Error::Singular`](mimesh_core::Error::Singular) if positions do not say where a vertex is, as those that are not finite.
    pub fn new(target: &Surface, weight: impl Fn(f64) -> f64) -> Result<Self> {
        Self::with_limit(target, weight, MAX_UNKNOWNS_OF_FOUR)
    }

    /// Like [`new`](Self::new), in lanes up to `most` unknowns.
    fn with_limit(target: &Surface, weight: impl Fn(f64) -> f64, most: usize) -> Result<Self> {
        let (numbers, anchor) = unknowns(target);
        let mut elements = elements::all(target, weight);
        let matrix = matrix(&elements, &target.triangles, &numbers);
        let (system, rows) = if matrix.ncols() <= most {
            let pattern = Arc::new(LanePattern::new(&matrix, NAME)?);
            let mut least_squares = LaneCholesky::<1>::new(pattern.clone());
            let values = least_squares.clear();
            for (i, j, &value) in matrix.triplet_iter() {
                let entry = pattern.entry(i as u32, j as u32).expect("the pattern is that of the matrix");
                values[entry as usize] = [value];
            }
            least_squares.factor_one()?;
            let rows = numbers.iter().map(|number| number.map(|i| pattern.row(i))).collect();
            elements::place(&mut elements, &target.triangles, &numbers, |i| pattern.row(i), |i, j| pattern.entry(i, j));
            (System::Lanes { least_squares, pattern }, rows)
        } else {
            elements::place(&mut elements, &target.triangles, &numbers, |i| i, |i, j| entry(&matrix, i, j));
            (System::Fronts(Box::new(Multifrontal::factored(&matrix, NAME)?)), numbers)
        };
        let total_weight = elements.iter().filter(|e| e.has_area).map(|e| e.weight).sum();
        let rest = target.positions.clone();
        Ok(Self { system, elements, total_weight, rest, rows, anchor, workspaces: Mutex::default() })
    }

    /// How many fields are best solved for together.
    pub fn at_once(&self) -> usize {
        match &self.system {
            System::Lanes { pattern, .. } if pattern.size() <= MAX_UNKNOWNS_OF_EIGHT => 8,
            System::Lanes { .. } => 4,
            System::Fronts(_) => 1,
        }
    }

    /// The bytes that so many fields take which are solved for side by side, with reweighting.
    pub fn bytes(&self, fields: usize) -> u64 {
        fields.div_ceil(self.at_once()) as u64 * self.bytes_of_room(self.at_once())
    }

    /// The posed vertices for each of `fields` (#F).
    ///
    /// The first corner of the first triangle of each component stays where it is at rest; of vertices without a triangle this
    /// says nothing. A solution is [`Error::Singular`](mimesh_core::Error::Singular) if weights have become too uneven to be solved.
    pub fn solve_all(&self, fields: &[&[Matrix3<f64>]], fit: Fit) -> Vec<Result<Solution>> {
        let mut solutions = Vec::with_capacity(fields.len());
        for fields in fields.chunks(self.at_once()) {
            let mut workspace = self.workspaces.lock().expect("no solve panics").pop().unwrap_or_default();
            solutions.extend(match self.at_once() {
                8 => self.solve_lanes(fields, fit, &mut workspace.eight),
                4 => self.solve_lanes(fields, fit, &mut workspace.four),
                _ => self.solve_lanes(fields, fit, &mut workspace.one),
            });
            self.workspaces.lock().expect("no solve panics").push(workspace);
        }
        solutions
    }
}

/// The lower triangle of the matrix of least squares.
fn matrix(elements: &[Element], triangles: &[[u32; 3]], numbers: &[Option<u32>]) -> CscMatrix<f64> {
    let mut matrix = Assembly::new(numbers.iter().flatten().count());
    for (element, corners) in elements.iter().zip(triangles) {
        let own = corners.map(|v| numbers[v as usize]);
        for ((a, b), value) in PAIRS.into_iter().zip(element.stiffness()) {
            if let (Some(i), Some(j)) = (own[a], own[b]) {
                // Two corners at one vertex: the pair stands for both entries off the diagonal.
                let times = if a != b && i == j { 2.0 } else { 1.0 };
                matrix.add(i as usize, j as usize, times * element.weight * value);
            }
        }
    }
    matrix.finish()
}

/// The number of entry (i, j) among the values of a lower triangle.
fn entry(lower: &CscMatrix<f64>, i: u32, j: u32) -> Option<u32> {
    let (starts, rows, _) = lower.csc_data();
    let column = i.min(j) as usize;
    let found = rows[starts[column]..starts[column + 1]].binary_search(&(i.max(j) as usize)).ok()?;
    Some((starts[column] + found) as u32)
}

/// A number for each vertex that a triangle uses but for one a component, its anchor; and for each vertex its anchor.
fn unknowns(target: &Surface) -> (Vec<Option<u32>>, Vec<u32>) {
    let components = target.components();
    let mut anchor: Vec<u32> = (0..target.vertex_count() as u32).collect();
    let mut first = vec![None; components.count()];
    let mut used = vec![false; target.vertex_count()];
    for &v in target.triangles.iter().flatten() {
        if let Some(c) = components.of_vertex[v as usize] {
            anchor[v as usize] = *first[c as usize].get_or_insert(v);
            used[v as usize] = anchor[v as usize] != v;
        }
    }
    let mut count = 0;
    let number = |used: &bool| {
        used.then(|| {
            count += 1;
            count - 1
        })
    };
    (used.iter().map(number).collect(), anchor)
}
