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
//! With directions held within a step, the matrix is constant: it is factored once, and a step is a pair of triangular solves.
//! Each step minimises a quadratic that lies above the energy and touches it, so the energy never rises. Such steps alone turn
//! a long chain of orphans slowly, so conjugate gradients on the Gauss-Newton model go on from them, with that matrix as the
//! preconditioner (minimum.rs).
//!
//! Departures: triangles count by area (A), so that all terms are squared lengths and weights mean the same at any size and
//! density (`term_weights.areas: false` for the paper); E2 asks for gradients that are equal relative to a blend of the shores'
//! rigid motions, because equal gradients collapse what is twisted (`continuation: gradients` for the paper); E2 of orphans next to triangles that correspond uses those triangles' F̂, which is known; gaps follow the source where
//! both ends correspond, because the paper's lengths fight intended relative motion; components can be rigid, and orphans are
//! unless asked otherwise.

mod bound;
mod detail_term;
mod foot_contacts;
mod gaps;
mod gradient_term;
mod joints;
mod minimum;
mod prior;
mod rigid;
mod sideways;
mod system;
mod term_weights;
mod tetrahedra;

use mimesh_core::{
    Error, Result,
    plugin::check_ranges,
    register,
    spatial::Orientation,
    stage::{BindInput, BoundTransfer, ComponentRef, Transfer, TransferPair},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use self::{bound::Bound, foot_contacts::FootContacts, gaps::AllGaps, prior::Prior, rigid::Rigid, system::System};
pub use self::{foot_contacts::FootContact, gaps::Gaps, term_weights::TermWeights};
use crate::{Continuation, Placement, alignment::Alignment, extension::OrphanRule, field::Field, gradient::Sampling};

/// Triangles of less area than this part of the mean tie orphans to their neighbours as strongly as if they had it.
const MIN_RELATIVE_AREA: f64 = 1e-6;

register!(Transfer: MultiComponent);

/// Moves a target of many components as one: deformation gradients within components, gaps between them (Zhou et al. 2010).
///
/// Needs `proximity:`. Works on connected targets too, where it is least squares `gradient`.
#[derive(Debug, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
#[schemars(extend("x-renamed" = { "weights": "term_weights" }))]
pub struct MultiComponent {
    /// How the terms of the energy count against each other.
    pub term_weights: TermWeights,
    /// Another transfer, as `biharmonic`, from whose result the steps start, and to which the target is held (`term_weights.prior`);
    /// components that correspond to nothing take their shape and gaps from it. `null` for none. For `biharmonic` its `weights`
    /// default to `biharmonic` here: a prior needs no bounds, without which they take a fraction of the time.
    #[schemars(extend("x-defaults" = { "biharmonic": { "weights": { "type": "biharmonic" } } }))]
    pub initial: Option<Box<dyn Transfer>>,
    /// σ, in diagonals of the target: vertices that come to lie farther than this from `initial` are hardly held to it. (Those
    /// of components that correspond to nothing always are.)
    #[schemars(range(min = 1e-6))]
    #[serde(rename = "trust")]
    pub prior_radius: f64,
    /// The property that gaps keep.
    pub gaps: Gaps,
    /// Components that move rigidly, by number or by the name of an object, group or material, e.g. eyeballs and teeth; `[all]`
    /// for pebbles and robots.
    pub rigid: Vec<ComponentRef>,
    /// The motion of components that correspond to nothing.
    pub orphans: Orphans,
    /// Whether poses are frames of one motion: the steps of each then start from the frame before, so that what gaps and
    /// orphans leave open does not jump. Else every pose stands alone.
    pub sequence: bool,
    /// Feet that stand still for some frames; poses are then frames of one motion.
    #[serde(rename = "plants")]
    pub foot_contacts: Vec<FootContact>,
    /// The origin of the deformation of a target triangle.
    pub sampling: Sampling,
    /// How triangles that correspond to nothing continue the deformation of their neighbours (E2).
    pub continuation: Continuation,
    /// Most steps (solves) a pose; they are needed only for gaps of which the length alone is known, and for orphan components.
    #[schemars(range(min = 1, max = 10000))]
    pub max_steps: usize,
    /// Steps end once no vertex has farther to go than this part of the diagonal, by the Gauss-Newton model of the energy.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub tolerance: f64,
    /// The rule that fixes the global translation.
    pub placement: Placement,
    /// How source and target are turned to each other at rest.
    pub orientation: Orientation,
}

impl Default for MultiComponent {
    fn default() -> Self {
        Self {
            term_weights: TermWeights::default(),
            initial: None,
            prior_radius: 0.01,
            gaps: Gaps::Follow,
            rigid: vec![],
            orphans: Orphans::Rigid,
            sequence: false,
            foot_contacts: vec![],
            sampling: Sampling::Points,
            continuation: Continuation::Rotations,
            max_steps: 500,
            tolerance: 1e-4,
            placement: Placement::Motion,
            orientation: Orientation::Auto,
        }
    }
}

/// The motion of a component that corresponds to nothing, so that only its gaps move it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Orphans {
    /// It moves rigidly, as its gaps have it: nothing says how it should bend.
    #[default]
    Rigid,
    /// It bends and stretches between its gaps as E2 and E4 allow, as in the paper.
    Soft,
}

#[typetag::serde(name = "multi_component")]
impl Transfer for MultiComponent {
    fn markers_needed(&self) -> usize {
        self.initial.as_ref().map_or(0, |initial| initial.markers_needed())
    }

    fn gives_motion(&self) -> bool {
        self.sequence || !self.foot_contacts.is_empty()
    }

    fn poses_wanted(&self) -> usize {
        self.initial.as_ref().map_or(0, |initial| initial.poses_wanted())
    }

    fn bind(&self, input: BindInput<'_>) -> Result<Box<dyn BoundTransfer>> {
        let pair = input.pair;
        self.check(pair)?;
        let map = input.require_map()?;
        let target = pair.target;
        let alignment = Alignment::new(pair, map, self.orientation);
        let similarity = alignment.target_from_source;
        let bridges = bridges(pair);
        let areas: Vec<f64> = target.area_normals(&target.positions).iter().map(|normal| normal.norm() / 2.0).collect();
        // Triangles without area are tied to their neighbours, if weakly.
        let least = MIN_RELATIVE_AREA * areas.iter().sum::<f64>() / areas.len().max(1) as f64;
        let orphan = |t: u32| map.triangles[t as usize].is_none();
        let weight = |a: u32, b: u32| {
            let of_pair = [a, b].map(|t| areas[t as usize].max(least));
            self.term_weights.of_pair(of_pair, orphan(a) && orphan(b))
        };
        let rule = OrphanRule { continuation: self.continuation, bridges: &bridges, weight: &weight };
        let field = Field::new(pair, map, similarity.rotation, self.sampling == Sampling::Points, rule)?;
        let is_linear = self.gaps == Gaps::Tetrahedra;
        let gaps = if is_linear {
            AllGaps::none()
        } else {
            AllGaps::new(pair, map, self.term_weights.gaps, |t| field.is_orphan(t), &similarity)?
        };

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
                Some(Prior::new(&**initial, input, [self.term_weights.prior, self.prior_radius], is_orphan_vertex)?)
            }
            None => None,
        };
        let held = prior.as_ref().map_or(&[][..], |prior| &prior.weights);
        let spanned = pair.proximity.filter(|_| is_linear);
        let details = if is_linear { 0.0 } else { self.term_weights.details };
        let weights = TermWeights { details, ..self.term_weights };
        let system = System::new(target, &gaps.gaps, spanned, weights, held, |t| field.is_orphan(t), is_orphan_vertex)?;
        let orphans: Vec<usize> = (0..orphan_component.len()).filter(|&c| orphan_component[c]).collect();
        let stiff: &[usize] = if self.orphans == Orphans::Rigid { &orphans } else { &[] };
        let rigid = Rigid::new(target, &self.rigid, stiff)?;
        let mut figures = crate::gradient::figures(&alignment);
        let placement = self.placement.bind(pair, alignment)?;
        let foot_contacts = FootContacts::new(pair, &self.foot_contacts, &system)?;

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
        figures.set("gaps", gaps.gaps.len());
        figures.set("gaps_of_known_length_only", gaps.gaps.iter().filter(|gap| gap.is_loose()).count());
        figures.set("rigid_components", rigid.count());
        let around = target.triangles_around();
        Ok(Box::new(Bound {
            gaps_keep: self.gaps,
            continuation: self.continuation,
            continue_neighbours: self.term_weights.smoothness > 0.0,
            sequence: self.sequence,
            max_steps: self.max_steps,
            tolerance: self.tolerance,
            prior,
            field,
            gaps,
            system,
            rigid,
            foot_contacts,
            placement,
            around,
            figures,
        }))
    }

    fn check(&self, pair: TransferPair<'_>) -> Result<()> {
        check_ranges(self)?;
        if let Some(initial) = &self.initial {
            initial.check(pair).map_err(|error| match error {
                Error::Data { message, hint } => Error::Data { message: format!("initial: {message}"), hint },
                other => other,
            })?;
        }
        let components = pair.target.components();
        for component in &self.rigid {
            component.resolve(pair.target, &components)?;
        }
        FootContacts::check(pair, &self.foot_contacts)?;
        if !self.foot_contacts.is_empty()
            && !matches!(self.placement, Placement::Motion | Placement::Markers | Placement::Marker(_))
        {
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
