//! A target of many components bound to a source, and its motion frame by frame.

use mimesh_core::{
    Error, Figures, Result,
    mesh::check_finite,
    operators::polar,
    stage::{BoundTransfer, Motion, Transferred},
};
use nalgebra::{Matrix3, Point3, Vector3};
use rayon::prelude::*;

use super::{
    foot_contacts::FootContacts,
    gaps::{AllGaps, Deformation, Gap, Gaps},
    minimum::{Descent, Directions, Minimum, Problem},
    prior::Prior,
    rigid::Rigid,
    system::{Continued, System},
};
use crate::{extension::Continuation, field::Field, placement::BoundPlacement};

#[derive(Debug)]
pub struct Bound {
    pub gaps_keep: Gaps,
    pub continuation: Continuation,
    /// Whether E2 has a weight.
    pub continue_neighbours: bool,
    pub sequence: bool,
    pub max_steps: usize,
    pub tolerance: f64,
    pub prior: Option<Prior>,
    pub field: Field,
    pub gaps: AllGaps,
    pub system: System,
    pub rigid: Rigid,
    pub foot_contacts: FootContacts,
    pub placement: BoundPlacement,
    pub around: Vec<Vec<u32>>,
    pub figures: Figures,
}

impl BoundTransfer for Bound {
    fn transfer(&self, posed: &[Point3<f64>]) -> Result<Transferred> {
        self.transfer_all(&[posed]).pop().expect("one pose has one result")
    }

    fn at_once(&self) -> usize {
        self.system.at_once()
    }

    fn transfer_all(&self, poses: &[&[Point3<f64>]]) -> Vec<Result<Transferred>> {
        let starts = self.starts(poses);
        let mut descents: Vec<Option<Descent<'_>>> = starts
            .par_iter()
            .zip(poses)
            .map(|(start, posed)| Some(self.descent(posed, start.as_ref().ok()?, None)))
            .collect();
        self.descend(descents.iter_mut().flatten().collect());
        let minima: Vec<Option<Minimum>> = descents.iter().map(|d| d.as_ref().map(Descent::minimum)).collect();
        let each = starts.into_par_iter().zip(poses).zip(minima);
        each.map(|((start, posed), minimum)| {
            start?;
            let minimum = minimum.expect("each start has a minimum");
            self.placed(&minimum, Vector3::zeros(), |positions| self.placement.apply(posed, positions))
        })
        .collect()
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
        let transferred = bound.frame(posed, start, &goals, place)?;
        for k in bound.foot_contacts.at(frame) {
            stands_at[k].get_or_insert_with(|| bound.foot_contacts.place(k, &transferred.positions));
        }
        self.before = Some([posed.to_vec(), transferred.positions.clone()]);
        Ok(transferred)
    }
}

/// What the steps of a pose start with.
struct Start {
    /// The gradients of the target's triangles (#F).
    field: Vec<Matrix3<f64>>,
    /// Those in which orphans continue their neighbours, where that is not `field`.
    continued: Option<Vec<Matrix3<f64>>>,
    /// b, where E5 draws the target.
    prior: Option<Vec<Point3<f64>>>,
}

impl Bound {
    /// What the steps of each pose of the source start with.
    fn starts(&self, poses: &[&[Point3<f64>]]) -> Vec<Result<Start>> {
        let check = |posed: &&[Point3<f64>]| {
            Error::check_shape("posed source vertices (#V)", self.field.source_vertices(), posed.len())?;
            check_finite(posed)
        };
        let checked: Vec<Result<()>> = poses.iter().map(check).collect();
        let sound: Vec<&[Point3<f64>]> =
            poses.iter().zip(&checked).filter(|(_, c)| c.is_ok()).map(|(p, _)| *p).collect();
        let mut priors = self.prior.as_ref().map(|prior| prior.positions(&sound).into_iter());
        let prior = |checked: Result<()>| {
            checked?;
            priors.as_mut().map(|priors| priors.next().expect("each pose has a prior")).transpose()
        };
        let priors: Vec<Result<Option<Vec<Point3<f64>>>>> = checked.into_iter().map(prior).collect();
        priors.into_par_iter().zip(poses).map(|(prior, posed)| Ok(self.start(posed, prior?))).collect()
    }

    /// What the steps of a pose start with, given the prior's result.
    fn start(&self, posed: &[Point3<f64>], mut prior: Option<Vec<Point3<f64>>>) -> Start {
        let mut field = self.field.at(posed);
        if !self.continue_neighbours {
            // Continuing their neighbours is E2 as well.
            (0..field.len()).filter(|&t| self.field.is_orphan(t)).for_each(|t| field[t] = Matrix3::identity());
        }
        let mut continued = None;
        if let (Some(prior), Some(b)) = (&self.prior, &mut prior) {
            self.placement.apply(posed, b);
            let mut before = field.clone();
            self.rigid.stiffen(&mut before);
            continued = Some(before);
            prior.fill(b, &mut field, |t| self.field.is_orphan(t));
        }
        self.rigid.stiffen(&mut field);
        Start { field, continued, prior }
    }

    /// The steps of a pose, which begin at `now`, or else at the prior's result.
    fn descent<'a>(&'a self, posed: &[Point3<f64>], start: &'a Start, now: Option<&[Point3<f64>]>) -> Descent<'a> {
        let (problem, first) = self.problem(posed, start, now);
        Descent::new(problem, first, self.max_steps, self.tolerance)
    }

    /// Takes the steps of poses to their ends, with each solve for all of them.
    fn descend(&self, mut descents: Vec<&mut Descent<'_>>) {
        loop {
            descents.retain(|descent| descent.asks().is_some());
            if descents.is_empty() {
                break;
            }
            let mut solutions: Vec<f64> =
                descents.iter().filter_map(|descent| descent.asks()).flatten().copied().collect();
            self.system.solve_in_place(&mut solutions);
            let solutions = solutions.par_chunks(solutions.len() / descents.len());
            descents.par_iter_mut().zip(solutions).for_each(|(descent, solution)| descent.advance(solution.to_vec()));
        }
    }

    /// The target at a frame of a motion, the steps starting from `now`, foot contacts held at `held`, and put in its place by `place`.
    fn frame(
        &self,
        posed: &[Point3<f64>],
        now: Option<&[Point3<f64>]>,
        held: &[(usize, Vector3<f64>)],
        place: impl FnOnce(&mut [Point3<f64>]),
    ) -> Result<Transferred> {
        let start = self.starts(&[posed]).pop().expect("one pose has one start")?;
        let mut descent = self.descent(posed, &start, now);
        self.descend(vec![&mut descent]);
        let mut minimum = descent.minimum();
        let mut shift = Vector3::zeros();
        if !held.is_empty() {
            shift = self.foot_contacts.hold(held, &self.system, &mut minimum.x);
            if held.len() > 1 && descent.problem.turns() {
                // Contacts bend the target, and what bends turns on. That is no more than a few steps away.
                let hold = |x: &mut Vec<f64>| self.foot_contacts.hold(held, &self.system, x);
                (minimum.energy, shift) = descent.problem.settle(&mut minimum.x, self.max_steps, self.tolerance, hold);
            }
        }
        self.placed(&minimum, shift, place)
    }

    /// The target where the steps of a pose ended, put in its place by `place`.
    fn placed(
        &self,
        minimum: &Minimum,
        shift: Vector3<f64>,
        place: impl FnOnce(&mut [Point3<f64>]),
    ) -> Result<Transferred> {
        let &Minimum { ref x, energy, steps, converged, movement } = minimum;
        let mut positions = self.system.positions(x);
        positions.iter_mut().for_each(|p| *p += shift);
        self.rigid.fit(&mut positions);
        place(&mut positions);
        check_finite(&positions)?;
        let mut figures = Figures::default();
        figures.set("steps", steps);
        figures.set("energy", energy);
        figures.set("converged", converged);
        if !converged {
            let still = if movement.is_finite() {
                format!("vertices have up to {:.3} % of the diagonal to go", 100.0 * movement)
            } else {
                "one step does not tell how far they are".into()
            };
            figures.warn(format!(
                "gaps and orphans had not come to rest when the steps ended (`max_steps: {}`): {still}; raise `max_steps`, or give \
                 markers to components that correspond to nothing",
                self.max_steps
            ));
        }
        Ok(Transferred { positions, figures })
    }

    /// The energy of a pose, and the directions to start from.
    fn problem<'a>(
        &'a self,
        posed: &[Point3<f64>],
        start: &'a Start,
        now: Option<&[Point3<f64>]>,
    ) -> (Problem<'a>, Directions) {
        let Start { field, continued, prior } = start;
        let continued = match self.continuation {
            Continuation::Gradients => Continued::Alike,
            Continuation::Rotations => Continued::As(continued.as_deref().unwrap_or(field)),
        };
        let prior = self.prior.as_ref().zip(prior.as_deref());
        let start = now.or(prior.map(|(_, b)| b));
        let similarity = &self.placement.alignment.target_from_source;
        let gaps = &self.gaps.gaps;
        let deformations = self.gaps.deformations(self.gaps_keep, field, self.field.source(), posed, similarity);
        let vector = |(gap, f): (&Gap, &Deformation)| {
            let known = gap.vector(self.gaps_keep, self.field.source(), posed, f, similarity);
            match prior {
                Some((_, b)) if gap.is_loose() => Some(b[gap.ends[0] as usize] - b[gap.ends[1] as usize]),
                _ => known,
            }
        };
        let known: Vec<Option<Vector3<f64>>> = gaps.iter().zip(&deformations).map(vector).collect();
        let first = |((gap, f), known): ((&Gap, &Deformation), &Option<Vector3<f64>>)| {
            let guess = f.turned * gap.rest;
            known.unwrap_or_else(|| start.map_or(guess, |start| gap.with_length(start, guess)))
        };
        let directions = Directions {
            vectors: gaps.iter().zip(&deformations).zip(&known).map(first).collect(),
            details: match start {
                Some(start) => self.system.details(start),
                None => self.system.turned_details(|v| self.rotation(v, field)),
            },
            goals: prior.map_or_else(Vec::new, |(_, b)| b.to_vec()),
        };
        let rhs = self.system.rhs(field, continued);
        let edge_goals = self.system.gradient_term.goals(field);
        (Problem { system: &self.system, gaps, field, edge_goals, continued, known, prior, rhs }, directions)
    }

    /// How the surface around a vertex has turned.
    fn rotation(&self, vertex: u32, field: &[Matrix3<f64>]) -> Matrix3<f64> {
        let mean: Matrix3<f64> = self.around[vertex as usize].iter().map(|&t| field[t as usize]).sum();
        if mean.norm() > 0.0 { polar(&mean).rotation } else { Matrix3::identity() }
    }
}
