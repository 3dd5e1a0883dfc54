//! Carries deformation gradients from the source to a connected target.
//!
//! Minimises over the posed target vertices x̃
//!
//! E = Σ over target triangles t: w_t ρ(‖(R F̂_t Rᵀ − F_t) P_t‖)
//!
//! where F̂_t is what the source does at t, R turns the axes of the source to those of the target, and P_t projects onto the
//! plane of t: Sumner and Popović 2004, eq. 7, in the 3 × 2 edge form of Botsch et al. 2006.
//!
//! Departures: F̂_t comes from the source points under the corners of t where the correspondence knows them
//! (`sampling: triangles` for the paper's); triangles count by area (`weighting: uniform` for the paper's); ρ is nearly the
//! absolute value (`reweightings: 0` for the paper's square), because gradients of a bent joint never fit a limb of other
//! proportions, and squares make the whole limb pay for it; orphans continue their neighbours; the translation, which the
//! paper leaves open, follows [`Placement`].
//!
//! Cost: one factorisation of a matrix of #V of the target, then a numeric factorisation and three triangular solves a pose
//! and reweighting.

use mimesh_core::{
    Error, Figures, Result,
    mesh::check_finite,
    plugin::check_ranges,
    register,
    spatial::Orientation,
    stage::{BindInput, BoundTransfer, Transfer, TransferPair, Transferred},
};
use nalgebra::{Matrix3, Point3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{
    Continuation, Placement,
    alignment::Alignment,
    extension::OrphanRule,
    field::Field,
    placement::BoundPlacement,
    poisson::{Fit, Poisson, Solution},
};

register!(Transfer: GradientTransfer);

/// Carries the deformation gradients of the source to the target (Sumner and Popović 2004).
///
/// It takes targets of one connected piece.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct GradientTransfer {
    /// The origin of the deformation of a target triangle.
    pub sampling: Sampling,
    /// How triangles of the target count against each other.
    pub weighting: Weighting,
    /// How often triangles are reweighted at most. 0 is the paper's least squares, which spreads what does not fit over all
    /// triangles; a few steps leave it where it arises, as at bent joints, at some twice the time a step.
    #[schemars(range(max = 100))]
    pub reweightings: usize,
    /// ε: how far from the source's a deformation gradient may be (Frobenius norm) before its triangle counts less.
    #[schemars(range(min = 1e-6))]
    pub tolerance: f64,
    /// How triangles that correspond to nothing continue the deformation of their neighbours.
    pub continuation: Continuation,
    /// The rule that fixes the global translation.
    pub placement: Placement,
    /// How source and target are turned to each other at rest.
    pub orientation: Orientation,
}

impl Default for GradientTransfer {
    fn default() -> Self {
        Self {
            sampling: Sampling::Points,
            weighting: Weighting::Area,
            reweightings: 5,
            tolerance: 0.02,
            continuation: Continuation::Rotations,
            placement: Placement::Motion,
            orientation: Orientation::Auto,
        }
    }
}

/// The origin of the deformation of a target triangle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Sampling {
    /// The source points under its three corners where they are known, else its partner.
    #[default]
    Points,
    /// Its partner, as in the paper.
    Triangles,
}

/// How triangles of the target count against each other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Weighting {
    /// By area: the result does not depend on how finely a region is meshed.
    #[default]
    Area,
    /// All the same, as in the paper.
    Uniform,
}

#[typetag::serde(name = "gradient")]
impl Transfer for GradientTransfer {
    fn bind(&self, input: BindInput<'_>) -> Result<Box<dyn BoundTransfer>> {
        let pair = input.pair;
        self.check(pair)?;
        let map = input.require_map()?;
        let alignment = Alignment::new(pair, map, self.orientation);
        let similarity = alignment.target_from_source;
        let orphans = OrphanRule { continuation: self.continuation, bridges: &[], weight: &|_, _| 1.0 };
        let field = Field::new(pair, map, similarity.rotation, self.sampling == Sampling::Points, orphans)?;
        let poisson = Poisson::new(pair.target, |area| match self.weighting {
            Weighting::Area => area,
            Weighting::Uniform => 1.0,
        })?;
        let figures = figures(&alignment);
        let placement = self.placement.bind(pair, alignment)?;
        Ok(Box::new(Bound { settings: self.clone(), field, poisson, placement, figures }))
    }

    fn check(&self, pair: TransferPair<'_>) -> Result<()> {
        check_ranges(self)?;
        check_connected(pair)
    }
}

fn check_connected(pair: TransferPair<'_>) -> Result<()> {
    let components = pair.target.components();
    if components.count() <= 1 {
        return Ok(());
    }
    let largest = (0..components.count()).max_by_key(|&c| components.sizes[c]).unwrap_or(0);
    let loose: Vec<_> = (0..components.count()).filter(|&c| c != largest).collect();
    Err(Error::data(
        format!(
            "the target has {} components, and gradients say nothing of how they lie to each other; beside the largest: {}",
            components.count(),
            pair.target.describe_components(&components, &loose)
        ),
        "use `proximity: { type: spanning_tree }` and `transfer: { type: multi_component }`, or join or remove the loose parts",
    ))
}

/// How the pair lies to each other, in a reader's words.
pub(crate) fn figures(alignment: &Alignment) -> Figures {
    let target_from_source = &alignment.target_from_source;
    let mut figures = Figures::default();
    figures.set("size_ratio", target_from_source.scale);
    figures.set("turned_degrees", target_from_source.angle_degrees());
    if let Some(oriented) = &alignment.oriented {
        figures.set("orientation", oriented.taken.name());
        figures.set("fitted_degrees_from_axes", oriented.degrees_from_axes);
    }
    if !(0.2..=5.0).contains(&target_from_source.scale) {
        figures.warn(format!(
            "the target is {:.3} times the size of the source; nothing is wrong with that, but look whether the units are meant",
            target_from_source.scale
        ));
    }
    figures
}

#[derive(Debug)]
struct Bound {
    settings: GradientTransfer,
    field: Field,
    poisson: Poisson,
    placement: BoundPlacement,
    figures: Figures,
}

impl BoundTransfer for Bound {
    fn transfer(&self, posed: &[Point3<f64>]) -> Result<Transferred> {
        self.transfer_all(&[posed]).pop().expect("one pose has one result")
    }

    fn at_once(&self) -> usize {
        self.poisson.at_once()
    }

    fn bytes(&self, poses: usize) -> u64 {
        self.poisson.bytes(poses)
    }

    fn transfer_all(&self, poses: &[&[Point3<f64>]]) -> Vec<Result<Transferred>> {
        let fields: Vec<Result<Vec<Matrix3<f64>>>> = poses.iter().map(|posed| self.field(posed)).collect();
        let sound: Vec<&[Matrix3<f64>]> = fields.iter().flatten().map(Vec::as_slice).collect();
        let fit = Fit { steps: self.settings.reweightings, epsilon: self.settings.tolerance };
        let mut solutions = self.poisson.solve_all(&sound, fit).into_iter();
        let transferred = |(field, posed): (Result<Vec<Matrix3<f64>>>, &&[Point3<f64>])| {
            field?;
            self.placed(solutions.next().expect("each field has a solution")?, posed)
        };
        fields.into_iter().zip(poses).map(transferred).collect()
    }

    fn figures(&self) -> Figures {
        let mut figures = self.figures.clone();
        let [points, partners, orphans] = self.field.counts();
        figures.set("triangles_by_points", points);
        figures.set("triangles_by_partner", partners);
        figures.set("orphan_triangles", orphans);
        figures
    }
}

impl Bound {
    /// The gradients that the target's triangles should take when the source is at `posed`.
    fn field(&self, posed: &[Point3<f64>]) -> Result<Vec<Matrix3<f64>>> {
        Error::check_shape("posed source vertices (#V)", self.field.source_vertices(), posed.len())?;
        check_finite(posed)?;
        Ok(self.field.at(posed))
    }

    fn placed(&self, mut solution: Solution, posed: &[Point3<f64>]) -> Result<Transferred> {
        self.placement.apply(posed, &mut solution.positions);
        check_finite(&solution.positions)?;
        let mut figures = Figures::default();
        figures.set("gradient_residual", solution.residual);
        figures.set("energy", solution.energies[solution.energies.len() - 1]);
        figures.set("solves", solution.energies.len());
        Ok(Transferred { positions: solution.positions, figures })
    }
}
