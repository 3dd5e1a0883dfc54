//! Weights without bounds of several choices of handles at once, from which the interior point starts.

use mimesh_core::{Result, linalg::LaneCholesky};
use pulp::{Arch, NullaryFnOnce};
use rayon::prelude::*;

use super::{FEW, LaneProgram, iterates::energy_and_gradient};

/// A choice of handles.
#[derive(Clone, Copy, Debug)]
pub struct LaneChoice<'a> {
    /// Whether each unknown is one of the handles.
    pub held: &'a [bool],
    /// The handles that are solved for.
    pub unknowns: &'a [usize],
}

impl LaneProgram {
    /// For each choice the weights without bounds of each of its unknowns.
    ///
    /// # Errors
    ///
    /// [`Error::Singular`](mimesh_core::Error::Singular) for a choice without which Q is not positive definite.
    pub fn unbounded(&self, choices: &[LaneChoice<'_>]) -> Vec<Result<Vec<Vec<f64>>>> {
        choices.par_chunks(FEW).flat_map_iter(|some| Arch::new().dispatch(Unbounded { program: self, some })).collect()
    }
}

/// Solves for at most [`FEW`] choices, one in each lane.
struct Unbounded<'a> {
    program: &'a LaneProgram,
    some: &'a [LaneChoice<'a>],
}

// Inlined, with all that it calls, into the function that the processor's instructions are chosen for.
impl NullaryFnOnce for Unbounded<'_> {
    type Output = Vec<Result<Vec<Vec<f64>>>>;

    #[inline(always)]
    fn call(self) -> Self::Output {
        let Self { program, some } = self;
        let n = program.rows.len();
        let mut free = vec![[0.0; FEW]; n];
        for (lane, choice) in some.iter().enumerate() {
            let of_unknowns = program.rows.iter().zip(choice.held);
            of_unknowns.for_each(|(&row, &held)| free[row as usize][lane] = f64::from(u8::from(!held)));
        }
        let mut cholesky = LaneCholesky::<FEW>::new(program.pattern.clone());
        program.assemble_free(&free, cholesky.clear());
        let is_definite = cholesky.factor();
        let mut found: Vec<Vec<Vec<f64>>> =
            some.iter().map(|choice| Vec::with_capacity(choice.unknowns.len())).collect();
        let (mut x, mut scaled, mut gradient) = (vec![[0.0; FEW]; n], vec![[0.0; FEW]; n], vec![[0.0; FEW]; n]);
        let mut step = vec![[[0.0; FEW]; 1]; n];
        for k in 0..some.iter().map(|choice| choice.unknowns.len()).max().unwrap_or(0) {
            x.fill([0.0; FEW]);
            let row_of =
                |choice: &LaneChoice<'_>| choice.unknowns.get(k).map(|&unknown| program.rows[unknown] as usize);
            let own: Vec<Option<usize>> = some.iter().map(row_of).collect();
            own.iter().enumerate().for_each(|(lane, row)| row.iter().for_each(|&row| x[row][lane] = 1.0));
            energy_and_gradient(program, &free, &x, &mut scaled, &mut gradient);
            for (step, gradient) in step.iter_mut().zip(&gradient) {
                step[0] = gradient.map(|g| -g);
            }
            cholesky.solve_in_place(&mut step);
            for (lane, found) in found.iter_mut().enumerate().filter(|(lane, _)| own[*lane].is_some()) {
                let weight = |&row: &u32| x[row as usize][lane] + step[row as usize][0][lane];
                found.push(program.rows.iter().map(weight).collect());
            }
        }
        let checked = |(lane, found)| if is_definite[lane] { Ok(found) } else { Err(cholesky.singular()) };
        found.into_iter().enumerate().map(checked).collect()
    }
}
