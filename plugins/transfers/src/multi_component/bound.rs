//! A target of many components bound to a source, and its motion frame by frame.

use mimesh_core::{
    Error, Figures, Result,
    mesh::check_finite,
    operators::polar,
    stage::{BoundTransfer, Motion, Transferred},
};
use nalgebra::{Matrix3, Point3, Vector3};

use super::{
    foot_contacts::FootContacts,
    gaps::{Gap, Gaps},
    prior::Prior,
    rigid::Rigid,
    system::System,
};
use crate::{field::Field, placement::BoundPlacement};

#[derive(Debug)]
pub struct Bound {
    pub gaps_keep: Gaps,
    /// Whether E2 has a weight.
    pub continue_neighbours: bool,
    pub sequence: bool,
    pub max_steps: usize,
    pub tolerance: f64,
    pub prior: Option<Prior>,
    pub field: Field,
    pub gaps: Vec<Gap>,
    pub system: System,
    pub rigid: Rigid,
    pub foot_contacts: FootContacts,
    pub placement: BoundPlacement,
    pub around: Vec<Vec<u32>>,
    pub figures: Figures,
}

impl BoundTransfer for Bound {
    fn transfer(&self, posed: &[Point3<f64>]) -> Result<Transferred> {
        self.solve(posed, None, &[], |positions| self.placement.apply(posed, positions))
    }

    fn motion(&self) -> Option<Box<dyn Motion + '_>> {
        let is_one = self.sequence || !self.foot_contacts.is_empty();
        is_one.then(|| {
            Box::new(Frames { bound: self, before: None, stands_at: vec![None; self.foot_contacts.len()] }) as _
        })
    }

    fn figures(&self) -> Figures {
        self.figures.clone()
    }
}

/// The motion under way.
struct Frames<'a> {
    bound: &'a Bound,
    /// Source and target at the frame before.
    before: Option<[Vec<Point3<f64>>; 2]>,
    /// Where each foot contact stands, once its first frame is done.
    stands_at: Vec<Option<Vector3<f64>>>,
}

impl Motion for Frames<'_> {
    fn frame(&mut self, frame: usize, posed: &[Point3<f64>]) -> Result<Transferred> {
        let (bound, before, stands_at) = (self.bound, &self.before, &mut self.stands_at);
        let goals: Vec<_> = bound.foot_contacts.at(frame).filter_map(|k| Some((k, stands_at[k]?))).collect();
        let start = before.as_ref().filter(|_| bound.sequence).map(|[_, target]| target.as_slice());
        let place = |positions: &mut [Point3<f64>]| match before {
            _ if !goals.is_empty() => {
                // What is rigid was moved after contacts were met.
                let off = |&(k, goal): &(usize, Vector3<f64>)| bound.foot_contacts.place(k, positions) - goal;
                let shift = goals.iter().map(off).sum::<Vector3<f64>>() / goals.len() as f64;
                positions.iter_mut().for_each(|p| *p -= shift);
            }
            // Foot contacts have moved the target away from where the source alone would have it; it goes on from there.
            Some([source, target]) if !bound.foot_contacts.is_empty() => {
                bound.placement.apply_since(source, target, posed, positions);
            }
            _ => bound.placement.apply(posed, positions),
        };
        let transferred = bound.solve(posed, start, &goals, place)?;
        for k in bound.foot_contacts.at(frame) {
            stands_at[k].get_or_insert_with(|| bound.foot_contacts.place(k, &transferred.positions));
        }
        self.before = Some([posed.to_vec(), transferred.positions.clone()]);
        Ok(transferred)
    }
}

impl Bound {
    /// The target when the source is at `posed`, the steps starting from `start`, foot contacts held at `held`, and put in its place
    /// by `place`.
    fn solve(
        &self,
        posed: &[Point3<f64>],
        start: Option<&[Point3<f64>]>,
        held: &[(usize, Vector3<f64>)],
        place: impl FnOnce(&mut [Point3<f64>]),
    ) -> Result<Transferred> {
        Error::check_shape("posed source vertices (#V)", self.field.source_vertices(), posed.len())?;
        check_finite(posed)?;
        let mut field = self.field.at(posed);
        if !self.continue_neighbours {
            // Continuing their neighbours is E2 as well.
            (0..field.len()).filter(|&t| self.field.is_orphan(t)).for_each(|t| field[t] = Matrix3::identity());
        }
        let initial = match &self.prior {
            Some(prior) => {
                let mut positions = prior.positions(posed)?;
                self.placement.apply(posed, &mut positions);
                Some(positions)
            }
            None => None,
        };
        if let (Some(prior), Some(b)) = (&self.prior, &initial) {
            prior.fill(b, &mut field, |t| self.field.is_orphan(t));
        }
        let start = start.or(initial.as_deref());
        self.rigid.stiffen(&mut field);
        let mut known: Vec<Option<Vector3<f64>>> = self.known_gaps(posed, &field);
        if let Some(b) = &initial {
            for (known, gap) in known.iter_mut().zip(&self.gaps).filter(|(_, gap)| gap.is_loose()) {
                *known = Some(b[gap.ends[0] as usize] - b[gap.ends[1] as usize]);
            }
        }
        let rhs = self.system.rhs(&field);

        let first_guess = |gap: &Gap| {
            let guess = gap.first_guess(&field);
            start.map_or(guess, |start| with_length(gap, start, guess))
        };
        let mut vectors: Vec<_> =
            self.gaps.iter().zip(&known).map(|(gap, known)| known.unwrap_or_else(|| first_guess(gap))).collect();
        let mut details = match start {
            Some(start) => self.system.details(start),
            None => self.system.turned_details(|v| self.rotation(v, &field)),
        };
        let mut energies = Vec::new();
        let mut goals = initial.clone().unwrap_or_default();
        // Whether directions change from step to step.
        let turns = self.system.has_details() || known.iter().any(Option::is_none);
        let mut positions;
        loop {
            let mut x = self.system.solve(&rhs, &self.gaps, &vectors, &details, &goals);
            let shift = if held.is_empty() { None } else { Some(self.foot_contacts.hold(held, &self.system, &mut x)) };
            positions = self.system.positions(&x);
            let mut moved = None;
            let mut energy = self.system.energy(&x, &field) + self.gap_energy(&known, &positions);
            if let (Some(prior), Some(b)) = (&self.prior, &initial) {
                // Before foot contacts shift the target as a whole, which E5 is not to mind.
                energy += prior.energy(b, &positions);
                let next = prior.goals(b, &positions);
                moved = prior.distance(&goals, &next);
                goals = next;
            }
            positions.iter_mut().for_each(|p| *p += shift.unwrap_or_default());
            let lowered = energies.last().is_none_or(|last| last - energy > self.tolerance * last);
            let settled = moved.is_none_or(|moved| moved <= self.tolerance) && !(turns && lowered);
            energies.push(energy);
            if settled || energies.len() == self.max_steps {
                break;
            }
            for ((vector, gap), known) in vectors.iter_mut().zip(&self.gaps).zip(&known) {
                if known.is_none() {
                    *vector = with_length(gap, &positions, *vector);
                }
            }
            details = self.system.details(&positions);
        }
        self.rigid.fit(&mut positions);
        place(&mut positions);
        check_finite(&positions)?;
        let mut figures = Figures::default();
        figures.set("steps", energies.len());
        figures.set("energy", energies[energies.len() - 1]);
        Ok(Transferred { positions, figures })
    }

    fn known_gaps(&self, posed: &[Point3<f64>], field: &[Matrix3<f64>]) -> Vec<Option<Vector3<f64>>> {
        let similarity = &self.placement.alignment.target_from_source;
        let vector = |gap: &Gap| gap.vector(self.gaps_keep, self.field.source(), posed, field, similarity);
        self.gaps.iter().map(vector).collect()
    }

    /// E3.
    fn gap_energy(&self, known: &[Option<Vector3<f64>>], positions: &[Point3<f64>]) -> f64 {
        let energy = |(gap, known): (&Gap, &Option<Vector3<f64>>)| {
            let now = positions[gap.ends[0] as usize] - positions[gap.ends[1] as usize];
            gap.weight
                * known.map_or_else(|| (now.norm() - gap.rest.norm()).powi(2), |goal| (now - goal).norm_squared())
        };
        self.gaps.iter().zip(known).map(energy).sum()
    }

    /// How the surface around a vertex has turned.
    fn rotation(&self, vertex: u32, field: &[Matrix3<f64>]) -> Matrix3<f64> {
        let mean: Matrix3<f64> = self.around[vertex as usize].iter().map(|&t| field[t as usize]).sum();
        if mean.norm() > 0.0 { polar(&mean).rotation } else { Matrix3::identity() }
    }
}

/// The gap with the direction of now and the length at rest; as `before` if it has no direction.
fn with_length(gap: &Gap, positions: &[Point3<f64>], before: Vector3<f64>) -> Vector3<f64> {
    let now = positions[gap.ends[0] as usize] - positions[gap.ends[1] as usize];
    now.try_normalize(1e-300).map_or(before, |direction| direction * gap.rest.norm())
}
