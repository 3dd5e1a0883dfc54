//! Moves a target of many components as one.
//!
//! Zhou et al. 2010, section 2.3. Minimises over the posed target vertices x̃
//!
//! E = w1 E1 + w2 E2 + w3 E3 + w4 E4,
//!
//! - E1 = Σ over triangles t that correspond: A_t ‖(R F̂_t Rᵀ − F_t) P_t‖² (eq. 6), with F̂_t as in `gradient`;
//! - E2 = Σ over orphans t and their neighbours u: A_tu ‖F_t − F_u‖² (eq. 7);
//! - E3 = Σ over gaps (i, j) of the proximity graph: ‖(x̃ᵢ − x̃ⱼ) − t_ij‖², where ‖t_ij‖ is the length at rest and the direction
//!   that of now (eq. 8), or t_ij is known ([`Gaps`]);
//! - E4 = Σ over orphan components: ‖L x̃ − δ̂‖², directions from now, lengths from rest (eq. 9).
//!
//! With directions held within a step, as Gauss and Newton do, the matrix is constant: it is factored once, and a step is a
//! pair of triangular solves. Each step minimises a quadratic that lies above the energy and touches it, so the energy never
//! rises.
//!
//! Departures: triangles count by area (A), so that all terms are squared lengths and weights mean the same at any size and
//! density; E2 of orphans next to triangles that correspond uses those triangles' F̂, which is known; gaps follow the source where
//! both ends correspond, because the paper's lengths fight intended relative motion; components can be rigid.

mod gaps;
mod rigid;
mod system;

use mimesh_core::{
    Error, Figures, Result,
    mesh::check_finite,
    operators::polar,
    register,
    spatial::Orientation,
    stage::{BoundTransfer, ComponentRef, Pair, Transfer, Transferred, TriangleMap},
};
use nalgebra::{Matrix3, Point3, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use self::gaps::Gaps;
use self::{gaps::Gap, rigid::Rigid, system::System};
use crate::{
    Placement, alignment::Alignment, field::Field, gradient::Sampling, loose::Loose, placement::BoundPlacement,
};

register!(Transfer: MultiComponent);

/// Moves a target of many components as one: deformation gradients within components, gaps between them (Zhou et al. 2010).
///
/// Needs `proximity:`. Works on connected targets too, where it is least squares `gradient`.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct MultiComponent {
    /// How the terms of the energy count against each other.
    pub weights: Weights,
    /// What gaps keep.
    pub gaps: Gaps,
    /// Components that move rigidly, by number or by the name of an object, group or material, e.g. eyeballs and teeth.
    pub rigid: Vec<ComponentRef>,
    /// Where the deformation of a target triangle is taken from.
    pub sampling: Sampling,
    /// Most steps a pose; they are needed only for gaps of which the length alone is known, and for orphan components.
    #[schemars(range(min = 1, max = 10000))]
    pub max_steps: usize,
    /// Steps end once one lowers the energy by less than this part of it.
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
            gaps: Gaps::Follow,
            rigid: vec![],
            sampling: Sampling::Points,
            max_steps: 100,
            tolerance: 1e-4,
            placement: Placement::Motion,
            orientation: Orientation::Auto,
        }
    }
}

/// How the terms of the energy count against each other; the defaults are the paper's.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Weights {
    /// w1: deformation gradients of triangles that correspond.
    #[schemars(range(min = 1e-12))]
    pub gradient: f64,
    /// w2: smoothness of orphan triangles.
    #[schemars(range(min = 0.0))]
    pub smoothness: f64,
    /// w3: gaps between components, for each pair of vertices.
    #[schemars(range(min = 1e-12))]
    pub gaps: f64,
    /// w4: Laplacian details of orphan components.
    #[schemars(range(min = 0.0))]
    pub details: f64,
}

impl Default for Weights {
    fn default() -> Self {
        Self { gradient: 1.0, smoothness: 1.0, gaps: 0.1, details: 1.0 }
    }
}

#[typetag::serde(name = "multi_component")]
impl Transfer for MultiComponent {
    fn bind(&self, pair: Pair<'_>, map: &TriangleMap) -> Result<Box<dyn BoundTransfer>> {
        self.check(pair)?;
        map.check(pair)?;
        let target = pair.target;
        let alignment = Alignment::new(pair, map, self.orientation);
        let similarity = alignment.target_from_source;
        let bridges = bridges(pair);
        let field = Field::new(pair, map, similarity.rotation, self.sampling == Sampling::Points, &bridges)?;
        let gaps = Gap::all(pair, map, self.weights.gaps, |t| field.is_orphan(t));

        let components = target.components();
        let mut orphan_component = vec![true; components.count()];
        for (t, corners) in target.triangles.iter().enumerate() {
            if let (false, Some(c)) = (field.is_orphan(t), components.of_vertex[corners[0] as usize]) {
                orphan_component[c as usize] = false;
            }
        }
        let is_orphan_vertex = |v: u32| components.of_vertex[v as usize].is_some_and(|c| orphan_component[c as usize]);
        let system = System::new(target, &gaps, self.weights, |t| field.is_orphan(t), is_orphan_vertex)?;
        let rigid = Rigid::new(target, &self.rigid)?;
        let placement = self.placement.bind(pair, map, alignment)?;

        let mut figures = crate::gradient::figures(&similarity);
        figures.set("components", components.count());
        figures.set("orphan_components", orphan_component.iter().filter(|o| **o).count());
        figures.set("orphan_triangles", field.counts()[2]);
        figures.set("gaps", gaps.len());
        figures.set("rigid_components", rigid.count());
        let around = target.triangles_around();
        Ok(Box::new(Bound {
            settings: self.clone(),
            field,
            gaps,
            system,
            rigid,
            placement,
            loose: Loose::new(target),
            around,
            figures,
        }))
    }

    fn check(&self, pair: Pair<'_>) -> Result<()> {
        let Weights { gradient, smoothness, gaps, details } = self.weights;
        Error::check_setting("weights.gradient", gradient, 1e-12, f64::INFINITY)?;
        Error::check_setting("weights.smoothness", smoothness, 0.0, f64::INFINITY)?;
        Error::check_setting("weights.gaps", gaps, 1e-12, f64::INFINITY)?;
        Error::check_setting("weights.details", details, 0.0, f64::INFINITY)?;
        Error::check_setting("max_steps", self.max_steps as f64, 1.0, 10_000.0)?;
        Error::check_setting("tolerance", self.tolerance, 0.0, 1.0)?;
        let components = pair.target.components();
        for component in &self.rigid {
            component.resolve(pair.target, &components)?;
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
fn bridges(pair: Pair<'_>) -> Vec<[u32; 2]> {
    let Some(graph) = pair.proximity else { return vec![] };
    let around = pair.target.triangles_around();
    let bridge = |[i, j]: [u32; 2]| Some([*around[i as usize].first()?, *around[j as usize].first()?]);
    graph.pairs().filter_map(bridge).collect()
}

#[derive(Debug)]
struct Bound {
    settings: MultiComponent,
    field: Field,
    gaps: Vec<Gap>,
    system: System,
    rigid: Rigid,
    placement: BoundPlacement,
    loose: Loose,
    around: Vec<Vec<u32>>,
    figures: Figures,
}

impl BoundTransfer for Bound {
    fn transfer(&self, posed: &[Point3<f64>]) -> Result<Transferred> {
        Error::check_shape("posed source vertices (#V)", self.field.source_vertices(), posed.len())?;
        check_finite(posed)?;
        let mut field = self.field.at(posed);
        self.rigid.stiffen(&mut field);
        let known: Vec<Option<Vector3<f64>>> = self.known_gaps(posed, &field);
        let rhs = self.system.rhs(&field);

        let mut vectors: Vec<_> =
            self.gaps.iter().zip(&known).map(|(gap, known)| known.unwrap_or_else(|| gap.first_guess(&field))).collect();
        let mut details = self.system.turned_details(|v| self.rotation(v, &field));
        let mut energies = Vec::new();
        let iterates = self.system.has_details() || known.iter().any(Option::is_none);
        let mut positions;
        loop {
            let x = self.system.solve(&rhs, &self.gaps, &vectors, &details);
            positions = self.system.positions(&x);
            let energy = self.system.energy(&x, &field) + self.gap_energy(&known, &positions);
            let settled = energies.last().is_some_and(|last| last - energy <= self.settings.tolerance * last);
            energies.push(energy);
            if !iterates || settled || energies.len() == self.settings.max_steps {
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
        self.placement.apply(posed, &mut positions);
        self.loose.place(|t| field[t], &mut positions);
        check_finite(&positions)?;
        let mut figures = Figures::default();
        figures.set("steps", energies.len());
        figures.set("energy", energies[energies.len() - 1]);
        Ok(Transferred { positions, figures })
    }

    fn figures(&self) -> Figures {
        self.figures.clone()
    }
}

impl Bound {
    fn known_gaps(&self, posed: &[Point3<f64>], field: &[Matrix3<f64>]) -> Vec<Option<Vector3<f64>>> {
        let similarity = &self.placement.alignment.target_from_source;
        let vector = |gap: &Gap| gap.vector(self.settings.gaps, self.field.source(), posed, field, similarity);
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
