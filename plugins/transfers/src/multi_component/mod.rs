//! Moves a target of many components as one.
//!
//! Zhou et al. 2010, section 2.3. Minimises over the posed target vertices x̃
//!
//! E = w1 E1 + w2 E2 + w3 E3 + w4 E4 (+ w5 E5),
//!
//! - E1 = Σ over triangles t that correspond: A_t ‖(R F̂_t Rᵀ − F_t) P_t‖² (eq. 6), with F̂_t as in `gradient`;
//! - E2 = Σ over orphans t and their neighbours u: A_tu ‖F_t − F_u‖² (eq. 7);
//! - E3 = Σ over gaps (i, j) of the proximity graph: ‖(x̃ᵢ − x̃ⱼ) − t_ij‖², where ‖t_ij‖ is the length at rest and the direction
//!   that of now (eq. 8), or t_ij is known ([`Gaps`]);
//! - E4 = Σ over orphan components: ‖L x̃ − δ̂‖², directions from now, lengths from rest (eq. 9);
//! - w5 E5, with `initial`: how far another transfer's result is (prior.rs). Gaps and gradients of orphans are then its own.
//!
//! With directions held within a step, as Gauss and Newton do, the matrix is constant: it is factored once, and a step is a
//! pair of triangular solves. Each step minimises a quadratic that lies above the energy and touches it, so the energy never
//! rises.
//!
//! Departures: triangles count by area (A), so that all terms are squared lengths and weights mean the same at any size and
//! density; E2 of orphans next to triangles that correspond uses those triangles' F̂, which is known; gaps follow the source where
//! both ends correspond, because the paper's lengths fight intended relative motion; components can be rigid, and orphans are
//! unless asked otherwise.

mod bound;
mod gaps;
mod plants;
mod prior;
mod rigid;
mod system;

use mimesh_core::{
    Error, Result, register,
    spatial::Orientation,
    stage::{BoundTransfer, ComponentRef, Transfer, TransferPair, TriangleMap},
};
use nalgebra::Point3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use self::{bound::Bound, gaps::Gap, plants::Plants, prior::Prior, rigid::Rigid, system::System};
pub use self::{gaps::Gaps, plants::Plant};
use crate::{Placement, alignment::Alignment, field::Field, gradient::Sampling, unreferenced::Unreferenced};

register!(Transfer: MultiComponent);

/// Moves a target of many components as one: deformation gradients within components, gaps between them (Zhou et al. 2010).
///
/// Needs `proximity:`. Works on connected targets too, where it is least squares `gradient`.
#[derive(Debug, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct MultiComponent {
    /// How the terms of the energy count against each other.
    pub weights: Weights,
    /// Another transfer, as `biharmonic`, from whose result the steps start, and to which the target is held (`weights.prior`);
    /// components that correspond to nothing take their shape and gaps from it. `null` for none.
    pub initial: Option<Box<dyn Transfer>>,
    /// σ, in diagonals of the target: vertices that come to lie farther than this from `initial` are hardly held to it. (Those
    /// of components that correspond to nothing always are.)
    #[schemars(range(min = 1e-6))]
    pub trust: f64,
    /// What gaps keep.
    pub gaps: Gaps,
    /// Components that move rigidly, by number or by the name of an object, group or material, e.g. eyeballs and teeth; `[all]`
    /// for stones and robots.
    pub rigid: Vec<ComponentRef>,
    /// What becomes of components that correspond to nothing.
    pub orphans: Orphans,
    /// Whether poses are frames of one motion: the steps of each then start from the frame before, so that what gaps and
    /// orphans leave open does not jump. Else every pose stands alone.
    pub sequence: bool,
    /// Feet that stand still for some frames; poses are then frames of one motion.
    pub plants: Vec<Plant>,
    /// Where the deformation of a target triangle is taken from.
    pub sampling: Sampling,
    /// Most steps a pose; they are needed only for gaps of which the length alone is known, and for orphan components.
    #[schemars(range(min = 1, max = 10000))]
    pub max_steps: usize,
    /// Steps end once one lowers the energy by less than this part of it; with `initial`, once what the target is held to moves by
    /// less than this part of the diagonal.
    #[schemars(range(min = 0.0))]
    pub tolerance: f64,
    /// What fixes the global translation.
    pub placement: Placement,
    /// How source and target are turned to each other at rest.
    pub orientation: Orientation,
}

impl Default for MultiComponent {
    fn default() -> Self {
        Self {
            weights: Weights::default(),
            initial: None,
            trust: 0.01,
            gaps: Gaps::Follow,
            rigid: vec![],
            orphans: Orphans::Rigid,
            sequence: false,
            plants: vec![],
            sampling: Sampling::Points,
            max_steps: 100,
            tolerance: 1e-4,
            placement: Placement::Motion,
            orientation: Orientation::Auto,
        }
    }
}

/// What becomes of a component that corresponds to nothing, so that only its gaps move it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Orphans {
    /// It moves rigidly, as its gaps have it: nothing says how it should bend.
    #[default]
    Rigid,
    /// It bends and stretches between its gaps as E2 and E4 allow, as in the paper.
    Soft,
}

/// How the terms of the energy count against each other; the defaults are the paper's.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Weights {
    /// w1: deformation gradients of triangles that correspond.
    #[schemars(range(min = 1e-12))]
    pub gradient: f64,
    /// w2: smoothness of orphan triangles. At 0 they hold their edges at rest, as weakly as will do.
    #[schemars(range(min = 0.0))]
    pub smoothness: f64,
    /// w3: gaps between components, for each pair of vertices.
    #[schemars(range(min = 1e-12))]
    pub gaps: f64,
    /// w4: Laplacian details of orphan components.
    #[schemars(range(min = 0.0))]
    pub details: f64,
    /// w5: how strongly the target is held to `initial`. Detail smaller than about the diagonal over √w5 is as without; at 0 the
    /// steps only start there.
    #[schemars(range(min = 0.0))]
    pub prior: f64,
}

impl Default for Weights {
    fn default() -> Self {
        Self { gradient: 1.0, smoothness: 1.0, gaps: 0.1, details: 1.0, prior: 3.0 }
    }
}

#[typetag::serde(name = "multi_component")]
impl Transfer for MultiComponent {
    fn bind(&self, pair: TransferPair<'_>, map: &TriangleMap) -> Result<Box<dyn BoundTransfer>> {
        self.bind_to_poses(pair, map, &[])
    }

    fn poses_wanted(&self) -> usize {
        self.initial.as_ref().map_or(0, |initial| initial.poses_wanted())
    }

    fn bind_to_poses(
        &self,
        pair: TransferPair<'_>,
        map: &TriangleMap,
        poses: &[Vec<Point3<f64>>],
    ) -> Result<Box<dyn BoundTransfer>> {
        self.check(pair)?;
        map.check(pair)?;
        let target = pair.target;
        let alignment = Alignment::new(pair, map, self.orientation);
        let similarity = alignment.target_from_source;
        let bridges = bridges(pair);
        let field = Field::new(pair, map, similarity.rotation, self.sampling == Sampling::Points, &bridges)?;
        let gaps = Gap::all(pair, map, self.weights.gaps, |t| field.is_orphan(t))?;

        let components = target.components();
        let mut orphan_component = vec![true; components.count()];
        for (t, corners) in target.triangles.iter().enumerate() {
            if let (false, Some(c)) = (field.is_orphan(t), components.of_vertex[corners[0] as usize]) {
                orphan_component[c as usize] = false;
            }
        }
        let is_orphan_vertex = |v: u32| components.of_vertex[v as usize].is_some_and(|c| orphan_component[c as usize]);
        let prior = match &self.initial {
            Some(initial) => {
                Some(Prior::new(&**initial, pair, map, poses, [self.weights.prior, self.trust], is_orphan_vertex)?)
            }
            None => None,
        };
        let held = prior.as_ref().map_or(&[][..], |prior| &prior.weights);
        let system = System::new(target, &gaps, self.weights, held, |t| field.is_orphan(t), is_orphan_vertex)?;
        let orphans: Vec<usize> = (0..orphan_component.len()).filter(|&c| orphan_component[c]).collect();
        let stiff: &[usize] = if self.orphans == Orphans::Rigid { &orphans } else { &[] };
        let rigid = Rigid::new(target, &self.rigid, stiff)?;
        let placement = self.placement.bind(pair, map, alignment)?;
        let plants = Plants::new(pair, &self.plants, &system)?;

        let mut figures = crate::gradient::figures(&similarity);
        figures.set("components", components.count());
        figures.set("orphan_components", orphans.len());
        if !orphans.is_empty() {
            figures.warn(format!(
                "{} of {} components correspond to nothing on the source and only follow {}: {}; give them markers, or let \
                 the correspondence reach farther",
                orphans.len(),
                orphan_component.len(),
                if self.initial.is_some() { "`initial`" } else { "their neighbours" },
                target.describe_components(&components, &orphans)
            ));
        }
        figures.set("orphan_triangles", field.counts()[2]);
        figures.set("gaps", gaps.len());
        figures.set("gaps_of_known_length_only", gaps.iter().filter(|gap| gap.is_loose()).count());
        figures.set("rigid_components", rigid.count());
        let around = target.triangles_around();
        Ok(Box::new(Bound {
            gaps_keep: self.gaps,
            continue_neighbours: self.weights.smoothness > 0.0,
            sequence: self.sequence,
            max_steps: self.max_steps,
            tolerance: self.tolerance,
            prior,
            field,
            gaps,
            system,
            rigid,
            plants,
            placement,
            loose: Unreferenced::new(target),
            around,
            figures,
        }))
    }

    fn check(&self, pair: TransferPair<'_>) -> Result<()> {
        let Weights { gradient, smoothness, gaps, details, prior } = self.weights;
        Error::check_setting("weights.gradient", gradient, 1e-12, f64::INFINITY)?;
        Error::check_setting("weights.smoothness", smoothness, 0.0, f64::INFINITY)?;
        Error::check_setting("weights.gaps", gaps, 1e-12, f64::INFINITY)?;
        Error::check_setting("weights.details", details, 0.0, f64::INFINITY)?;
        Error::check_setting("weights.prior", prior, 0.0, f64::INFINITY)?;
        Error::check_setting("trust", self.trust, 1e-6, f64::INFINITY)?;
        if let Some(initial) = &self.initial {
            initial.check(pair).map_err(|error| match error {
                Error::Data { message, hint } => Error::Data { message: format!("initial: {message}"), hint },
                other => other,
            })?;
        }
        Error::check_setting("max_steps", self.max_steps as f64, 1.0, 10_000.0)?;
        Error::check_setting("tolerance", self.tolerance, 0.0, 1.0)?;
        let components = pair.target.components();
        for component in &self.rigid {
            component.resolve(pair.target, &components)?;
        }
        Plants::check(pair, &self.plants)?;
        if !self.plants.is_empty() && !matches!(self.placement, Placement::Motion | Placement::Markers) {
            return Err(Error::data(
                "`plants` and `placement` both say what stands still",
                "leave out one of them: between plants, `placement: motion` or `placement: markers` moves the target",
            ));
        }
        match pair.proximity {
            Some(graph) => graph.check(pair.target),
            None if components.count() <= 1 => Ok(()),
            None => Err(Error::data(
                format!("the target has {} components and nothing says how they lie to each other", components.count()),
                "add `proximity: { type: spanning_tree }` to the pipeline",
            )),
        }
    }
}

/// Triangles at the ends of gaps, over which orphans continue their neighbours as a first guess.
fn bridges(pair: TransferPair<'_>) -> Vec<[u32; 2]> {
    let Some(graph) = pair.proximity else { return vec![] };
    let around = pair.target.triangles_around();
    let bridge = |[i, j]: [u32; 2]| Some([*around[i as usize].first()?, *around[j as usize].first()?]);
    graph.pairs().filter_map(bridge).collect()
}
