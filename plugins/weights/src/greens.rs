//! Weights that minimise a quadratic energy without bounds, in closed form for any choice of handles.
//!
//! A w = Σₖ λₖ eₖ away from the handles means w = Σₖ λₖ gₖ + c with Green's functions gₖ and Σ λₖ = 0, since A maps constants
//! to 0. The gₖ are solved for once for all points; then handles only ask for a dense system of their number and a product.

use std::collections::HashMap;

use mimesh_core::{
    Figures, Result,
    linalg::Multifrontal,
    mesh::SurfacePoint,
    stage::{HandlePoints, HandleWeights},
};
use nalgebra::DMatrix;
use nalgebra_sparse::CscMatrix;
use pulp::{Arch, NullaryFnOnce};
use rayon::prelude::*;

use crate::domain::{Domain, Group};

/// Right-hand sides that are solved for at a time: as many as the factorisation takes at once.
const BATCH: usize = 8;

/// Vertices that are summed over at a time: a block of a column stays in the first cache.
const BLOCK: usize = 1024;

/// The factored energy of a group with one vertex held.
#[derive(Debug)]
struct Factored {
    matrix: CscMatrix<f64>,
    factor: Multifrontal,
    refined: bool,
}

impl Factored {
    /// Holds vertex `held` of the energy `matrix`. Solutions are `refined` where it is badly conditioned.
    fn new(mut matrix: CscMatrix<f64>, held: usize, what: &'static str, refined: bool) -> Result<Self> {
        let mut is_held = vec![false; matrix.ncols()];
        is_held[held] = true;
        let values = crate::bilaplacian::without(&matrix, &is_held);
        matrix.values_mut().copy_from_slice(&values);
        let factor = Multifrontal::factored(&matrix, what)?;
        Ok(Self { matrix, factor, refined })
    }

    fn solve_in_place(&self, columns: &mut [f64]) {
        if self.refined {
            self.factor.solve_refined_in_place(&self.matrix, columns);
        } else {
            self.factor.solve_in_place(columns);
        }
    }
}

/// Green's functions at the points of a domain.
#[derive(Debug)]
pub struct Greens {
    domain: Domain,
    points: HandlePoints,
    /// gₖ of each point over the vertices of its group.
    functions: Vec<Vec<f64>>,
}

impl Greens {
    /// Solves for `points`; `energy` gives the lower triangle of A for a group, and `what` names it in errors. Solutions are
    /// `refined` where A is badly conditioned, as the square of an operator is.
    pub fn new(
        domain: Domain,
        points: HandlePoints,
        energy: impl Fn(&Group) -> CscMatrix<f64> + Sync,
        what: &'static str,
        refined: bool,
    ) -> Result<Self> {
        let mut of_group: Vec<Vec<(usize, usize)>> = vec![Vec::new(); domain.groups.len()];
        for (k, &v) in points.all().iter().enumerate() {
            if let Some((group, local)) = domain.place[v as usize] {
                of_group[group as usize].push((k, local as usize));
            }
        }
        let solve = |(group, points): (&Group, &Vec<(usize, usize)>)| -> Result<Vec<(usize, Vec<f64>)>> {
            let Some(&(_, origin)) = points.first() else { return Ok(vec![]) };
            let n = group.vertices.len();
            // The constant that A leaves open is taken so that every g is 0 at the first point.
            let factored = Factored::new(energy(group), origin, what, refined)?;
            let batch = |batch: &[(usize, usize)]| {
                let mut columns = vec![0.0; n * batch.len()];
                for (column, &(_, local)) in columns.chunks_mut(n).zip(batch) {
                    column[local] = f64::from(u8::from(local != origin));
                }
                factored.solve_in_place(&mut columns);
                batch.iter().map(|p| p.0).zip(columns.chunks(n).map(<[f64]>::to_vec)).collect::<Vec<_>>()
            };
            Ok(points.par_chunks(BATCH).flat_map_iter(batch).collect())
        };
        let mut functions = vec![Vec::new(); points.all().len()];
        let solved: Vec<_> = domain.groups.par_iter().zip(&of_group).map(solve).collect::<Result<_>>()?;
        solved.into_iter().flatten().for_each(|(k, function)| functions[k] = function);
        Ok(Self { domain, points, functions })
    }

    /// The weights of `handles`: ½ wᵀ A w is least, 1 at the own handle, 0 at the others.
    pub fn solve(&self, handles: &[usize], unit: impl Fn(&Group) -> f64) -> Result<HandleWeights> {
        let vertices = self.points.choose(handles)?;
        combined(&self.domain, &vertices, |k| &self.functions[handles[k]], unit)
    }

    /// The report of binding.
    pub fn figures(&self) -> Figures {
        self.domain.figures()
    }
}

/// Green's functions of a domain whose points come and go: its matrices stay factored, and each new point costs a solve.
#[derive(Debug)]
pub struct KeptGreens {
    domain: Domain,
    /// The factor of each group, with its first vertex held.
    factors: Vec<Factored>,
    /// gₖ of points that were asked for lately, by their vertices.
    functions: HashMap<u32, Vec<f64>>,
}

/// How many functions are kept beside those in use.
const KEPT: usize = 64;

impl KeptGreens {
    /// Factors the energies of all groups of `domain`.
    pub fn new(
        domain: Domain,
        energy: impl Fn(&Group) -> CscMatrix<f64> + Sync,
        what: &'static str,
        refined: bool,
    ) -> Result<Self> {
        let factor = |group: &Group| Factored::new(energy(group), 0, what, refined);
        let factors = domain.groups.par_iter().map(factor).collect::<Result<_>>()?;
        Ok(Self { domain, factors, functions: HashMap::new() })
    }

    /// The weights of handles at `points`.
    pub fn solve(&mut self, points: &[SurfacePoint], unit: impl Fn(&Group) -> f64) -> Result<HandleWeights> {
        let points = HandlePoints::new(&self.domain.surface, points)?;
        let all: Vec<usize> = (0..points.all().len()).collect();
        let vertices = points.choose(&all)?;
        if self.functions.len() > KEPT + vertices.len() {
            self.functions.retain(|vertex, _| vertices.contains(vertex));
        }
        let missing: Vec<u32> =
            vertices.iter().copied().filter(|vertex| !self.functions.contains_key(vertex)).collect();
        let solve = |vertex: &u32| {
            let (group, local) = self.domain.place[*vertex as usize].unwrap_or_default();
            let mut column = vec![0.0; self.domain.groups.get(group as usize).map_or(0, |group| group.vertices.len())];
            // The first vertex is held at 0.
            if local > 0 {
                column[local as usize] = 1.0;
                self.factors[group as usize].solve_in_place(&mut column);
            }
            (*vertex, column)
        };
        let solved: Vec<_> = missing.par_iter().map(solve).collect();
        self.functions.extend(solved);
        combined(&self.domain, &vertices, |k| &self.functions[&vertices[k]], unit)
    }
}

/// The weights of handles at `vertices`, the Green's function of each of which is `function`.
fn combined<'g>(
    domain: &Domain,
    vertices: &[u32],
    function: impl Fn(usize) -> &'g Vec<f64> + Sync,
    unit: impl Fn(&Group) -> f64,
) -> Result<HandleWeights> {
    let by_group = domain.by_group(vertices)?;
    let mut matrix = DMatrix::zeros(domain.place.len(), vertices.len());
    let mut energies = vec![0.0; vertices.len()];
    for (group, own) in domain.groups.iter().zip(&by_group).filter(|(_, own)| !own.is_empty()) {
        let count = own.len();
        let at = |k: usize| domain.place[vertices[own[k]] as usize].map_or(0, |(_, local)| local as usize);
        let greens = |k: usize| function(own[k]);
        let mut system = DMatrix::zeros(count + 1, count + 1);
        for i in 0..count {
            (system[(i, count)], system[(count, i)]) = (1.0, 1.0);
            // Both are the same but for rounding.
            (0..count).for_each(|j| system[(i, j)] = 0.5 * (greens(j)[at(i)] + greens(i)[at(j)]));
        }
        // λ of each handle in a column, and its constant below.
        let found =
            system.lu().solve(&DMatrix::identity(count + 1, count)).ok_or_else(|| mimesh_core::Error::Singular {
                what: "the system of handles",
                hint: "look for handles on parts of the mesh without area: `mimesh inspect MESH`".into(),
            })?;
        let functions: Vec<&[f64]> = (0..count).map(|k| greens(k).as_slice()).collect();
        let column = |k: usize| {
            let factors: Vec<f64> = (0..count).map(|j| found[(j, k)]).collect();
            let mut column = vec![found[(count, k)]; group.vertices.len()];
            Arch::new().dispatch(AddFunctions { functions: &functions, factors: &factors, column: &mut column });
            // Rounding away from what is asked for exactly.
            (0..count).for_each(|j| column[at(j)] = f64::from(u8::from(j == k)));
            column
        };
        let columns: Vec<Vec<f64>> = (0..count).into_par_iter().map(column).collect();
        for (k, (&handle, column)) in own.iter().zip(&columns).enumerate() {
            energies[handle] = 0.5 * found[(k, k)] / unit(group);
            let mut weights = matrix.column_mut(handle);
            group.vertices.iter().zip(column).for_each(|(&v, &w)| weights[v as usize] = w);
        }
    }
    for [v, by] in domain.unreached(&by_group)? {
        let row = matrix.row(by as usize).into_owned();
        matrix.set_row(v as usize, &row);
    }
    let mut figures = Figures::default();
    figures.set("energies", energies);
    figures.set("least_weight", matrix.min());
    figures.set("greatest_weight", matrix.max());
    Ok(HandleWeights { matrix, figures })
}

/// Adds λₖ gₖ of all points to a column.
struct AddFunctions<'a> {
    functions: &'a [&'a [f64]],
    factors: &'a [f64],
    column: &'a mut [f64],
}

// Inlined into the function that the processor's instructions are chosen for.
impl NullaryFnOnce for AddFunctions<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { functions, factors, column } = self;
        for (block, sums) in column.chunks_mut(BLOCK).enumerate() {
            for (function, factor) in functions.iter().zip(factors) {
                let function = &function[block * BLOCK..][..sums.len()];
                sums.iter_mut().zip(function).for_each(|(sum, g)| *sum += factor * g);
            }
        }
    }
}
