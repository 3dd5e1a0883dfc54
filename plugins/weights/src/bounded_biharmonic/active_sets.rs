//! The quadratic program of one handle, by active sets on its support.
//!
//! min ½ xᵀ Q x over 0 ≤ x ≤ 1 with some unknowns held. Weights of a handle are 0 over most of a surface with many handles, so
//! that the free set F = {0 < x < 1} is small. A step
//!
//! 1. factors Q over F, solves for the minimum without bounds and clamps it. Where the energy rose, it goes only as far along
//!    the way as the energy falls, and what was clamped is left out of the next F;
//! 2. lets projected Gauss-Seidel sweep over the rim of F and some rings about it, which moves the rim by several rings at once:
//!    active sets alone would move it by one a factorisation;
//! 3. takes for F what is then between the bounds.
//!
//! Every step lowers the energy. It stops once a step gains little, which is no proof of how near the minimum is:
//! [`certificate`](super::certificate) gives a bound afterwards.

use mimesh_core::{Result, linalg::Cholesky};

use super::level::{Level, NONE};

/// The end has come when a step lowers the energy by less than this part of what the tolerance allows. On bodies of 2,161 to
/// 53,386 vertices, a camel and a horse energies were then within the tolerance.
const SMALL_GAIN: f64 = 0.03;

/// Sweeps of Gauss-Seidel a step. With 10 or 60 the whole takes up to a fifth longer.
const SWEEPS: usize = 30;

/// Rings about the rim that are swept.
const RINGS: usize = 4;

/// Energies that differ by this part are equal to rounding.
const ROUNDING: f64 = 1e-12;

/// Weights up to this count as 0.
const ZERO: f64 = 1e-8;

/// Changes below this are not made in a sweep.
const MIN_CHANGE: f64 = 1e-9;

/// A sweep whose changes stay below this part of the first one's is the last.
const SWEPT: f64 = 1e-3;

/// A point near the minimum.
#[derive(Clone, Debug)]
pub struct Support {
    /// x at the places of the level; entries at a bound are exactly there.
    pub x: Vec<f64>,
    /// Factorisations done.
    pub steps: usize,
    /// Whether the last step gained little; if not, the steps allowed did not suffice or a factorisation failed.
    pub converged: bool,
}

/// min ½ xᵀ Q x over 0 ≤ x ≤ 1, where some unknowns are held.
#[derive(Debug)]
pub struct SupportProgram<'a> {
    /// Q and its order.
    pub level: &'a Level,
    /// Whether the unknown at each place is held.
    pub held: &'a [bool],
}

impl SupportProgram<'_> {
    /// Minimises for the handle at `handle` from `start`: the free set is where it lies between the bounds.
    pub fn minimise(&self, handle: u32, start: Vec<f64>, tolerance: f64, max_steps: usize) -> Support {
        let mut at = Iterate::new(self, handle, start);
        let mut energy = at.measure();
        // Whether the free set lacks something: a small gain says nothing then.
        let mut is_partial = false;
        for steps in 1..=max_steps {
            let Ok(factored) = at.factor() else {
                return Support { x: at.x, steps, converged: false };
            };
            let length = factored.as_ref().map_or(1.0, |factored| at.descend(factored, energy));
            let after = at.sweep();
            let gain = energy - after;
            energy = after;
            let is_whole = length == 1.0 && !is_partial;
            if steps > 1 && is_whole && gain <= SMALL_GAIN * tolerance * energy {
                return Support { x: at.x, steps, converged: true };
            }
            is_partial = length < 1.0;
            if is_partial {
                at.leave_out_clamped();
            }
        }
        Support { x: at.x, steps: max_steps, converged: false }
    }
}

/// x with its gradient, and lists of places.
struct Iterate<'a> {
    program: &'a SupportProgram<'a>,
    x: Vec<f64>,
    /// Q x.
    gradient: Vec<f64>,
    /// M⁻¹ L x.
    scaled: Vec<f64>,
    /// Where x is not 0, or was not before the last step.
    support: Vec<u32>,
    /// Where x is between the bounds.
    free: Vec<u32>,
    /// What the last step took to a bound, or would have taken there.
    clamped: Vec<u32>,
    /// Where the gradient may not be 0.
    reached: Vec<u32>,
    marks: Marks,
    /// The number of each place among `free` while a step needs it.
    number: Vec<u32>,
}

/// Q over a free set.
struct Factored {
    /// The free set, in the order of the factor.
    places: Vec<u32>,
    cholesky: Cholesky,
}

/// Places that have been come by.
struct Marks {
    last: Vec<u32>,
    round: u32,
}

impl Marks {
    fn clear(&mut self) {
        self.round += 1;
    }

    /// Marks a place; whether it was not marked before.
    fn add(&mut self, place: usize) -> bool {
        std::mem::replace(&mut self.last[place], self.round) != self.round
    }
}

impl<'a> Iterate<'a> {
    fn new(program: &'a SupportProgram<'a>, handle: u32, start: Vec<f64>) -> Self {
        let n = program.level.size();
        let mut x = start;
        for (i, (x, held)) in x.iter_mut().zip(program.held).enumerate() {
            *x = if *held { f64::from(u8::from(i as u32 == handle)) } else { x.clamp(0.0, 1.0) };
        }
        let marks = Marks { last: vec![0; n], round: 0 };
        let (gradient, scaled, number) = (vec![0.0; n], vec![0.0; n], vec![NONE; n]);
        let mut at = Self {
            program,
            x,
            gradient,
            scaled,
            support: vec![],
            free: vec![],
            clamped: vec![],
            reached: vec![],
            marks,
            number,
        };
        at.list(&(0..n as u32).collect::<Vec<_>>());
        at
    }

    /// Lists those of `places` where x is not 0, ascending, and which of them are free; x that is nearly 0 becomes 0.
    fn list(&mut self, places: &[u32]) {
        self.support.clear();
        for &i in places {
            if self.x[i as usize] > ZERO {
                self.support.push(i);
            } else {
                self.x[i as usize] = 0.0;
            }
        }
        self.support.sort_unstable();
        let is_free = |&&i: &&u32| !self.program.held[i as usize] && self.x[i as usize] < 1.0;
        self.free = self.support.iter().filter(is_free).copied().collect();
    }

    /// `places` and their neighbours.
    fn with_neighbours(&mut self, places: &[u32]) -> Vec<u32> {
        self.marks.clear();
        let mut all = Vec::with_capacity(2 * places.len());
        for &i in places {
            let near = self.program.level.laplacian.columns(i as usize);
            all.extend(near.iter().filter(|&&j| self.marks.add(j as usize)));
        }
        all
    }

    /// Sets the gradient and gives the energy, through L twice over what the support reaches.
    fn measure(&mut self) -> f64 {
        let level = self.program.level;
        let near = self.with_neighbours(&self.support.clone());
        let mut energy = 0.0;
        for &i in &near {
            let i = i as usize;
            let lx = level.laplacian.dot(i, &self.x);
            self.scaled[i] = lx * level.inverse_mass[i];
            energy += 0.5 * lx * self.scaled[i];
        }
        self.reached.iter().for_each(|&i| self.gradient[i as usize] = 0.0);
        self.reached = self.with_neighbours(&near);
        for &i in &self.reached {
            self.gradient[i as usize] = level.laplacian.dot(i as usize, &self.scaled);
        }
        near.iter().for_each(|&i| self.scaled[i as usize] = 0.0);
        energy
    }

    /// Factors Q over the free set.
    ///
    /// # Errors
    ///
    /// [`Error::Singular`](mimesh_core::Error::Singular) if that is not positive definite.
    fn factor(&mut self) -> Result<Option<Factored>> {
        if self.free.is_empty() {
            return Ok(None);
        }
        let mut places = self.free.clone();
        let matrix = self.program.level.restricted(&mut places, &mut self.number);
        places.iter().for_each(|&i| self.number[i as usize] = NONE);
        let cholesky = Cholesky::in_given_order(matrix, "the energy on a support")?;
        Ok(Some(Factored { places, cholesky }))
    }

    /// Goes to the minimum over the free set, clamped, or as far on the way there as the energy, which was `before`, falls; gives
    /// the part of the way.
    fn descend(&mut self, factored: &Factored, before: f64) -> f64 {
        // The way there, not x itself: its rounding then vanishes with it.
        let mut way: Vec<f64> = factored.places.iter().map(|&i| -self.gradient[i as usize]).collect();
        factored.cholesky.solve_in_place(&mut way, 1);
        self.clamped.clear();
        let was: Vec<f64> = factored.places.iter().map(|&i| self.x[i as usize]).collect();
        let mut slope = 0.0;
        for ((&i, d), &was) in factored.places.iter().zip(&mut way).zip(&was) {
            let next = (was + *d).clamp(0.0, 1.0);
            *d = next - was;
            slope += self.gradient[i as usize] * *d;
            self.x[i as usize] = next;
            if next <= 0.0 || next >= 1.0 {
                self.clamped.push(i);
            }
        }
        let after = self.measure();
        if after <= before * (1.0 + ROUNDING) {
            return 1.0;
        }
        // E(t) = before + slope t + (after − before − slope) t² for t from 0 to 1.
        let length = (-0.5 * slope / (after - before - slope)).clamp(0.0, 1.0);
        for ((&i, d), was) in factored.places.iter().zip(&way).zip(&was) {
            self.x[i as usize] = was + length * d;
        }
        self.measure();
        length
    }

    /// Sweeps over the rim of the free set and the rings about it, lists the free set anew and gives the energy.
    fn sweep(&mut self) -> f64 {
        let level = self.program.level;
        let band = self.band();
        // All that a change within the band reaches, besides what is reached.
        self.marks.clear();
        self.reached.iter().for_each(|&i| _ = self.marks.add(i as usize));
        for &i in &band {
            let near = level.energy.columns(i as usize);
            self.reached.extend(near.iter().filter(|&&j| self.marks.add(j as usize)));
        }
        let mut first = 0.0;
        for sweep in 0..SWEEPS {
            let mut most = 0.0_f64;
            for k in 0..band.len() {
                let i = band[if sweep % 2 == 0 { k } else { band.len() - 1 - k }] as usize;
                let next = (self.x[i] - self.gradient[i] / level.diagonal[i]).clamp(0.0, 1.0);
                let change = next - self.x[i];
                if change.abs() > MIN_CHANGE {
                    most = most.max(change.abs());
                    self.set(i, next);
                }
            }
            if sweep == 0 {
                first = most;
            }
            if most < SWEPT * first {
                break;
            }
        }
        for &i in &band {
            if self.x[i as usize] > 0.0 && self.x[i as usize] <= ZERO {
                self.set(i as usize, 0.0);
            }
        }
        let energy = 0.5 * self.reached.iter().map(|&i| self.x[i as usize] * self.gradient[i as usize]).sum::<f64>();
        self.list(&self.reached.clone());
        energy
    }

    /// Takes out of the free set what the last step could not take to its bound: a step for the others is not cut short by it.
    fn leave_out_clamped(&mut self) {
        self.marks.clear();
        self.clamped.iter().for_each(|&i| _ = self.marks.add(i as usize));
        self.free.retain(|&i| self.marks.add(i as usize));
    }

    /// Sets x at a place and what the gradient becomes.
    fn set(&mut self, i: usize, value: f64) {
        let change = value - self.x[i];
        self.x[i] = value;
        self.program.level.energy.row(i).for_each(|(j, q)| self.gradient[j] += q * change);
    }

    /// The rim and the rings about it, ascending. The rim is what the last step clamped, and what would leave its bound.
    fn band(&mut self) -> Vec<u32> {
        let Self { program, x, gradient, clamped, reached, marks, .. } = self;
        marks.clear();
        let mut band: Vec<u32> = Vec::new();
        let leaves = |i: usize| x[i] <= 0.0 && gradient[i] < 0.0 || x[i] >= 1.0 && gradient[i] > 0.0;
        let leaving = reached.iter().filter(|&&i| leaves(i as usize));
        band.extend(clamped.iter().chain(leaving).filter(|&&i| !program.held[i as usize] && marks.add(i as usize)));
        let mut from = 0;
        for _ in 0..RINGS {
            let to = band.len();
            for k in from..to {
                let near = program.level.laplacian.columns(band[k] as usize);
                band.extend(near.iter().filter(|&&j| !program.held[j as usize] && marks.add(j as usize)));
            }
            from = to;
        }
        band.sort_unstable();
        band
    }
}
